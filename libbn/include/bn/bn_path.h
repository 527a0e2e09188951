/* SPDX-License-Identifier: Apache-2.0
 * Random numbers for a path. You request them by purpose so that no two decisions share a number. All
 * functions are inline and draw through bn_draw.h:
 *
 *     bn_path path = bn_path_start(x, y, index, 0);
 *     for (uint32_t depth = 0; depth < max_depth; ++depth) {
 *         bn_ray ray = bn_path_ray(&path, depth);
 *         float u[4], probe[2];
 *         bn_ray_draw(sampler, &ray, u);                // the direction; a light at the ray's end
 *         float lobe = bn_ray_next_1d(sampler, &ray);   // other decisions: as many as you like
 *         bn_ray_next_2d(sampler, &ray, probe);
 *     }
 *
 * docs/paths.md goes through a renderer's decisions one by one. The functions allocate nothing, take no locks
 * and cannot fail. Only functions with next_ in their names modify their arguments.
 *
 * RAYS
 *
 * Ray 0 leaves the camera; ray d leaves the d-th surface or other event. Each ray has four numbers:
 *
 *     u[0], u[1]   its direction; for ray 0, the pixel position
 *     u[2], u[3]   the light sample at its end
 *
 * The two pairs' contributions multiply in the integrand, so the pairs are stratified together. If the lens
 * uses u[2] and u[3] of ray 0, or if you take multiple light samples there, call bn_path_first_light() for
 * the light. Call bn_path_time_wavelength() for time and wavelength, once for all branches of the path.
 *
 * For every other decision, call bn_ray_next_1d(), bn_ray_next_2d() or bn_ray_next_4d(). Each function has
 * its own sequence within the ray, so two pixels that drew different numbers of samples at one ray are back
 * in step at the next ray. For a discrete choice followed by a pair, such as a light and a point on it, call
 * bn_ray_next_4d() and use u[2], then (u[0], u[1]).
 *
 * Make one bn_ray for each ray and pass it by pointer. It is stateful, and a second bn_ray for the same ray
 * returns the same numbers. To number the draws yourself, call bn_ray_draw_1d(sampler, &ray, k) or one of its
 * variants. Each returns the same result as call k + 1 of the matching bn_ray_next_...().
 *
 * SPLITS, LOOPS, KEYS
 *
 * To split a path into branches:
 *
 *     bn_split split = bn_ray_next_split(&ray, count);
 *     for (uint32_t k = 0; k < count; ++k) {
 *         bn_path branch = bn_split_path(&split, k); // its rays begin at 0
 *     }
 *
 * `count` must be the same for all samples of the pixel. If it varies, call bn_ray_next_split_from() and pass
 * the number of branches the pixel's earlier samples took. If you do not know that number, pass
 * bn_ray_next_split() a count near the mean; a sample may then use fewer branches, or more by passing k =
 * count, count + 1 and so on.
 *
 * For a loop of unknown length, such as delta tracking or a random walk, draw from bn_ray_next_loop().
 * Decisions that neighbouring pixels reach in different orders, such as stochastic transparency, need a key:
 * draw from bn_ray_child(&ray, primitive).
 *
 * Ray numbers and decision counts must be below 2^28, and index * count below 2^32.
 *
 * FRAMES
 *
 * In a film, continue the indices from frame to frame, in steps of a power of two:
 *
 *     const uint32_t first = bn_frame_index(frame, most), stream = bn_frame_stream(frame, most);
 *     bn_path path = bn_path_start(x, y, first + i, stream); // sample i = 0, 1 ... of the frame
 *
 * `most` is the largest number of samples that a pixel takes in any frame. If a renderer draws one sample
 * per frame and averages frames along the motion of the image, the draws should follow the motion too:
 *
 *     pan = bn_follow(pan, motion_x, motion_y); // once per frame, starting with bn_pan pan = {0, 0, 0, 0}
 *     bn_path path = bn_path_start(x - pan.x, y - pan.y, frame, 0);
 *
 * docs/realtime.md shows what this gains, and how to choose the motion. */
#ifndef BN_BN_PATH_H
#define BN_BN_PATH_H

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

#include <bn/bn_draw.h>

#include <bn/bn_device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A path's 16-byte state. A wavefront keeps one per lane. */
typedef struct bn_path bn_path;

/* A 16-byte state; zeros to start with. */
typedef struct bn_pan bn_pan;

