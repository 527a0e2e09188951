/* SPDX-License-Identifier: Apache-2.0
 * A path's decisions in WGSL, translated from bn_path.glsl by libbn/tools/make_wgsl.py. Concatenate
 * this file with bn_draw.wgsl and your shader. bn_path.h explains the decisions.
 *
 *     let path = bn_path_start(u32(pixel.x), u32(pixel.y), index, 0u);
 *     let u: vec4f = bn_ray_draw(seed, bn_path_ray(path, depth)); */

/* Keys that ray numbers, decision numbers and counts never reach. */
const BN_PATH_CAMERA_KEY = 3u; /* numbers drawn once per path; ray 3 and later use key ray + 1 */
const BN_PATH_STREAMS_KEY = 0x80000000u;  /* below the root: the parent of streams 1, 2 ... */
const BN_PATH_CHILDREN_KEY = 0x80000000u; /* below a ray: the parent of its children */
const BN_PATH_LOOPS_KEY = 0x40000000u;    /* below a ray: added to the keys of loops */
const BN_PATH_MORE_KEY = 0x40000000u;     /* below a split: branches beyond their count */

/* One sample of a pixel, or a branch of that sample. */
struct bn_path {
    x: u32,
    y: u32, /* the pixel, in two's complement */
    index: u32, /* the sample index */
    domain: u32, /* the parent of the path's domains */
}

/* ---- Paths */

fn bn_path_stream_domain(stream: u32) -> u32 {
    if (stream == 0u) {
        return 0u;
    }
    return bn_domain_child(bn_domain_child(0u, BN_PATH_STREAMS_KEY), stream);
}

/* Sample `index` of pixel (x, y) in a stream. */
fn bn_path_start(x: u32, y: u32, index: u32, stream: u32) -> bn_path {
    var path: bn_path;
    path.x = x;
    path.y = y;
    path.index = index;
    path.domain = bn_path_stream_domain(stream);
    return path;
}

/* The domain of ray `ray`. Its four numbers are the ray's direction and the light sample at its end. */
fn bn_path_ray_domain(path: bn_path, ray: u32) -> u32 {
    var key = ray;
    if (ray >= BN_PATH_CAMERA_KEY) {
        key += 1u;
    }
    return bn_domain_child(path.domain, key);
}

/* The domain of numbers drawn once per path. Dimensions (0, 1) are for the first light if there is a
 * lens or a split; dimensions (2, 3) are for time and wavelength. */
fn bn_path_camera_domain(path: bn_path) -> u32 {
    return bn_domain_child(path.domain, BN_PATH_CAMERA_KEY);
}

/* ---- A ray's other numbers, from its domain. Each type of decision has its own infinite sequence. */

/* The domain of single number k, and the pair that holds it, 0 or 1. The number is the first of that
 * pair, or the second if k is odd. */
fn bn_ray_1d_domain(ray: u32, k: u32) -> u32 {
    return bn_domain_child(ray, k & 0xfffffffcu);
}

fn bn_ray_1d_pair(k: u32) -> u32 {
    return (k >> 1u) & 1u;
}

/* The domain of pair k, and which pair of the domain it is. */
fn bn_ray_2d_domain(ray: u32, k: u32) -> u32 {
    return bn_domain_child(ray, (k >> 1u) * 4u + 1u);
}

fn bn_ray_2d_pair(k: u32) -> u32 {
    return k & 1u;
}

/* The domain of the k-th 4-D decision. */
fn bn_ray_4d_domain(ray: u32, k: u32) -> u32 {
    return bn_domain_child(ray, k * 4u + 2u);
}

/* The parent of the domains of split k. */
fn bn_ray_split_domain(ray: u32, k: u32) -> u32 {
    return bn_domain_child(ray, k * 4u + 3u);
}

/* The domain of loop k. */
fn bn_ray_loop_domain(ray: u32, k: u32) -> u32 {
    return bn_domain_child(ray, (k * 4u + 3u) ^ BN_PATH_LOOPS_KEY);
}

/* The domain of a ray's child for a key. Draw from it as you would from a ray's domain. */
fn bn_ray_child_domain(ray: u32, key: u32) -> u32 {
    return bn_domain_child(bn_domain_child(ray, BN_PATH_CHILDREN_KEY), key);
}

/* ---- Splits */

/* Branch k of `count`, below a split's domain. Each count has its own domain; otherwise, values of
 * index * count + k would collide. If count is 0, path.index is the number of the first branch. */
