/* SPDX-License-Identifier: Apache-2.0
 * A path's decisions in the common subset of GLSL, HLSL, Metal, CUDA and C. bn_path.h explains them and
 * uses the first part of this file in C and CUDA. bn_path.hlsl and bn_path.metal use all of it, and
 * libbn/tools/make_wgsl.py translates it to bn_path.wgsl.
 *
 * Include this file after bn_draw.glsl. Names and results are the same as in C, except that there are
 * no counters: the shader itself numbers a ray's splits, loops and other decisions, starting at 0u.
 *
 *     bn_path path = bn_path_start(uint(pixel.x), uint(pixel.y), index, 0u);
 *     bn_ray ray = bn_path_ray(path, depth);
 *     vec4 u = bn_ray_draw(seed, ray);
 *     vec2 probe = bn_ray_draw_2d(seed, ray, 0u);
 *
 * All draws use BLUE. For SOBOL and WHITE, pass the domains below to bn_draw_sobol_4d() and related
 * functions. */
#ifndef BN_PATH_GLSL
#define BN_PATH_GLSL

/* Keys that ray numbers, decision numbers and counts never reach. */
#define BN_PATH_CAMERA_KEY 3u /* numbers drawn once per path; ray 3 and later use key ray + 1 */
#define BN_PATH_STREAMS_KEY 0x80000000u  /* below the root: the parent of streams 1, 2 ... */
#define BN_PATH_CHILDREN_KEY 0x80000000u /* below a ray: the parent of its children */
#define BN_PATH_LOOPS_KEY 0x40000000u    /* below a ray: added to the keys of loops */
#define BN_PATH_MORE_KEY 0x40000000u     /* below a split: branches beyond their count */

/* One sample of a pixel, or a branch of that sample. */
struct bn_path {
    BN_UINT x, y;   /* the pixel, in two's complement */
    BN_UINT index;  /* the sample index */
    BN_UINT domain; /* the parent of the path's domains */
};

/* ---- Paths */

BN_FUNCTION BN_UINT bn_path_stream_domain(BN_UINT stream) {
    if (stream == 0u) return 0u;
    return bn_draw_domain_child(bn_draw_domain_child(0u, BN_PATH_STREAMS_KEY), stream);
}

#ifndef BN_PATH_IN_C
/* Sample `index` of pixel (x, y) in a stream. */
BN_FUNCTION bn_path bn_path_start(BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT stream) {
    bn_path path;
    path.x = x;
    path.y = y;
    path.index = index;
    path.domain = bn_path_stream_domain(stream);
    return path;
}
#endif

/* The domain of ray `ray`. Its four numbers are the ray's direction and the light sample at its end. */
BN_FUNCTION BN_UINT bn_path_ray_domain(bn_path path, BN_UINT ray) {
    BN_UINT key = ray;
    if (ray >= BN_PATH_CAMERA_KEY) key += 1u;
    return bn_draw_domain_child(path.domain, key);
}

/* The domain of numbers drawn once per path. Dimensions (0, 1) are for the first light if there is a
 * lens or a split; dimensions (2, 3) are for time and wavelength. */
BN_FUNCTION BN_UINT bn_path_camera_domain(bn_path path) {
    return bn_draw_domain_child(path.domain, BN_PATH_CAMERA_KEY);
}

/* ---- A ray's other numbers, from its domain. Each type of decision has its own infinite sequence. */

/* The domain of single number k, and the pair that holds it, 0 or 1. The number is the first of that
 * pair, or the second if k is odd. */
BN_FUNCTION BN_UINT bn_ray_1d_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, k & 0xfffffffcu);
}

BN_FUNCTION BN_UINT bn_ray_1d_pair(BN_UINT k) {
    return k >> 1u & 1u;
}

/* The domain of pair k, and which pair of the domain it is. */
BN_FUNCTION BN_UINT bn_ray_2d_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, (k >> 1u) * 4u + 1u);
}

BN_FUNCTION BN_UINT bn_ray_2d_pair(BN_UINT k) {
    return k & 1u;
}

/* The domain of the k-th 4-D decision. */
BN_FUNCTION BN_UINT bn_ray_4d_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, k * 4u + 2u);
}

