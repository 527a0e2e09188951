/* SPDX-License-Identifier: Apache-2.0
 * The tables of BLUE down to the last bit of an index: its nets at counts that nobody can draw, by
 * linear algebra, and what the search for its labels has gained. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <string.h>

enum { MEMBERS = 4, BITS = 32 };

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

int main(void) {
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 3);
    test_nets(&s);
    return check_result();
}
