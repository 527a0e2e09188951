/* SPDX-License-Identifier: Apache-2.0
 * The scramblings of SOBOL, and that pixels, digits and seeds of every kind have nothing in common that
 * they should not have. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <math.h>
#include <string.h>

/* ---- SOBOL */

/* The two dimensions of a pair are scrambled independently. Of the first four samples of a pixel,
 * two have equal first digits in both dimensions. With one scrambling for both, their second digits
 * would also be equal in both samples or in neither; independent ones are so half of the time. Six
 * deviations have a false-alarm rate below 1e-8. */
static void test_sobol_scrambling(void) {
    enum { PIXELS = 4096 };
    const bn_sampler s = make_sampler(BN_SAMPLER_SOBOL, 0, 8);
    for (int pair = 0; pair < 2; ++pair) {
        int alike = 0, wrong = 0;
        for (int32_t pixel = 0; pixel < PIXELS; ++pixel) {
            uint32_t sum = 0, chosen = 0;
            for (uint32_t index = 0; index < 4; ++index) {
                uint32_t u[4];
                bn_sample_4d_u32(&s, pixel, 5, index, 9, u);
                const uint32_t differ = (u[2 * pair] ^ u[2 * pair + 1]) >> 30;
                if (differ < 2) {
                    sum ^= differ;
                    ++chosen;
                }
            }
            wrong += chosen != 2;
            alike += sum == 0;
        }
        CHECK(wrong == 0);
        CHECK(fabs(alike - PIXELS / 2.0) < 6 * sqrt(PIXELS) / 2);
    }
}

/* ---- All kinds */

/* No kind repeats after a power of two of pixels, as tiles that are all alike would. */
static void test_no_period(void) {
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        const bn_sampler s = make_sampler(kind, 0, 3);
        for (int32_t period = 64; period <= 1 << 20; period *= 4) {
            for (int way = 1; way <= 3; ++way) {
                int alike = 0;
                for (int32_t pixel = 0; pixel < 64; ++pixel) {
                    const int32_t x = pixel % 8 - 3, y = pixel / 8 - 4;
                    uint32_t u[4][4], v[4][4];
                    for (uint32_t index = 0; index < 4; ++index) {
                        bn_sample_4d_u32(&s, x, y, index, 77, u[index]);
                        bn_sample_4d_u32(&s, x + (way & 1) * period, y + (way >> 1) * period, index,
                                         77, v[index]);
                    }
                    alike += memcmp(u, v, sizeof u) == 0;
                }
                CHECK(alike == 0);
            }
        }
    }
}

/* Each of the 24 digits of a float is set in half of the pixels, also beyond the digits that a mask
 * or a tile gives: six deviations of independent pixels, a false-alarm rate below 1e-6 in all. */
static void test_digits(void) {
    enum { SIDE = 512, DIGITS = 24 };
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        const bn_sampler s = make_sampler(kind, 0, 5);
        static int set[4][DIGITS];
        memset(set, 0, sizeof set);
        for (int32_t pixel = 0; pixel < SIDE * SIDE; ++pixel) {
            uint32_t u[4];
            bn_sample_4d_u32(&s, pixel % SIDE, pixel / SIDE, 0, 12, u);
            for (int d = 0; d < 4; ++d) {
                for (int digit = 0; digit < DIGITS; ++digit)
                    set[d][digit] += u[d] >> (31 - digit) & 1;
            }
        }
        for (int d = 0; d < 4; ++d) {
            for (int digit = 0; digit < DIGITS; ++digit) {
                CHECK(abs(set[d][digit] - SIDE * SIDE / 2) < 6 * SIDE / 2);
            }
        }
    }
}

/* ---- Seeds */

/* The number whose product with `odd` is 1, modulo 2^64. */
static uint64_t inverse_of(uint64_t odd) {
    uint64_t v = odd;
    for (int i = 0; i < 6; ++i) v *= 2u - odd * v;
    return v;
}

/* The seed whose hash is `key`: that of SplitMix64, undone. */
static uint64_t seed_of(uint64_t key) {
    key = (key ^ (key >> 31) ^ (key >> 62)) * inverse_of(0x94d049bb133111ebu);
    key = (key ^ (key >> 27) ^ (key >> 54)) * inverse_of(0xbf58476d1ce4e5b9u);
    return (key ^ (key >> 30) ^ (key >> 60)) - 0x9e3779b97f4a7c15u;
}

/* The most frequent of the sixteen combinations of the first two digits of a dimension in two
 * samplers, over a picture of 64 x 64 pixels: 256 of each if they are independent, 1,024 if one is
 * the other with its digits flipped, as with the same shifts, orders or curve. */
static int most_frequent(const bn_sampler *s, const bn_sampler *t, uint32_t domain, int d) {
    int counts[16] = {0}, most = 0;
    for (int32_t pixel = 0; pixel < 64 * 64; ++pixel) {
        uint32_t u[4], v[4];
        bn_sample_4d_u32(s, pixel % 64, pixel / 64, 0, domain, u);
        bn_sample_4d_u32(t, pixel % 64, pixel / 64, 0, domain, v);
        const int count = ++counts[u[d] >> 30 << 2 | v[d] >> 30];
        if (count > most) most = count;
    }
    return most;
}

/* Both halves of a hashed seed matter to every member of every family. */
static void test_halves_of_seeds(void) {
    for (int half = 0; half < 2; ++half) {
        const uint64_t key = 0x0123456789abcdefu,
                       changed = half == 0 ? 0x5eed5eedu : 0x5eed5eedull << 32;
        for (int32_t kind = 0; kind < KINDS; ++kind) {
            const bn_sampler s = make_sampler(kind, 0, seed_of(key));
            const bn_sampler t = make_sampler(kind, 0, seed_of(key ^ changed));
            uint32_t words[2][2];
            bn_sampler_seed(&s, words[0]);
            bn_sampler_seed(&t, words[1]);
            CHECK((words[0][0] != words[1][0]) == (half == 0));
            CHECK((words[0][1] != words[1][1]) == (half == 1));
            for (uint32_t child = 0; child < 8; ++child) {
                const uint32_t domain = bn_domain_child(4, child);
                for (int d = 0; d < 4; ++d) CHECK(most_frequent(&s, &t, domain, d) < 512);
            }
            CHECK(most_frequent(&s, &s, 4, 0) >= 1024);
        }
    }
}

int main(void) {
    test_sobol_scrambling();
    test_no_period();
    test_digits();
    test_halves_of_seeds();
    return check_result();
}
