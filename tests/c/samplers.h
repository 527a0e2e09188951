/* SPDX-License-Identifier: Apache-2.0
 * Makes samplers for tests; a failure ends the program. Whether points are a net. */
#ifndef BN_TESTS_SAMPLERS_H
#define BN_TESTS_SAMPLERS_H

#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KINDS = 5 }; /* of samplers: BN_SAMPLER_BLUE is 0 */

static inline bn_sampler sampler_of(const bn_sampler_options *options) {
    bn_sampler sampler;
    bn_result result = bn_sampler_init(&sampler, options);
    if (result != BN_SUCCESS) {
        printf("cannot make a sampler: %s\n", bn_result_string(result));
        exit(1);
    }
    return sampler;
}

static inline bn_sampler make_sampler(int32_t kind, uint32_t samples_per_pixel, uint64_t seed) {
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = kind;
    options.samples_per_pixel = samples_per_pixel;
    options.seed = seed;
    return sampler_of(&options);
}

enum { MOST_POINTS = 4096 };

/* Whether 4^m points, at most 4096, are a (0,m,4)-net to base 4: one in each box whose sides are
 * powers of 1/4 and whose volume is 4^-m. */
static inline int are_net_in_four(uint32_t points[][4], int m) {
    static unsigned char seen[MOST_POINTS];
    for (int a = 0; a <= m; ++a) {
        for (int b = 0; a + b <= m; ++b) {
            for (int c = 0; a + b + c <= m; ++c) {
                const int sides[4] = {a, b, c, m - a - b - c};
                memset(seen, 0, (size_t)1 << 2 * m);
                for (uint32_t i = 0; i < 1u << 2 * m; ++i) {
                    uint32_t box = 0;
                    for (int d = 0; d < 4; ++d) {
                        box = box << 2 * sides[d] |
                              (uint32_t)((uint64_t)points[i][d] >> (32 - 2 * sides[d]));
                    }
                    if (seen[box]++) return 0;
                }
            }
        }
    }
    return 1;
}

#endif