#define BN_FLOAT_BITS(v) bn_float_bits(v)
#define BN_PATH_IN_C
#include <bn/bn_path.glsl>
#undef BN_PATH_IN_C
#undef BN_FLOAT_BITS

/* ---- Paths */

/* Sample `index` of pixel (x, y). Streams are independent: use them for light paths alongside camera paths.
 * Frames should share a stream and continue the index (FRAMES, above). */
BN_DEVICE_INLINE bn_path bn_path_start(int32_t x, int32_t y, uint32_t index, uint32_t stream) {
    bn_path path = {(uint32_t)x, (uint32_t)y, index, bn_path_stream_domain(stream)};
    return path;
}

/* A ray of a path, and counters for its bn_ray_next_...() functions. */
typedef struct bn_ray {
    bn_path path;
    uint32_t domain;
    uint32_t drawn_1d, drawn_2d, drawn_4d, splits, loops;
    float kept_1d; /* drawn together with the single number before it */
} bn_ray;

BN_DEVICE_INLINE bn_ray bn_path_ray(const bn_path *path, uint32_t ray) {
    bn_ray result = {*path, bn_path_ray_domain(*path, ray), 0, 0, 0, 0, 0, 0.0f};
    return result;
}

/* A sub-sampler of a ray, selected by a key such as a primitive's index. Draw from it as you would
 * from a ray. Its numbers do not depend on earlier draws: a second child with the same key returns the same
 * numbers. */
BN_DEVICE_INLINE bn_ray bn_ray_child(const bn_ray *ray, uint32_t key) {
    bn_ray result = bn_path_ray(&ray->path, 0);
    result.domain = bn_ray_child_domain(ray->domain, key);
    return result;
}

typedef struct bn_split {
    bn_path path;
    uint32_t domain, count; /* if count is 0, path.index is the number of the first branch */
} bn_split;

/* Split k of a ray, into `count` branches; a count of 0 means 1. */
BN_DEVICE_INLINE bn_split bn_ray_draw_split(const bn_ray *ray, uint32_t k, uint32_t count) {
    bn_split split = {ray->path, bn_ray_split_domain(ray->domain, k), count > 0 ? count : 1};
    return split;
}

BN_DEVICE_INLINE bn_split bn_ray_next_split(bn_ray *ray, uint32_t count) {
    return bn_ray_draw_split(ray, ray->splits++, count);
}

/* Splits into any number of branches. `first` is the number of branches the pixel's earlier samples took
 * here. */
BN_DEVICE_INLINE bn_split bn_ray_next_split_from(bn_ray *ray, uint32_t first) {
    bn_split split = bn_ray_next_split(ray, 1);
    split.path.index = first;
    split.count = 0;
    return split;
}

/* Branch k, which is itself a path. */
BN_DEVICE_INLINE bn_path bn_split_path(const bn_split *split, uint32_t k) {
    return bn_path_branch(split->path, split->domain, split->count, k);
}

#ifndef BN_DEVICE_ONLY

/* ---- A ray's numbers, in [0, 1) */

BN_HOST_INLINE void bn_path_draw_4d(const bn_sampler *s, const bn_path *path, uint32_t domain,
                                    float out[4]) {
    bn_draw_4d(s, (int32_t)path->x, (int32_t)path->y, path->index, domain, out);
}

BN_HOST_INLINE void bn_path_draw_2d(const bn_sampler *s, const bn_path *path, uint32_t domain,
                                    uint32_t pair, float out[2]) {
    bn_draw_2d(s, (int32_t)path->x, (int32_t)path->y, path->index, domain, pair, out);
}

/* out[0], out[1]: the direction. out[2], out[3]: the light sample at the ray's end. */
BN_HOST_INLINE void bn_ray_draw(const bn_sampler *s, const bn_ray *ray, float out[4]) {
    bn_path_draw_4d(s, &ray->path, ray->domain, out);
}

/* One of the two pairs of bn_ray_draw(). */
BN_HOST_INLINE void bn_ray_draw_direction(const bn_sampler *s, const bn_ray *ray, float out[2]) {
    bn_path_draw_2d(s, &ray->path, ray->domain, 0, out);
}

BN_HOST_INLINE void bn_ray_draw_end_light(const bn_sampler *s, const bn_ray *ray, float out[2]) {
    bn_path_draw_2d(s, &ray->path, ray->domain, 1, out);
}

