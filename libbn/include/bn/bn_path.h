/* SPDX-License-Identifier: Apache-2.0
 * The decisions of a path as an object: every number that a path tracer draws, by the name of what
 * it is for, so that no two decisions of a path share one. Inline over bn_draw.h:
 *
 *     bn_path path = bn_path_start(x, y, index, 0);
 *     for (uint32_t depth = 0; depth < max_depth; ++depth) {
 *         float u[4];
 *         bn_ray ray = bn_path_ray(&path, depth);
 *         bn_ray_draw(sampler, &ray, u);           // where the ray goes, a light where it ends
 *         float lobe = bn_ray_next_1d(sampler, &ray);   // further numbers: as many as you like
 *         bn_ray_next_2d(sampler, &ray, probe);
 *     }
 *
 * THE LAYOUT
 *
 * Ray 0 leaves the camera, ray d the d-th surface or other event. Each has a domain of four numbers:
 *
 *     u[0], u[1]   where it goes: the position in the pixel for ray 0, the direction for others
 *     u[2], u[3]   which point on which light is tried where it ends
 *
 * The two multiply in what the path contributes, so they are stratified together. Rays 0, 1 and 2
 * and bn_path_first_light() are a family, the next best thing; so are each next four rays.
 *
 * A lens takes the second pair of ray 0: its effect multiplies with the position in the pixel. The
 * first light then comes from bn_path_first_light(), and so it does where it is split into several.
 * Time, where things move, and wavelength come from bn_path_time_wavelength(): take them once, and
 * hand them to the branches of the path, whose own would differ.
 *
 * Every further decision takes what bn_ray_next_1d(), bn_ray_next_2d() and bn_ray_next_4d() hand
 * out. Each has a sequence of its own below the ray, so a further number never shifts the pairs, nor
 * the numbers of another ray. (Domains are hashes: bn_domain_child() says how seldom two are equal.)
 * Pixels that drew differently at one ray agree again at the next.
 * A number and then a pair, such as a light and the point on it, are u[2] and (u[0], u[1]) of
 * bn_ray_next_4d().
 *
 * Make one bn_ray for each ray and hand it on by pointer. A second bn_ray of the same path and ray
 * starts again, with the same numbers. Where a path goes on in several ways, each way is a branch:
 *
 *     bn_split split = bn_ray_next_split(&ray, count);
 *     for (uint32_t k = 0; k < count; ++k) {
 *         bn_path branch = bn_split_path(&split, k); // its rays begin at 0
 *
 * `count` is the same for all samples of the pixel. Where it varies, keep for each pixel how many
 * branches its earlier samples took, and begin there: bn_ray_next_split_from(&ray, taken). Without such a
 * number, give a count near the mean. Those that take fewer branches stop early; those that take
 * more go on with k = count and later.
 *
 * Decisions that neighbours meet in another order, such as the transparency of layers, have keys
 * instead: bn_ray_child(&ray, primitive). A loop without bound (tracking through a medium, a random
 * walk) draws from bn_ray_next_loop(): four stratified numbers, and from then on a counter-based
 * generator.
 *
 * If you keep the numbers of decisions elsewhere, or know them when compiling, pass them yourself:
 * bn_ray_draw_1d(sampler, &ray, k) is number k of a ray, the one that call k + 1 of bn_ray_next_1d()
 * hands out. So do bn_ray_draw_2d(), bn_ray_draw_4d(), bn_ray_draw_loop() and bn_ray_draw_split(), and
 * shaders with the domains of bn_path.glsl.
 *
 * docs/paths.md has the decisions of a renderer one by one. All functions are pure, allocate nothing
 * and cannot fail. Rays and counts of decisions lie below 2^28, and index * count below 2^32. */
#ifndef BN_BN_PATH_H
#define BN_BN_PATH_H

#include <bn/bn_draw.h>

#include <bn/bn_device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- The text that shaders share */

/* 16 bytes: what to keep for each lane, besides the sampler. */
typedef struct bn_path bn_path;

#define BN_PATH_IN_C
#include <bn/bn_path.glsl>
#undef BN_PATH_IN_C

/* ---- Paths */

/* Sample `index` of pixel (x, y), coordinates as in bn_sample_4d(). Streams are independent sequences of
 * samples: the frames of a film, or light paths beside camera paths. Where frames are averaged, the index
 * goes on from frame to frame, and the stream stays 0. */