/* The parent of the domains of split k. */
BN_FUNCTION BN_UINT bn_ray_split_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, k * 4u + 3u);
}

/* The domain of loop k. */
BN_FUNCTION BN_UINT bn_ray_loop_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, (k * 4u + 3u) ^ BN_PATH_LOOPS_KEY);
}

/* The domain of a ray's child for a key. Draw from it as you would from a ray's domain. */
BN_FUNCTION BN_UINT bn_ray_child_domain(BN_UINT ray, BN_UINT key) {
    return bn_draw_domain_child(bn_draw_domain_child(ray, BN_PATH_CHILDREN_KEY), key);
}

/* ---- Splits */

/* Branch k of `count`, below a split's domain. Each count has its own domain; otherwise, values of
 * index * count + k would collide. If count is 0, path.index is the number of the first branch. */
BN_FUNCTION bn_path bn_path_branch(bn_path path, BN_UINT split, BN_UINT count, BN_UINT k) {
    bn_path branch = path;
    branch.domain = bn_draw_domain_child(split, count);
    if (count == 0u) {
        branch.index = path.index + k;
        return branch;
    }
    branch.index = path.index * count + k % count;
    if (k >= count) {
        branch.domain = bn_draw_domain_child(branch.domain, BN_PATH_MORE_KEY);
        branch.domain = bn_draw_domain_child(branch.domain, k / count);
    }
    return branch;
}

/* ---- Loops */

/* The 32 bits of number k of a loop, where k is at least 4, from the loop's domain. WHITE supplies
 * four numbers per step of its counter. The sampler supplies numbers 0 to 3. */
BN_FUNCTION BN_UINT bn_loop_later_bits(bn_uint2 seed, bn_path path, BN_UINT domain, BN_UINT k) {
    bn_uint4 v =
        bn_draw_white_bits(seed, path.x, path.y, path.index, domain + (k >> 2u) * 0x9e3779b9u);
    BN_UINT odd = 0u - (k & 1u), upper = 0u - (k >> 1u & 1u);
    BN_UINT low = v.x ^ ((v.x ^ v.y) & odd);
    return low ^ ((low ^ v.z ^ ((v.z ^ v.w) & odd)) & upper);
}

/* ---- Frames */

#ifndef BN_FLOAT_BITS
#ifdef BN_FLOAT4
#define BN_FLOAT_BITS(v) floatBitsToUint(v)
#endif
#endif
#ifndef BN_TO_UINT
#define BN_TO_UINT(v) uint(v)
#define BN_TO_FLOAT(v) float(v)
#endif

#ifdef BN_FLOAT_BITS
/* How far the image, or a layer of it, has moved since the start, in two's complement. Start with
 * zeros. */
struct bn_pan {
    BN_UINT x, y;           /* whole pixels, to subtract from the coordinates of draws */
    BN_UINT x_rest, y_rest; /* the rest, in units of 2^-24 pixels */
};

/* Adds a motion to (whole pixels, rest). */
BN_FUNCTION bn_uint2 bn_pan_add(bn_uint2 at, float motion) {
    BN_UINT bits = BN_FLOAT_BITS(motion);
    /* 2^24 pixels or more, or NaN. */
    if ((bits & 0x7fffffffu) >= 0x4b800000u) return at;
    float size = motion < 0.0f ? -motion : motion;
    BN_UINT whole = BN_TO_UINT(size);
    BN_UINT units = BN_TO_UINT((size - BN_TO_FLOAT(whole)) * 16777216.0f);
    BN_UINT sign = 0u - (bits >> 31u);
    /* The rest, plus half a pixel to round and a whole one to stay positive. */
    BN_UINT sum = at.y + ((units ^ sign) - sign) + 0x1800000u;
    at.x += ((whole ^ sign) - sign) + (sum >> 24u) - 1u;
    at.y = (sum & 0xffffffu) - 0x800000u;
    return at;
}

