/* SPDX-License-Identifier: Apache-2.0
 * The tables of BLUE down to the last bit of an index: its nets at counts that nobody can draw, by
 * linear algebra, and what the search for its labels has gained. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <math.h>
#include <string.h>

enum { MEMBERS = 4, BITS = 32 };

/* ---- Nets */

/* What bit k of an index adds to the four coordinates of a pixel's samples, with what the bits
 * below it add mixed in: that changes no rank of the first k + 1 of them. */
typedef struct matrices {
    uint32_t column[BITS][4];
} matrices;

static matrices matrices_of(const bn_sampler *s, int32_t x, int32_t y, uint32_t domain) {
    matrices m;
    uint32_t zero[4];
    bn_sample_4d_u32(s, x, y, 0, domain, zero);
    for (uint32_t bit = 0; bit < BITS; ++bit) {
        bn_sample_4d_u32(s, x, y, 1u << bit, domain, m.column[bit]);
        for (int d = 0; d < 4; ++d) m.column[bit][d] ^= zero[d];
    }
    return m;
}

/* Whether the first digits of each coordinate, `digits` of them and `bits` in all, are independent
 * functions of the first `bits` bits of an index: then the first 2^bits samples have one in each box
 * of so many digits. */
static int is_net(const matrices *m, const int digits[4], int bits) {
    uint32_t rows[BITS]; /* one for each column, which is eliminated from left to right */
    for (int k = 0; k < bits; ++k) {
        uint64_t packed = 0;
        int at = 0;
        for (int d = 0; d < 4; ++d) {
            if (digits[d] > 0) packed |= (uint64_t)(m->column[k][d] >> (32 - digits[d])) << at;
            at += digits[d];
        }
        rows[k] = (uint32_t)packed;
    }
    for (int k = 0; k < bits; ++k) {
        if (rows[k] == 0) return 0;
        const uint32_t lowest = rows[k] & (0u - rows[k]);
        for (int i = k + 1; i < bits; ++i) {
            if (rows[i] & lowest) rows[i] ^= rows[k];
        }
    }
    return 1;
}

/* Every power of two up to 2^32 in both pairs, and every power of four in all dimensions. */
static void test_nets(const bn_sampler *s) {
    for (uint32_t member = 0; member < MEMBERS; ++member) {
        const uint32_t domain = bn_domain_child(5, member);
        for (int pixel = 0; pixel < 3; ++pixel) {
            const matrices m = matrices_of(s, 1000 * pixel, 7 - 77 * pixel, domain);
            int pairs = 0, fours = 0;
            for (int bits = 1; bits <= BITS; ++bits) {
                for (int a = 0; a <= bits; ++a) {
                    pairs += !is_net(&m, (const int[4]){a, bits - a, 0, 0}, bits);
                    pairs += !is_net(&m, (const int[4]){0, 0, a, bits - a}, bits);
                }
            }
            for (int n = 1; n <= BITS / 2; ++n) {
                for (int a = 0; a <= n; ++a) {
                    for (int b = 0; a + b <= n; ++b) {
                        for (int c = 0; a + b + c <= n; ++c) {
                            const int digits[4] = {2 * a, 2 * b, 2 * c, 2 * (n - a - b - c)};
                            fours += !is_net(&m, digits, 2 * n);
                        }
                    }
                }
            }
            CHECK(pairs == 0);
            CHECK(fours == 0);
        }
    }
}

/* ---- Labels */

enum { SIDE = 64, REACH = 4 };

/* The mean square, over the picture, of a Gaussian blur of a dimension of the first samples, each
 * minus its mean. `order` maps pixels to those whose samples are taken. */
static double blurred(const bn_sampler *s, const uint16_t *order, uint32_t domain, int d) {
    static double picture[SIDE][SIDE], rows[SIDE][SIDE];
    double weight[2 * REACH + 1], total = 0, square = 0;
    for (int i = -REACH; i <= REACH; ++i) total += weight[i + REACH] = exp(-0.5 * i * i);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        float u[4];
        bn_sample_4d(s, order[i] % SIDE, order[i] / SIDE, 0, domain, u);
        picture[i / SIDE][i % SIDE] = u[d] - 0.5;
    }
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            rows[y][x] = 0;
            for (int i = -REACH; i <= REACH; ++i) {
                rows[y][x] += weight[i + REACH] / total * picture[y][(x + i + SIDE) % SIDE];
            }
        }
    }
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            double sum = 0;
            for (int i = -REACH; i <= REACH; ++i) {
                sum += weight[i + REACH] / total * rows[(y + i + SIDE) % SIDE][x];
            }
            square += sum * sum;
        }
    }
    return square / (SIDE * SIDE);
}

/* The labels of pixels were searched for: with those of each block of 4 x 4 pixels in another
 * order, twice as much of the error is left after a blur, in every member of a family. */
static void test_labels(const bn_sampler *s) {
    enum { FAMILIES = 6 };
    uint16_t own[SIDE * SIDE], shuffled[SIDE * SIDE];
    uint32_t state = 1;
    for (uint16_t i = 0; i < SIDE * SIDE; ++i) own[i] = i;
    for (uint32_t member = 0; member < MEMBERS; ++member) {
        double with = 0, without = 0;
        for (uint32_t family = 0; family < FAMILIES; ++family) {
            memcpy(shuffled, own, sizeof own);
            for (int i = 0; i < SIDE * SIDE; ++i) {
                /* Exchanges with a pixel of the same block. */
                const int at = ((i / SIDE & ~3) + (int)(state >> 10 & 3)) * SIDE + (i % SIDE & ~3) +
                               (int)(state >> 20 & 3);
                const uint16_t kept = shuffled[i];
                shuffled[i] = shuffled[at];
                shuffled[at] = kept;
                state = bn_hash32(state + 1);
            }
            const uint32_t domain = bn_domain_child(6, 4 * family + member);
            for (int d = 0; d < 4; ++d) {
                with += blurred(s, own, domain, d);
                without += blurred(s, shuffled, domain, d);
            }
        }
        CHECK(with < 0.6 * without);
    }
}

int main(void) {
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 3);
    test_nets(&s);
    test_labels(&s);
    return check_result();
}
