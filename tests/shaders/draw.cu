/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in CUDA and HIP. With RUN_ON_HOST it is a program of C++ that compares. */
#include <bn/bn_choose.h>
#include <bn/bn_draw.h>
#include <bn/bn_path.h>

#define DEVICE_INLINE static inline __host__ __device__

DEVICE_INLINE uint32_t floatBitsToUint(float v) {
    union {
        float number;
        uint32_t bits;
    } u;
    u.number = v;
    return u.bits;
}

DEVICE_INLINE float uintBitsToFloat(uint32_t v) {
    union {
        uint32_t bits;
        float number;
    } u;
    u.bits = v;
    return u.number;
}

/* The names of GLSL. Functions of C write to arrays, and take tables and pointers. */
struct vec4 {
    float x, y, z, w;
};
struct vec2 {
    float x, y;
};
#define uint uint32_t
#define FOUR(...) [&] { float u[4]; __VA_ARGS__; return vec4{u[0], u[1], u[2], u[3]}; }()
#define TWO(...) [&] { float u[2]; __VA_ARGS__; return vec2{u[0], u[1]}; }()
#define SIGNED(x, y) int32_t(x), int32_t(y)
#define bn_draw_blue_bits(...) bn_draw_blue_bits(words, __VA_ARGS__)
#define bn_draw_blue_pair_bits(...) bn_draw_blue_pair_bits(words, __VA_ARGS__)
#define bn_draw_blue_4d(seed, x, y, ...) FOUR((bn_draw_blue_4d)(words, seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_draw_sobol_4d(seed, x, y, ...) FOUR((bn_draw_sobol_4d)(seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_draw_white_4d(seed, x, y, ...) FOUR((bn_draw_white_4d)(seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_draw_blue_2d(seed, x, y, ...) TWO((bn_draw_blue_2d)(words, seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_draw_sobol_2d(seed, x, y, ...) TWO((bn_draw_sobol_2d)(seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_draw_white_2d(seed, x, y, ...) TWO((bn_draw_white_2d)(seed, SIGNED(x, y), __VA_ARGS__, u))
#define bn_path_start(x, y, ...) bn_path_start(SIGNED(x, y), __VA_ARGS__)
#define bn_choose(probability, u) bn_choose(probability, &u)
#define bn_choose_u32(count, u) bn_choose_u32(count, &u)
#define bn_choose_cdf(first, count, u) bn_choose_cdf(cdf + (first), count, &u)
#define CASE(i) asked[i]
#define out const uint32_t *words, const float *cdf, const uint32_t *asked,
#define void DEVICE_INLINE void
#include "answer.glsl"
#undef void

#ifdef RUN_ON_HOST
#include "run_on_host.h"
#else
extern "C" __global__ void draw(const uint32_t *words, const float *cdf, const uint32_t *cases, uint32_t *results,
                                uint32_t first) {
    /* One thread a block, so that compilers without the headers of CUDA and HIP can compile this. */
    answer(words, cdf, cases + 16u * first, results + 16u * first);
}
#endif
