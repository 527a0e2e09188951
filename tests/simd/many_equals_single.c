/* SPDX-License-Identifier: Apache-2.0
 * Wavefronts and blocks are bit-identical to single draws and write nothing outside their outputs. The tests
 * cover every sampler type, all dimensions, lane counts up to multiple vectors, unaligned arrays, and
 * arguments from their whole range. The environment variable BN_SIMD selects the instruction set. */
#include "../c/check.h"
#include "../c/samplers.h"
#include <bn/bn_path.h>
#include <stdlib.h>
#include <string.h>

enum { OFFSETS = 4, MOST = 67, GUARD = 64 };

/* Numbers below 256, numbers at the limits of ranges, or arbitrary bits. */
enum { SMALL, ENDS, ANY, RANGES };
static uint32_t number(int range) {
    static const uint32_t ends[] = {0,   1,   2,           3,           255,
                                    256, 257, 0x7fffffffu, 0x80000000u, 0xffffffffu};
    static uint32_t state = 1;
    const uint32_t v = next_random(&state);
    if (range == SMALL) return v % 256u;
    return range == ENDS ? ends[v % (sizeof ends / sizeof *ends)] : v;
}

enum { PAIRS = 5, FORMS = PAIRS + 2 }; /* PAIRS and PAIRS + 1: pairs 0 and 1 */

/* An array of `count` elements. It ends where its allocation ends, so that sanitizers detect overruns. */
static void *array(void **memory, size_t offset, size_t count) {
    const size_t size = (offset + count) * sizeof(uint32_t);
    *memory = malloc(size > 0 ? size : 1);
    if (*memory == NULL) exit(1);
    return (uint32_t *)*memory + offset;
}

static void compare(const bn_sampler *sampler, size_t count, size_t offset, uint32_t what,
                    int range) {
    const uint32_t dimensions = what >= PAIRS ? 2 : what;
    void *memory[4];
    int32_t *x = array(&memory[0], offset, count), *y = array(&memory[1], offset, count);
    uint32_t *index = array(&memory[2], offset, count), *domain = array(&memory[3], offset, count);
    float out[OFFSETS + 4 * MOST + GUARD];
    unsigned char guard[sizeof out];
    const size_t begin = offset * sizeof *out, size = count * dimensions * sizeof *out;
    int differences = 0;
    for (size_t i = 0; i < count; ++i) {
        x[i] = (int32_t)number(range);
        y[i] = (int32_t)number(range);
        index[i] = number(range);
        domain[i] = number(range == SMALL ? ANY : range);
    }
    memset(out, 0x5a, sizeof out);
    memset(guard, 0x5a, sizeof guard);
    bn_wavefront w = bn_wavefront_default();
    w.count = count;
    w.x = x;
    w.y = y;
    w.index = index;
    w.domain = domain;
    w.stride = dimensions;
    for (uint32_t d = 0; d < dimensions; ++d) {
        w.out[what == PAIRS + 1 ? 2 + d : d] = out + offset + d;
    }
    CHECK(bn_sample_wavefront(sampler, &w) == BN_SUCCESS);
    for (size_t i = 0; i < count; ++i) {
        float u[4];
        bn_sample_4d(sampler, x[i], y[i], index[i], domain[i], u);
        if (what >= PAIRS) bn_sample_2d(sampler, x[i], y[i], index[i], domain[i], what - PAIRS, u);
        differences += memcmp(u, out + offset + i * dimensions, dimensions * sizeof *u) != 0;
    }
    CHECK(differences == 0);
    CHECK(memcmp(out, guard, begin) == 0);
    CHECK(memcmp((unsigned char *)out + begin + size, guard, sizeof out - begin - size) == 0);
    for (int i = 0; i < 4; ++i) free(memory[i]);
}

static void test_wavefront_bits(void) {
    for (int32_t type = 0; type < TYPES; ++type) {
        for (uint64_t seed = 0; seed < 2; ++seed) {
            const bn_sampler sampler = make_sampler(type, seed == 0 ? 0 : 5, seed);
            for (size_t count = 0; count <= MOST; ++count) {
                for (uint32_t what = 1; what < FORMS; ++what) {
                    for (int range = 0; range < RANGES; ++range) {
                        compare(&sampler, count, (count + what) % OFFSETS, what, range);
                    }
                }
            }
        }
    }
}