BN_DEVICE_INLINE bn_path bn_path_start(int32_t x, int32_t y, uint32_t index, uint32_t stream) {
    bn_path path;
    path.x = (uint32_t)x;
    path.y = (uint32_t)y;
    path.index = index;
    path.domain = bn_path_stream_domain(stream);
    return path;
}

/* A ray of a path, with the numbers of further decisions that it has handed out. */
typedef struct bn_ray {
    bn_path path;
    uint32_t domain;
    uint32_t drawn_1d, drawn_2d, drawn_4d, splits, loops;
    float kept_1d; /* drawn with the single number before it */
} bn_ray;

BN_DEVICE_INLINE bn_ray bn_path_ray(const bn_path *path, uint32_t ray) {
    bn_ray result;
    result.path = *path;
    result.domain = bn_path_ray_domain(*path, ray);
    result.drawn_1d = result.drawn_2d = result.drawn_4d = result.splits = result.loops = 0;
    result.kept_1d = 0.0f;
    return result;
}

/* A part of a ray whose numbers have a key instead of a place in a sequence: a primitive that may
 * be transparent, a stage of a wavefront renderer, a light. The result draws like a ray of its own,
 * and does not depend on what was drawn before it. A second part of the same key starts again. */
BN_DEVICE_INLINE bn_ray bn_ray_child(const bn_ray *ray, uint32_t key) {
    bn_ray result = *ray;
    result.domain = bn_ray_child_domain(ray->domain, key);
    result.drawn_1d = result.drawn_2d = result.drawn_4d = result.splits = result.loops = 0;
    result.kept_1d = 0.0f;
    return result;
}

/* ---- Splits */

typedef struct bn_split {
    bn_path path;
    uint32_t domain, count; /* a count of 0: branches are numbered on from path.index */
} bn_split;

/* Split k of a ray, into `count` branches; 0 counts as 1. */
BN_DEVICE_INLINE bn_split bn_ray_draw_split(const bn_ray *ray, uint32_t k, uint32_t count) {
    bn_split split;
    split.path = ray->path;
    split.domain = bn_ray_split_domain(ray->domain, k);
    split.count = count > 0 ? count : 1;
    return split;
}

/* The next split of a ray. */
BN_DEVICE_INLINE bn_split bn_ray_next_split(bn_ray *ray, uint32_t count) {
    return bn_ray_draw_split(ray, ray->splits++, count);
}

/* The next split of a ray, into any number of branches. `first` is the number of branches that the
 * earlier samples of the pixel took here: 0 for its first sample. */
BN_DEVICE_INLINE bn_split bn_ray_next_split_from(bn_ray *ray, uint32_t first) {
    bn_split split = bn_ray_next_split(ray, 1);
    split.path.index = first;
    split.count = 0;
    return split;
}

/* Branch k, a path of its own. */
BN_DEVICE_INLINE bn_path bn_split_path(const bn_split *split, uint32_t k) {
    return bn_path_branch(split->path, split->domain, split->count, k);
}

#ifndef BN_DEVICE_ONLY

/* ---- The numbers of a ray, in [0, 1), with a sampler of any type */

BN_HOST_INLINE void bn_path_draw_4d(const bn_sampler *sampler, const bn_path *path, uint32_t domain,
                                    float out[4]) {
    bn_draw_4d(sampler, (int32_t)path->x, (int32_t)path->y, path->index, domain, out);
}

BN_HOST_INLINE void bn_path_draw_2d(const bn_sampler *sampler, const bn_path *path, uint32_t domain,
                                    uint32_t pair, float out[2]) {
    bn_draw_2d(sampler, (int32_t)path->x, (int32_t)path->y, path->index, domain, pair, out);
}

/* out[0], out[1]: where the ray goes. out[2], out[3]: a light where it ends. */
BN_HOST_INLINE void bn_ray_draw(const bn_sampler *sampler, const bn_ray *ray, float out[4]) {
    bn_path_draw_4d(sampler, &ray->path, ray->domain, out);
}

/* Either pair of the same numbers alone, for rays that need no other. */
BN_HOST_INLINE void bn_ray_draw_direction(const bn_sampler *sampler, const bn_ray *ray,
                                          float out[2]) {
    bn_path_draw_2d(sampler, &ray->path, ray->domain, 0, out);
}

BN_HOST_INLINE void bn_ray_draw_end_light(const bn_sampler *sampler, const bn_ray *ray,
                                          float out[2]) {
    bn_path_draw_2d(sampler, &ray->path, ray->domain, 1, out);
}

