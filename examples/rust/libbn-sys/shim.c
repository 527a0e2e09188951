/* SPDX-License-Identifier: Apache-2.0
 * Exports the inline functions of bn_path.h as symbols for Rust. src/lib.rs repeats their types, so
 * the assertions below catch any change. */
#include "bn.h"
#include <stddef.h>

#define BN_SAME(condition) _Static_assert(condition, "src/lib.rs has another type: " #condition)
BN_SAME(sizeof(bn_path) == 16 && offsetof(bn_path, index) == 8 && offsetof(bn_path, domain) == 12);
BN_SAME(sizeof(bn_pan) == 16 && offsetof(bn_pan, y) == 4);
BN_SAME(sizeof(bn_ray) == 44 && offsetof(bn_ray, domain) == 16 && offsetof(bn_ray, splits) == 32);
BN_SAME(sizeof(bn_split) == 24 && offsetof(bn_split, domain) == 16);
BN_SAME(sizeof(bn_loop) == 36 && offsetof(bn_loop, counter) == 16 &&
        offsetof(bn_loop, drawn) == 32);
BN_SAME(sizeof(void *) != 8 || (sizeof(bn_sampler) == 48 && offsetof(bn_sampler, mask) == 16));
BN_SAME(sizeof(void *) != 8 || offsetof(bn_sampler, mask_low_digits) == 32);
BN_SAME(sizeof(void *) != 8 || offsetof(bn_sampler, mask_rank_bits) == 44);
BN_SAME(sizeof(void *) != 8 || (sizeof(bn_mask) == 32 && offsetof(bn_mask, channels) == 24));
BN_SAME(sizeof(void *) != 8 || (sizeof(bn_wavefront) == 104 && offsetof(bn_wavefront, out) == 64));

#define BN_INLINE(result, name, parameters, arguments)                                             \
    result bn_rs_##name parameters {                                                               \
        return bn_##name arguments;                                                                \
    }
#define BN_DRAW(name, parameters, arguments)                                                       \
    void bn_rs_##name parameters {                                                                 \
        bn_##name arguments;                                                                       \
    }

typedef const bn_sampler *sampler;
typedef uint32_t u32;

BN_INLINE(bn_sampler, sampler_make, (uint64_t seed), (seed))
BN_INLINE(bn_path, path_start, (int32_t x, int32_t y, u32 i, u32 stream), (x, y, i, stream))
BN_INLINE(bn_pan, follow, (bn_pan pan, float x, float y), (pan, x, y))
BN_INLINE(u32, frame_index, (u32 frame, u32 most), (frame, most))
BN_INLINE(u32, frame_stream, (u32 frame, u32 most), (frame, most))
BN_INLINE(bn_ray, path_ray, (const bn_path *p, u32 ray), (p, ray))
BN_INLINE(bn_ray, ray_child, (const bn_ray *r, u32 key), (r, key))
BN_INLINE(bn_split, ray_next_split, (bn_ray * r, u32 count), (r, count))
BN_INLINE(bn_split, ray_next_split_from, (bn_ray * r, u32 first), (r, first))
BN_INLINE(bn_split, ray_draw_split, (const bn_ray *r, u32 k, u32 count), (r, k, count))
BN_INLINE(bn_path, split_path, (const bn_split *split, u32 k), (split, k))
BN_INLINE(float, ray_next_1d, (sampler s, bn_ray *r), (s, r))
BN_INLINE(float, ray_draw_1d, (sampler s, const bn_ray *r, u32 k), (s, r, k))
BN_INLINE(bn_loop, ray_next_loop, (sampler s, bn_ray *r), (s, r))
BN_INLINE(bn_loop, ray_draw_loop, (sampler s, const bn_ray *r, u32 k), (s, r, k))
BN_INLINE(float, loop_next_1d, (bn_loop * rng), (rng))
BN_DRAW(ray_draw, (sampler s, const bn_ray *r, float out[4]), (s, r, out))
BN_DRAW(ray_draw_direction, (sampler s, const bn_ray *r, float out[2]), (s, r, out))
BN_DRAW(ray_draw_end_light, (sampler s, const bn_ray *r, float out[2]), (s, r, out))
BN_DRAW(ray_next_2d, (sampler s, bn_ray *r, float out[2]), (s, r, out))
BN_DRAW(ray_draw_2d, (sampler s, const bn_ray *r, u32 k, float out[2]), (s, r, k, out))
BN_DRAW(ray_next_4d, (sampler s, bn_ray *r, float out[4]), (s, r, out))
BN_DRAW(ray_draw_4d, (sampler s, const bn_ray *r, u32 k, float out[4]), (s, r, k, out))
BN_DRAW(path_time_wavelength, (sampler s, const bn_path *p, float out[2]), (s, p, out))
BN_DRAW(path_first_light, (sampler s, const bn_path *p, u32 count, u32 k, float out[2]),
        (s, p, count, k, out))