/* The pan after the image has moved by another (x, y) pixels; positive values point towards larger
 * coordinates. pan.x becomes the sum of all x, rounded to the nearest integer (halves upwards),
 * modulo 2^32. Each motion is truncated to a multiple of 2^-24 and then added without rounding, so errors
 * do not grow with the distance, and a motion and its opposite cancel. Coordinates that are NaN or at
 * least 2^24 in size count as 0. Results are bit-identical in all languages. */
BN_FUNCTION bn_pan bn_follow(bn_pan pan, float x, float y) {
    bn_uint2 at;
    at.x = pan.x;
    at.y = pan.x_rest;
    at = bn_pan_add(at, x);
    pan.x = at.x;
    pan.x_rest = at.y;
    at.x = pan.y;
    at.y = pan.y_rest;
    at = bn_pan_add(at, y);
    pan.y = at.x;
    pan.y_rest = at.y;
    return pan;
}
#endif

/* The number of bits of an index that count the samples within a frame. */
BN_FUNCTION BN_UINT bn_frame_bits(BN_UINT most) {
    BN_UINT bits = 0u;
    while (bits < 32u && (1u << bits) < most) bits += 1u;
    return bits;
}

/* The index of the first sample of frame 0, 1 ... of a film, and the frame's stream. `most` is the
 * largest number of samples that a pixel takes in any frame. Pass the same number for every frame, as small
 * as possible: frames gain less from each other if many indices are skipped. The index is the frame number
 * times the smallest power of two that is at least `most` (0 counts as 1), modulo 2^32. The stream is 0
 * until the indices are used up, then 1 and so on: with 1,024 samples, it changes every 4,194,304 frames. */
BN_FUNCTION BN_UINT bn_frame_index(BN_UINT frame, BN_UINT most) {
    BN_UINT bits = bn_frame_bits(most);
    if (bits > 31u) return 0u;
    return frame << bits;
}

BN_FUNCTION BN_UINT bn_frame_stream(BN_UINT frame, BN_UINT most) {
    BN_UINT bits = bn_frame_bits(most);
    if (bits == 0u) return 0u;
    return frame >> (32u - bits);
}

/* ---- The types of bn_path.h, for shaders. They draw from BLUE. */

#ifdef BN_FLOAT4
BN_FUNCTION BN_FLOAT4 bn_path_draw_4d(BN_TABLE bn_uint2 seed, bn_path path, BN_UINT domain) {
    return bn_draw_blue_4d(BN_PASS_TABLE seed, path.x, path.y, path.index, domain);
}

BN_FUNCTION BN_FLOAT2 bn_path_draw_2d(BN_TABLE bn_uint2 seed, bn_path path, BN_UINT domain,
                                      BN_UINT pair) {
    return bn_draw_blue_2d(BN_PASS_TABLE seed, path.x, path.y, path.index, domain, pair);
}

/* Light sample k of `count` at the end of ray 0. Call this if there is a lens, or if you take multiple
 * light samples. */
BN_FUNCTION BN_FLOAT2 bn_path_first_light(BN_TABLE bn_uint2 seed, bn_path path, BN_UINT count,
                                          BN_UINT k) {
    bn_path one = path;
    if (count > 1u) one.index = path.index * count;
    one.index += k;
    return bn_path_draw_2d(BN_PASS_TABLE seed, one, bn_path_camera_domain(path), 0u);
}

/* x: time as a fraction of the shutter interval. y: position in the spectrum. */
BN_FUNCTION BN_FLOAT2 bn_path_time_wavelength(BN_TABLE bn_uint2 seed, bn_path path) {
    return bn_path_draw_2d(BN_PASS_TABLE seed, path, bn_path_camera_domain(path), 1u);
}

struct bn_ray {
    bn_path path;
    BN_UINT domain;
};

BN_FUNCTION bn_ray bn_path_ray(bn_path path, BN_UINT number) {
    bn_ray ray;
    ray.path = path;
    ray.domain = bn_path_ray_domain(path, number);
    return ray;
}

/* A sub-sampler of a ray, selected by a key such as a primitive's index. Draw from it as you would
 * from a ray. */
BN_FUNCTION bn_ray bn_ray_child(bn_ray ray, BN_UINT key) {
    bn_ray child = ray;
    child.domain = bn_ray_child_domain(ray.domain, key);
    return child;
}

