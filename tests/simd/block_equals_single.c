/* SPDX-License-Identifier: Apache-2.0
 * Blocks of samples are bit-equal to single draws, for every kind and every alignment of a range of
 * indices to the runs of vector code. */
#include "../c/check.h"
#include <bn/bn.h>
#include <stdlib.h>
#include <string.h>

int main(void) {
    enum { W = 3, H = 2, MOST = 41 };
    static const uint32_t firsts[] = {0,   1,    5,     8,          228,           250,
                                      256, 1021, 65531, (1u << 20), (1u << 31) - 4};
    static const uint32_t counts[] = {1, 2, 3, 7, 8, 9, 17, 32, MOST};
    float *out = malloc(W * H * MOST * 4 * sizeof *out);
    for (int32_t kind = 0; kind < 5; ++kind) {
        for (uint64_t seed = 0; seed < 12; ++seed) {
            bn_sampler_options options = bn_sampler_options_default();
            bn_sampler *s = NULL;
            options.kind = kind;
            options.seed = seed;
            options.samples_per_pixel = seed == 1 ? 1 : 0;
            CHECK(bn_sampler_create(&options, &s) == BN_SUCCESS);
            for (size_t f = 0; f <= sizeof firsts / sizeof *firsts; ++f) {
                for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
                    uint32_t n = counts[c], domain = bn_domain_child((uint32_t)seed, (uint32_t)f);
                    uint32_t first = f < sizeof firsts / sizeof *firsts ? firsts[f] : 0u - n;
                    int32_t x0 = seed == 2 ? INT32_MIN : (int32_t)(seed * 50) - 100;
                    int differences = 0;
                    CHECK(bn_sample_block(s, x0, -7, W, H, first, n, domain, out, W * H * n * 4) ==
                          BN_SUCCESS);
                    for (uint32_t i = 0; i < W * H * n; ++i) {
                        float u[4];
                        bn_sample_4d(s, x0 + (int32_t)(i / n % W), -7 + (int32_t)(i / n / W),
                                     first + i % n, domain, u);
                        differences += memcmp(u, out + 4 * i, sizeof u) != 0;
                    }
                    CHECK(differences == 0);
                }
            }
            bn_sampler_destroy(s);
        }
    }
    free(out);
    return check_result();
}