fn bn_path_branch(path: bn_path, split: u32, count: u32, k: u32) -> bn_path {
    var branch = path;
    branch.domain = bn_domain_child(split, count);
    if (count == 0u) {
        branch.index = path.index + k;
        return branch;
    }
    branch.index = path.index * count + k % count;
    if (k >= count) {
        branch.domain = bn_domain_child(branch.domain, BN_PATH_MORE_KEY);
        branch.domain = bn_domain_child(branch.domain, k / count);
    }
    return branch;
}

/* ---- Loops */

/* The 32 bits of number k of a loop, where k is at least 4, from the loop's domain. WHITE supplies
 * four numbers per step of its counter. The sampler supplies numbers 0 to 3. */
fn bn_loop_later_bits(seed: vec2u, path: bn_path, domain: u32, k: u32) -> u32 {
    let v = bn_draw_white_bits(seed, path.x, path.y, path.index, domain + (k >> 2u) * 0x9e3779b9u);
    let odd = 0u - (k & 1u);
    let upper = 0u - ((k >> 1u) & 1u);
    let low = v.x ^ ((v.x ^ v.y) & odd);
    return low ^ ((low ^ v.z ^ ((v.z ^ v.w) & odd)) & upper);
}

/* ---- Frames */

/* How far the image, or a layer of it, has moved since the start, in two's complement. Start with
 * zeros. */
struct bn_pan {
    x: u32,
    y: u32, /* whole pixels, to subtract from the coordinates of draws */
    x_rest: u32,
    y_rest: u32, /* the rest, in units of 2^-24 pixels */
}

/* Adds a motion to (whole pixels, rest). */
fn bn_pan_add(at_in: vec2u, motion: f32) -> vec2u {
    var at = at_in;
    let bits = bitcast<u32>(motion);
    /* 2^24 pixels or more, or NaN. */
    if ((bits & 0x7fffffffu) >= 0x4b800000u) {
        return at;
    }
    let size = select(motion, -motion, motion < 0.0f);
    let whole = u32(size);
    let units = u32((size - f32(whole)) * 16777216.0f);
    let sign = 0u - (bits >> 31u);
    /* The rest, plus half a pixel to round and a whole one to stay positive. */
    let sum = at.y + ((units ^ sign) - sign) + 0x1800000u;
    at.x += ((whole ^ sign) - sign) + (sum >> 24u) - 1u;
    at.y = (sum & 0xffffffu) - 0x800000u;
    return at;
}

/* The pan after the image has moved by another (x, y) pixels; positive values point towards larger
 * coordinates. pan.x becomes the sum of all x, rounded to the nearest integer (halves upwards),
 * modulo 2^32. Each motion is truncated to a multiple of 2^-24 and then added without rounding, so errors
 * do not grow with the distance, and a motion and its opposite cancel. Coordinates that are NaN or at
 * least 2^24 in size count as 0. Results are bit-identical in all languages. */