/* Return the same result as call k + 1 of the matching bn_ray_next_...(), without advancing the ray. */
BN_HOST_INLINE float bn_ray_draw_1d(const bn_sampler *s, const bn_ray *ray, uint32_t k) {
    float pair[2];
    bn_path_draw_2d(s, &ray->path, bn_ray_1d_domain(ray->domain, k), bn_ray_1d_pair(k), pair);
    return pair[k & 1u];
}

BN_HOST_INLINE void bn_ray_draw_2d(const bn_sampler *s, const bn_ray *ray, uint32_t k,
                                   float out[2]) {
    bn_path_draw_2d(s, &ray->path, bn_ray_2d_domain(ray->domain, k), bn_ray_2d_pair(k), out);
}

BN_HOST_INLINE void bn_ray_draw_4d(const bn_sampler *s, const bn_ray *ray, uint32_t k,
                                   float out[4]) {
    bn_path_draw_4d(s, &ray->path, bn_ray_4d_domain(ray->domain, k), out);
}

/* The next single number. Every four consecutive ones are stratified together. Every second call is free. */
BN_HOST_INLINE float bn_ray_next_1d(const bn_sampler *s, bn_ray *ray) {
    const uint32_t k = ray->drawn_1d++;
    float pair[2];
    if (k & 1u) return ray->kept_1d;
    bn_path_draw_2d(s, &ray->path, bn_ray_1d_domain(ray->domain, k), bn_ray_1d_pair(k), pair);
    ray->kept_1d = pair[1];
    return pair[0];
}

/* The next pair. Two consecutive pairs are stratified together. */
BN_HOST_INLINE void bn_ray_next_2d(const bn_sampler *s, bn_ray *ray, float out[2]) {
    bn_ray_draw_2d(s, ray, ray->drawn_2d++, out);
}

/* The next four numbers. Use them for two pairs whose contributions multiply, or for a choice (out[2])
 * followed by a pair (out[0], out[1]). */
BN_HOST_INLINE void bn_ray_next_4d(const bn_sampler *s, bn_ray *ray, float out[4]) {
    bn_ray_draw_4d(s, ray, ray->drawn_4d++, out);
}

/* ---- Once per path */

/* Light sample k of `count` at the end of ray 0. Call this if a lens uses that ray's second pair, or if you
 * take multiple light samples. `count` must be the same for all samples of the pixel; 0 means 1. */
BN_HOST_INLINE void bn_path_first_light(const bn_sampler *s, const bn_path *path, uint32_t count,
                                        uint32_t k, float out[2]) {
    bn_draw_2d(s, (int32_t)path->x, (int32_t)path->y, path->index * (count == 0 ? 1 : count) + k,
               bn_path_camera_domain(*path), 0, out);
}

/* Both are in [0, 1). out[0]: time as a fraction of the shutter interval. out[1]: position in the
 * spectrum. */
BN_HOST_INLINE void bn_path_time_wavelength(const bn_sampler *s, const bn_path *path,
                                            float out[2]) {
    bn_path_draw_2d(s, path, bn_path_camera_domain(*path), 1, out);
}

typedef struct bn_loop {
    float next[4];
    bn_uint4 counter; /* WHITE's counter, for numbers after the first four */
    uint32_t drawn;
} bn_loop;

/* Start loop k of a ray, or the ray's next loop. */
BN_HOST_INLINE bn_loop bn_ray_draw_loop(const bn_sampler *s, const bn_ray *ray, uint32_t k) {
    const uint32_t domain = bn_ray_loop_domain(ray->domain, k);
    bn_loop loop;
    bn_path_draw_4d(s, &ray->path, domain, loop.next);
    loop.counter =
        bn_draw_white_counter(bn_draw_seed(s), ray->path.x, ray->path.y, ray->path.index, domain);
    loop.drawn = 0;
    return loop;
}

BN_HOST_INLINE bn_loop bn_ray_next_loop(const bn_sampler *s, bn_ray *ray) {
    return bn_ray_draw_loop(s, ray, ray->loops++);
}

/* The next number. The sampler supplies the first four, which are stratified together; the rest are
 * pseudo-random. */
BN_HOST_INLINE float bn_loop_next_1d(bn_loop *loop) {
    const uint32_t k = loop->drawn++;
    if (k > 3u && (k & 3u) == 0) {
        loop->counter.w += 0x9e3779b9u;
        bn_draw_floats(bn_draw_white_hash(loop->counter), loop->next);
    }
    return loop->next[k & 3u];
}

#endif

#ifdef __cplusplus
}
#endif

#include <bn/bn_device.h>

#endif