/* xy: the ray's direction. zw: the light sample at its end. */
BN_FUNCTION BN_FLOAT4 bn_ray_draw(BN_TABLE bn_uint2 seed, bn_ray ray) {
    return bn_path_draw_4d(BN_PASS_TABLE seed, ray.path, ray.domain);
}

BN_FUNCTION BN_FLOAT2 bn_ray_draw_direction(BN_TABLE bn_uint2 seed, bn_ray ray) {
    return bn_path_draw_2d(BN_PASS_TABLE seed, ray.path, ray.domain, 0u);
}

BN_FUNCTION BN_FLOAT2 bn_ray_draw_end_light(BN_TABLE bn_uint2 seed, bn_ray ray) {
    return bn_path_draw_2d(BN_PASS_TABLE seed, ray.path, ray.domain, 1u);
}

/* Other decisions: single number k, pair k and the k-th group of four. */
BN_FUNCTION float bn_ray_draw_1d(BN_TABLE bn_uint2 seed, bn_ray ray, BN_UINT k) {
    BN_UINT domain = bn_ray_1d_domain(ray.domain, k);
    BN_FLOAT2 pair = bn_path_draw_2d(BN_PASS_TABLE seed, ray.path, domain, bn_ray_1d_pair(k));
    if ((k & 1u) != 0u) return pair.y;
    return pair.x;
}

BN_FUNCTION BN_FLOAT2 bn_ray_draw_2d(BN_TABLE bn_uint2 seed, bn_ray ray, BN_UINT k) {
    BN_UINT domain = bn_ray_2d_domain(ray.domain, k);
    return bn_path_draw_2d(BN_PASS_TABLE seed, ray.path, domain, bn_ray_2d_pair(k));
}

BN_FUNCTION BN_FLOAT4 bn_ray_draw_4d(BN_TABLE bn_uint2 seed, bn_ray ray, BN_UINT k) {
    return bn_path_draw_4d(BN_PASS_TABLE seed, ray.path, bn_ray_4d_domain(ray.domain, k));
}

struct bn_split {
    bn_path path;
    BN_UINT domain, count;
};

/* Split k of a ray, into `count` branches; a count of 0 means 1. */
BN_FUNCTION bn_split bn_ray_draw_split(bn_ray ray, BN_UINT k, BN_UINT count) {
    bn_split split;
    split.path = ray.path;
    split.domain = bn_ray_split_domain(ray.domain, k);
    split.count = count;
    if (count == 0u) split.count = 1u;
    return split;
}

/* Split k of a ray, into any number of branches. The pixel's earlier samples took `first` branches
 * here. */
BN_FUNCTION bn_split bn_ray_draw_split_from(bn_ray ray, BN_UINT k, BN_UINT first) {
    bn_split split = bn_ray_draw_split(ray, k, 1u);
    split.path.index = first;
    split.count = 0u;
    return split;
}

/* Branch k, which is itself a path. */
BN_FUNCTION bn_path bn_split_path(bn_split split, BN_UINT k) {
    return bn_path_branch(split.path, split.domain, split.count, k);
}

struct bn_loop {
    bn_path path;
    BN_UINT domain;
};

/* Loop k of a ray. */
BN_FUNCTION bn_loop bn_ray_draw_loop(bn_ray ray, BN_UINT k) {
    bn_loop walk;
    walk.path = ray.path;
    walk.domain = bn_ray_loop_domain(ray.domain, k);
    return walk;
}

/* Number k of a loop: the result of call k + 1 of bn_loop_next_1d() in C. */
BN_FUNCTION float bn_loop_draw_1d(BN_TABLE bn_uint2 seed, bn_loop walk, BN_UINT k) {
    float scale = 1.0f / 16777216.0f;
    if (k > 3u) return float(bn_loop_later_bits(seed, walk.path, walk.domain, k) >> 8u) * scale;
    BN_FLOAT2 pair = bn_path_draw_2d(BN_PASS_TABLE seed, walk.path, walk.domain, k >> 1u);
    if ((k & 1u) != 0u) return pair.y;
    return pair.x;
}
#endif

#endif