/* Number, pair and four k of the ray, by an explicit counter: what call k + 1 of the functions below
 * gives. They leave the ray as it is. */
BN_HOST_INLINE float bn_ray_draw_1d(const bn_sampler *sampler, const bn_ray *ray, uint32_t k) {
    float pair[2];
    bn_path_draw_2d(sampler, &ray->path, bn_ray_1d_domain(ray->domain, k), bn_ray_1d_pair(k), pair);
    return pair[k & 1u];
}

BN_HOST_INLINE void bn_ray_draw_2d(const bn_sampler *sampler, const bn_ray *ray, uint32_t k,
                                   float out[2]) {
    bn_path_draw_2d(sampler, &ray->path, bn_ray_2d_domain(ray->domain, k), bn_ray_2d_pair(k), out);
}

BN_HOST_INLINE void bn_ray_draw_4d(const bn_sampler *sampler, const bn_ray *ray, uint32_t k,
                                   float out[4]) {
    bn_path_draw_4d(sampler, &ray->path, bn_ray_4d_domain(ray->domain, k), out);
}

/* The next single number of the ray. Four in a row are stratified together. Two are drawn at a time, so
 * every second call is free. */
BN_HOST_INLINE float bn_ray_next_1d(const bn_sampler *sampler, bn_ray *ray) {
    const uint32_t k = ray->drawn_1d++;
    float pair[2];
    if (k & 1u) return ray->kept_1d;
    bn_path_draw_2d(sampler, &ray->path, bn_ray_1d_domain(ray->domain, k), bn_ray_1d_pair(k), pair);
    ray->kept_1d = pair[1];
    return pair[0];
}

/* The next pair. Two in a row are stratified together. */
BN_HOST_INLINE void bn_ray_next_2d(const bn_sampler *sampler, bn_ray *ray, float out[2]) {
    bn_ray_draw_2d(sampler, ray, ray->drawn_2d++, out);
}

/* The next four: two pairs whose effects multiply, or a number and a pair, out[2] and then out[0],
 * out[1]. */
BN_HOST_INLINE void bn_ray_next_4d(const bn_sampler *sampler, bn_ray *ray, float out[4]) {
    bn_ray_draw_4d(sampler, ray, ray->drawn_4d++, out);
}

/* ---- What only the camera's ray draws */

/* The light tried where ray 0 ends, if a lens has taken its pair, or if it is split into
 * `count` points: then k is 0 to count - 1. `count` is the same for all samples of the pixel; 0
 * counts as 1. */
BN_HOST_INLINE void bn_path_first_light(const bn_sampler *sampler, const bn_path *path,
                                        uint32_t count, uint32_t k, float out[2]) {
    bn_draw_2d(sampler, (int32_t)path->x, (int32_t)path->y,
               path->index * (count == 0 ? 1 : count) + k, bn_path_camera_domain(*path), 0, out);
}

/* Time and wavelength of the path: out[0] is its place in the shutter's interval, out[1] its place in
 * the spectrum (the first of several that stand at equal distances). */
BN_HOST_INLINE void bn_path_time_wavelength(const bn_sampler *sampler, const bn_path *path,
                                            float out[2]) {
    bn_path_draw_2d(sampler, path, bn_path_camera_domain(*path), 1, out);
}

/* ---- Loops */

typedef struct bn_loop {
    float next[4];
    bn_uint4 counter; /* of WHITE, for the numbers after the first four */
    uint32_t drawn;
} bn_loop;

/* The numbers of loop k of a ray. */
BN_HOST_INLINE bn_loop bn_ray_draw_loop(const bn_sampler *sampler, const bn_ray *ray, uint32_t k) {
    const uint32_t domain = bn_ray_loop_domain(ray->domain, k);
    bn_loop loop;
    bn_path_draw_4d(sampler, &ray->path, domain, loop.next);
    loop.counter = bn_draw_white_counter(bn_draw_seed(sampler), ray->path.x, ray->path.y,
                                         ray->path.index, domain);
    loop.drawn = 0;
    return loop;
}

/* Those of its next loop. */
BN_HOST_INLINE bn_loop bn_ray_next_loop(const bn_sampler *sampler, bn_ray *ray) {
    return bn_ray_draw_loop(sampler, ray, ray->loops++);
}

/* The next number of a loop, in [0, 1). The first four are the sampler's. */
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
