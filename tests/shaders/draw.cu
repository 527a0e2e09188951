/* SPDX-License-Identifier: Apache-2.0
 * draw.comp in CUDA and HIP. With RUN_ON_HOST, it is a C++ program that compares the results. */
#include <bn/bn_choose.h>
#include <bn/bn_draw.h>
#include <bn/bn_path.h>

#define DEVICE_INLINE static inline __host__ __device__

#define floatBitsToUint bn_float_bits

DEVICE_INLINE float uintBitsToFloat(uint32_t v) {
    union {
        uint32_t bits;
        float number;
    } u;
    u.bits = v;
    return u.number;
}

/* Provides GLSL's names. The C functions take tables and pointers, and write their results to arrays. */
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
#define bn_path_ray(path, ...) bn_path_ray(&path, __VA_ARGS__)
#define bn_ray_child(ray, ...) bn_ray_child(&ray, __VA_ARGS__)
#define bn_ray_draw_split(ray, ...) bn_ray_draw_split(&ray, __VA_ARGS__)
#define bn_split_path(split, ...) bn_split_path(&split, __VA_ARGS__)
/* A ray's named draws use the domains of the ray. */
#define AT_4D(seed, path, domain) bn_draw_blue_4d(seed, (path).x, (path).y, (path).index, domain)
#define AT_2D(seed, path, domain, pair) bn_draw_blue_2d(seed, (path).x, (path).y, (path).index, domain, pair)
#define bn_ray_draw(seed, ray) AT_4D(seed, ray.path, ray.domain)
#define bn_ray_draw_direction(seed, ray) AT_2D(seed, ray.path, ray.domain, 0)
#define bn_ray_draw_end_light(seed, ray) AT_2D(seed, ray.path, ray.domain, 1)
#define bn_ray_draw_4d(seed, ray, k) AT_4D(seed, ray.path, bn_ray_4d_domain(ray.domain, k))
#define bn_ray_draw_2d(seed, ray, k) AT_2D(seed, ray.path, bn_ray_2d_domain(ray.domain, k), bn_ray_2d_pair(k))
#define bn_ray_draw_1d(seed, ray, k) \
    [&] { vec2 v = AT_2D(seed, ray.path, bn_ray_1d_domain(ray.domain, k), bn_ray_1d_pair(k)); return k & 1 ? v.y : v.x; }()
#define bn_path_time_wavelength(seed, path) AT_2D(seed, path, bn_path_camera_domain(path), 1)
#define bn_path_first_light(seed, path, count, k) \
    bn_draw_blue_2d(seed, path.x, path.y, path.index * (count ? count : 1) + k, bn_path_camera_domain(path), 0)
#define bn_ray_draw_split_from(ray, k, first) [&] { ray.splits = k; return bn_ray_next_split_from(&ray, first); }()
struct loop_of {
    bn_path path;
    uint32_t domain;
};
#define bn_loop loop_of
#define bn_ray_draw_loop(ray, k) loop_of{ray.path, bn_ray_loop_domain(ray.domain, k)}
#define LATER(seed, loop, k) float(bn_loop_later_bits(seed, loop.path, loop.domain, k) >> 8) / 16777216.0f
#define bn_loop_draw_1d(seed, loop, k) \
    [&] { vec4 v = AT_4D(seed, loop.path, loop.domain); return (k) > 3 ? LATER(seed, loop, k) : (&v.x)[k]; }()
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
    /* One thread per block, so that compilers without the CUDA and HIP headers can compile this. */
    answer(words, cdf, cases + 16u * first, results + 16u * first);
}
#endif