fn bn_follow(pan_in: bn_pan, x: f32, y: f32) -> bn_pan {
    var pan = pan_in;
    var at: vec2u;
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

/* The number of bits of an index that count the samples within a frame. */
fn bn_frame_bits(most: u32) -> u32 {
    var bits = 0u;
    while (bits < 32u && (1u << bits) < most) {
        bits += 1u;
    }
    return bits;
}

/* The index of the first sample of frame 0, 1 ... of a film, and the frame's stream. `most` is the
 * largest number of samples that a pixel takes in any frame. Pass the same number for every frame, as small
 * as possible: frames gain less from each other if many indices are skipped. The index is the frame number
 * times the smallest power of two that is at least `most` (0 counts as 1), modulo 2^32. The stream is 0
 * until the indices are used up, then 1 and so on: with 1,024 samples, it changes every 4,194,304 frames. */
fn bn_frame_index(frame: u32, most: u32) -> u32 {
    let bits = bn_frame_bits(most);
    if (bits > 31u) {
        return 0u;
    }
    return frame << bits;
}

fn bn_frame_stream(frame: u32, most: u32) -> u32 {
    let bits = bn_frame_bits(most);
    if (bits == 0u) {
        return 0u;
    }
    return frame >> (32u - bits);
}

/* ---- The types of bn_path.h, for shaders. They draw from BLUE. */

fn bn_path_draw_4d(seed: vec2u, path: bn_path, domain: u32) -> vec4f {
    return bn_draw_blue_4d(seed, path.x, path.y, path.index, domain);
}

fn bn_path_draw_2d(seed: vec2u, path: bn_path, domain: u32, pair: u32) -> vec2f {
    return bn_draw_blue_2d(seed, path.x, path.y, path.index, domain, pair);
}

/* Light sample k of `count` at the end of ray 0. Call this if there is a lens, or if you take multiple
 * light samples. */
fn bn_path_first_light(seed: vec2u, path: bn_path, count: u32, k: u32) -> vec2f {
    var one = path;
    if (count > 1u) {
        one.index = path.index * count;
    }
    one.index += k;
    return bn_path_draw_2d(seed, one, bn_path_camera_domain(path), 0u);
}

/* x: time as a fraction of the shutter interval. y: position in the spectrum. */
fn bn_path_time_wavelength(seed: vec2u, path: bn_path) -> vec2f {
    return bn_path_draw_2d(seed, path, bn_path_camera_domain(path), 1u);
}

struct bn_ray {
    path: bn_path,
    domain: u32,
}

fn bn_path_ray(path: bn_path, number: u32) -> bn_ray {
    var ray: bn_ray;
    ray.path = path;
    ray.domain = bn_path_ray_domain(path, number);
    return ray;
}

/* A sub-sampler of a ray, selected by a key such as a primitive's index. Draw from it as you would
 * from a ray. */
fn bn_ray_child(ray: bn_ray, key: u32) -> bn_ray {
    var child = ray;
    child.domain = bn_ray_child_domain(ray.domain, key);
    return child;
}

/* xy: the ray's direction. zw: the light sample at its end. */
fn bn_ray_draw(seed: vec2u, ray: bn_ray) -> vec4f {
    return bn_path_draw_4d(seed, ray.path, ray.domain);
}

fn bn_ray_draw_direction(seed: vec2u, ray: bn_ray) -> vec2f {
    return bn_path_draw_2d(seed, ray.path, ray.domain, 0u);
}

fn bn_ray_draw_end_light(seed: vec2u, ray: bn_ray) -> vec2f {
    return bn_path_draw_2d(seed, ray.path, ray.domain, 1u);
}

/* Other decisions: single number k, pair k and the k-th group of four. */
fn bn_ray_draw_1d(seed: vec2u, ray: bn_ray, k: u32) -> f32 {
    let domain = bn_ray_1d_domain(ray.domain, k);
    let pair = bn_path_draw_2d(seed, ray.path, domain, bn_ray_1d_pair(k));
    if ((k & 1u) != 0u) {
        return pair.y;
    }
    return pair.x;
}

fn bn_ray_draw_2d(seed: vec2u, ray: bn_ray, k: u32) -> vec2f {
    let domain = bn_ray_2d_domain(ray.domain, k);
    return bn_path_draw_2d(seed, ray.path, domain, bn_ray_2d_pair(k));
}

fn bn_ray_draw_4d(seed: vec2u, ray: bn_ray, k: u32) -> vec4f {
    return bn_path_draw_4d(seed, ray.path, bn_ray_4d_domain(ray.domain, k));
}

struct bn_split {
    path: bn_path,
    domain: u32,
    count: u32,
}

/* Split k of a ray, into `count` branches; a count of 0 means 1. */
fn bn_ray_draw_split(ray: bn_ray, k: u32, count: u32) -> bn_split {
    var split: bn_split;
    split.path = ray.path;
    split.domain = bn_ray_split_domain(ray.domain, k);
    split.count = count;
    if (count == 0u) {
        split.count = 1u;
    }
    return split;
}

/* Split k of a ray, into any number of branches. The pixel's earlier samples took `first` branches
 * here. */
fn bn_ray_draw_split_from(ray: bn_ray, k: u32, first: u32) -> bn_split {
    var split = bn_ray_draw_split(ray, k, 1u);
    split.path.index = first;
    split.count = 0u;
    return split;
}

/* Branch k, which is itself a path. */
fn bn_split_path(split: bn_split, k: u32) -> bn_path {
    return bn_path_branch(split.path, split.domain, split.count, k);
}

struct bn_loop {
    path: bn_path,
    domain: u32,
}

/* Loop k of a ray. */
fn bn_ray_draw_loop(ray: bn_ray, k: u32) -> bn_loop {
    var walk: bn_loop;
    walk.path = ray.path;
    walk.domain = bn_ray_loop_domain(ray.domain, k);
    return walk;
}

/* Number k of a loop: the result of call k + 1 of bn_loop_next_1d() in C. */
fn bn_loop_draw_1d(seed: vec2u, walk: bn_loop, k: u32) -> f32 {
    let scale = 1.0f / 16777216.0f;
    if (k > 3u) {
        return f32(bn_loop_later_bits(seed, walk.path, walk.domain, k) >> 8u) * scale;
    }
    let pair = bn_path_draw_2d(seed, walk.path, walk.domain, k >> 1u);
    if ((k & 1u) != 0u) {
        return pair.y;
    }
    return pair.x;
}