/* Tests every combination of per-lane arrays, shared values and requested dimensions. */
static void test_wavefront_arguments(void) {
    enum { N = 600 };
    static int32_t x[N], y[N];
    static uint32_t index[N], domain[N], depth[N];
    enum { STRIDE = 3 };
    static float out[4][STRIDE * N + 1];
    for (int i = 0; i < N; ++i) {
        x[i] = (int32_t)number(i % RANGES);
        y[i] = (int32_t)number(i % RANGES);
        index[i] = number(i % RANGES);
        domain[i] = number(ANY);
        depth[i] = (uint32_t)(i % 9 == 8 ? (1 << 28) - 1 : i % 9);
    }
    for (int32_t type = 0; type < TYPES; ++type) {
        const bn_sampler s = make_sampler(type, 0, 3);
        for (uint32_t what = 0; what < 128; ++what) {
            bn_wavefront w = bn_wavefront_default();
            int wrong = 0;
            w.count = what % 3 == 0 ? N : what % 5;
            w.x = x;
            w.y = y;
            w.index = what & 16 ? index : NULL;
            w.domain = what & 32 ? domain : NULL;
            w.depth = what & 64 ? depth : NULL;
            w.shared_index = 77;
            w.stride = what % 7 == 0 ? STRIDE : 1;
            w.shared_domain = what & 1 ? 5 : BN_DOMAIN_ROOT;
            memset(out, 0x5a, sizeof out);
            for (int d = 0; d < 4; ++d) w.out[d] = what >> d & 1 ? out[d] : NULL;
            CHECK(bn_sample_wavefront(&s, &w) ==
                  ((what & 15) == 0 ? BN_ERROR_INVALID_ARGUMENT : BN_SUCCESS));
            for (size_t i = 0; i < N; ++i) {
                float u[4], untouched;
                bn_path path = bn_path_start(0, 0, 0, 0);
                path.domain = what & 32 ? domain[i] : w.shared_domain;
                bn_sample_4d(&s, x[i], y[i], what & 16 ? index[i] : 77,
                             what & 64 ? bn_path_ray_domain(path, depth[i]) : path.domain, u);
                memset(&untouched, 0x5a, sizeof untouched);
                for (int d = 0; d < 4; ++d) {
                    const int wanted = what >> d & 1 && i < w.count;
                    wrong += memcmp(&out[d][i * w.stride], wanted ? &u[d] : &untouched,
                                    sizeof(float)) != 0;
                }
            }
            CHECK(wrong == 0);
        }
    }
    bn_wavefront w = bn_wavefront_default();
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 3);
    w.out[0] = out[0];
    CHECK(bn_sample_wavefront(&s, &w) == BN_SUCCESS); /* no lanes */
    w.count = 1;
    CHECK(bn_sample_wavefront(&s, &w) == BN_ERROR_INVALID_ARGUMENT);
    w.x = w.y = x;
    CHECK(bn_sample_wavefront(NULL, &w) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_sample_wavefront(&s, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_sample_wavefront(&s, &w) == BN_SUCCESS);
    w.stride = 0;
    CHECK(bn_sample_wavefront(&s, &w) == BN_ERROR_INVALID_ARGUMENT);
    w.stride = 1;
    w.struct_size = 0;
    CHECK(bn_sample_wavefront(&s, &w) == BN_ERROR_INVALID_ARGUMENT);
}

/* Tests every alignment of an index range to the runs that the vector code processes. */
static void test_blocks(void) {
    enum { W = 3, H = 2, LONGEST = 300 }; /* more than are drawn at a time */
    static const uint32_t firsts[] = {0,   1,    5,     8,          228,           250,
                                      256, 1021, 65531, (1u << 20), (1u << 31) - 4};
    static const uint32_t counts[] = {1, 2, 3, 7, 8, 9, 17, 41, LONGEST};
    float *out = malloc(W * H * LONGEST * 4 * sizeof *out);
    for (int32_t type = 0; type < TYPES; ++type) {
        for (uint64_t seed = 0; seed < 4; ++seed) {
            const bn_sampler s = make_sampler(type, seed == 1 ? 1 : 0, seed);
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
}

#ifdef BN_COUNT_VECTOR_DRAWS
/* The linker redirects calls of bn_sample_wavefront() to this function. */
static size_t vector_draws;
__typeof__(bn_sample_wavefront) __real_bn_sample_wavefront, __wrap_bn_sample_wavefront;
bn_result __wrap_bn_sample_wavefront(const bn_sampler *sampler, const bn_wavefront *wavefront) {
    if (wavefront != NULL) vector_draws += wavefront->count;
    return __real_bn_sample_wavefront(sampler, wavefront);
}

/* Blocks of SOBOL and WHITE use vector draws if the instruction set has them. */
static void test_vector_draws_are_used(void) {
    enum { W = 5, H = 3, N = 41 };
    static float out[W * H * N * 4];
    const char *set = getenv("BN_SIMD");
    const int narrow = set != NULL && strcmp(set, "scalar") == 0;
    const int used = __builtin_cpu_supports("avx2") && !narrow;
    for (int32_t type = BN_SAMPLER_SOBOL; type <= BN_SAMPLER_WHITE; ++type) {
        const bn_sampler s = make_sampler(type, 0, 0);
        vector_draws = 0;
        CHECK(bn_sample_block(&s, 0, 0, W, H, 0, N, 1, out, W * H * N * 4) == BN_SUCCESS);
        CHECK(vector_draws == (used ? W * H * N : 0));
    }
}
#endif

int main(void) {
    test_wavefront_bits();
    test_wavefront_arguments();
    test_blocks();
#ifdef BN_COUNT_VECTOR_DRAWS
    test_vector_draws_are_used();
#endif
    return check_result();
}
