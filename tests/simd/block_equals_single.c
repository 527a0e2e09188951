/* SPDX-License-Identifier: Apache-2.0
 * Blocks of samples are bit-equal to single draws, for every kind and every alignment of a range of
 * indices to the runs of vector code. Where there are vector draws, SOBOL and WHITE use them. */
#include "../c/check.h"
#include "../c/samplers.h"
#include <bn/bn.h>
#include <stdlib.h>
#include <string.h>

#ifdef BN_COUNT_VECTOR_DRAWS
/* The linker leads calls of bn_sample_many() here. */
static size_t vector_draws;
bn_result __real_bn_sample_many(const bn_sampler *sampler, size_t count, const int32_t *x,
                                const int32_t *y, const uint32_t *index, const uint32_t *domain,
                                uint32_t dimensions, float *out, size_t out_count);
bn_result __wrap_bn_sample_many(const bn_sampler *sampler, size_t count, const int32_t *x,
                                const int32_t *y, const uint32_t *index, const uint32_t *domain,
                                uint32_t dimensions, float *out, size_t out_count);
bn_result __wrap_bn_sample_many(const bn_sampler *sampler, size_t count, const int32_t *x,
                                const int32_t *y, const uint32_t *index, const uint32_t *domain,
                                uint32_t dimensions, float *out, size_t out_count) {
    vector_draws += count;
    return __real_bn_sample_many(sampler, count, x, y, index, domain, dimensions, out, out_count);
}

static void test_vector_draws_are_used(void) {
    enum { W = 5, H = 3, N = 41 };
    static float out[W * H * N * 4];
    for (int32_t kind = BN_SAMPLER_SOBOL; kind <= BN_SAMPLER_WHITE; ++kind) {
        const bn_sampler s = make_sampler(kind, 0, 0);
        vector_draws = 0;
        CHECK(bn_sample_block(&s, 0, 0, W, H, 0, N, 1, out, W * H * N * 4) == BN_SUCCESS);
        CHECK(vector_draws == (__builtin_cpu_supports("avx2") ? W * H * N : 0));
    }
}
#endif

int main(void) {
    enum { W = 3, H = 2, MOST = 300 }; /* more than lanes are drawn at a time */
    static const uint32_t firsts[] = {0,   1,    5,     8,          228,           250,
                                      256, 1021, 65531, (1u << 20), (1u << 31) - 4};
    static const uint32_t counts[] = {1, 2, 3, 7, 8, 9, 17, 41, MOST};
    float *out = malloc(W * H * MOST * 4 * sizeof *out);
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        for (uint64_t seed = 0; seed < 12; ++seed) {
            const bn_sampler s = make_sampler(kind, seed == 1 ? 1 : 0, seed);
            for (size_t f = 0; f <= sizeof firsts / sizeof *firsts; ++f) {
                for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
                    uint32_t n = counts[c], domain = bn_domain_child((uint32_t)seed, (uint32_t)f);
                    uint32_t first = f < sizeof firsts / sizeof *firsts ? firsts[f] : 0u - n;
                    int32_t x0 = seed == 2 ? INT32_MIN : (int32_t)(seed * 50) - 100;
                    int differences = 0;
                    CHECK(bn_sample_block(&s, x0, -7, W, H, first, n, domain, out, W * H * n * 4) ==
                          BN_SUCCESS);
                    for (uint32_t i = 0; i < W * H * n; ++i) {
                        float u[4];
                        bn_sample_4d(&s, x0 + (int32_t)(i / n % W), -7 + (int32_t)(i / n / W),
                                     first + i % n, domain, u);
                        differences += memcmp(u, out + 4 * i, sizeof u) != 0;
                    }
                    CHECK(differences == 0);
                }
            }
        }
    }
    free(out);
#ifdef BN_COUNT_VECTOR_DRAWS
    test_vector_draws_are_used();
#endif
    return check_result();
}
