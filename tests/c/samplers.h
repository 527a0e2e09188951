/* SPDX-License-Identifier: Apache-2.0
 * Creates samplers, draws points and checks whether they form a net. If a sampler cannot be created, the
 * program exits. */
#ifndef BN_TESTS_SAMPLERS_H
#define BN_TESTS_SAMPLERS_H

#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TYPES = 5 }; /* number of sampler types, starting at BN_SAMPLER_BLUE = 0 */

static inline bn_sampler make_sampler(int32_t type, uint32_t samples_per_pixel, uint64_t seed) {
    bn_sampler sampler;
    const bn_result result = type == BN_SAMPLER_ZORDER
                                 ? bn_sampler_init_zorder(&sampler, samples_per_pixel, seed)
                                 : bn_sampler_init(&sampler, type, seed);
    if (result != BN_SUCCESS) {
        printf("cannot make a sampler: %s\n", bn_result_string(result));
        exit(1);
    }
    return sampler;
}

enum { MOST_POINTS = 4096 };

/* Draws 2^k samples, starting at index `first`, of each pixel in a square of 2^s x 2^s pixels at (x, y). */
static inline void draw_points(uint32_t points[][4], const bn_sampler *sampler, int32_t x,
                               int32_t y, int s, int k, uint32_t first, uint32_t domain) {
    const int32_t side = 1 << s;
    uint32_t(*point)[4] = points;
    for (int32_t i = 0; i < side * side; ++i) {
        for (uint32_t index = 0; index < 1u << k; ++index) {
            bn_sample_4d_u32(sampler, x + i % side, y + i / side, first + index, domain, *point++);
        }
    }
}

/* Whether each elementary box contains one of the 2^m points (at most 4096). Along axis d, a box is
 * identified by digits[d] binary digits, which add up to m. */
static inline int one_in_each_box(uint32_t points[][4], const int digits[4], int m) {
    static unsigned char seen[MOST_POINTS];
    memset(seen, 0, (size_t)1 << m);
    for (uint32_t i = 0; i < 1u << m; ++i) {
        uint32_t box = 0;
        for (int d = 0; d < 4; ++d) {
            box = box << digits[d] | (uint32_t)((uint64_t)points[i][d] >> (32 - digits[d]));
        }
        if (seen[box]++) return 0;
    }
    return 1;
}

/* Whether the 2^m points form a (0,m,2)-net in base 2 in each pair of dimensions. */
static inline int are_nets_in_pairs(uint32_t points[][4], int m) {
    for (int a = 0; a <= m; ++a) {
        if (!one_in_each_box(points, (const int[4]){a, m - a, 0, 0}, m)) return 0;
        if (!one_in_each_box(points, (const int[4]){0, 0, a, m - a}, m)) return 0;
    }
    return 1;
}

/* Whether the 4^m points form a (0,m,4)-net in base 4: each box of volume 4^-m whose side lengths are
 * powers of 1/4 contains one point. */
static inline int are_net_in_four(uint32_t points[][4], int m) {
    for (int a = 0; a <= m; ++a) {
        for (int b = 0; a + b <= m; ++b) {
            for (int c = 0; a + b + c <= m; ++c) {
                const int digits[4] = {2 * a, 2 * b, 2 * c, 2 * (m - a - b - c)};
                if (!one_in_each_box(points, digits, 2 * m)) return 0;
            }
        }
    }
    return 1;
}

#endif
