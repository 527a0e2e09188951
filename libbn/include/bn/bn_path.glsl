/* SPDX-License-Identifier: Apache-2.0
 * Which domain each decision of a path draws from, in the common subset of GLSL, HLSL, Metal, CUDA
 * and C. bn_path.h compiles this text as C and CUDA, bn_path.hlsl and bn_path.metal as their
 * languages; libbn/tools/make_wgsl.py writes bn_path.wgsl from it. bn_path.h explains the layout,
 * docs/paths.md how to use it.
 *
 * In a shader, include this file after bn_draw.glsl:
 *
 *     bn_path path = bn_path_start(uint(pixel.x), uint(pixel.y), index, 0u);
 *     uint ray = bn_path_ray_domain(path, depth);
 *     vec4 u = bn_draw_blue_4d(seed, path.x, path.y, path.index, ray);
 *     vec2 v = bn_draw_blue_2d(seed, path.x, path.y, path.index, bn_ray_2d_domain(ray, 0u),
 *                               bn_ray_2d_pair(0u));
 *
 * What the C functions count, a shader numbers itself: the first further pair of a ray is 0u, the
 * next 1u, and so on. */
#ifndef BN_PATH_GLSL
#define BN_PATH_GLSL

/* Keys that no ray, no decision and no count reaches. */
#define BN_PATH_CAMERA_KEY 3u /* in place of ray 3, which moves up: what only the camera draws */
#define BN_PATH_STREAMS_KEY 0x80000000u  /* below the root: the parent of streams 1, 2 ... */
#define BN_PATH_CHILDREN_KEY 0x80000000u /* below a ray: the parent of its keyed parts */
#define BN_PATH_LOOPS_KEY 0x40000000u    /* below a ray: added to the keys of loops */
#define BN_PATH_MORE_KEY 0x40000000u     /* below a split: branches beyond their count */

/* One sample of a pixel, or a branch of it. */
struct bn_path {
    BN_UINT x, y;   /* the pixel, in two's complement */
    BN_UINT index;  /* of the sample */
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

/* Four numbers: where ray `ray` goes, and the light where it ends. */
BN_FUNCTION BN_UINT bn_path_ray_domain(bn_path path, BN_UINT ray) {
    BN_UINT key = ray;
    if (ray >= BN_PATH_CAMERA_KEY) key += 1u;
    return bn_draw_domain_child(path.domain, key);
}

/* What only the camera's ray draws: dimensions (0, 1) for the first light where it is apart, (2, 3)
 * for time and wavelength. */
BN_FUNCTION BN_UINT bn_path_camera_domain(bn_path path) {
    return bn_draw_domain_child(path.domain, BN_PATH_CAMERA_KEY);
}

/* ---- Further numbers of a ray, from its domain. Each kind has a sequence of its own, without end. */

/* The domain of single number k, and the pair there, 0 or 1, of which it is the first number or, if k is
 * odd, the second. */
BN_FUNCTION BN_UINT bn_ray_1d_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, k & 0xfffffffcu);
}

BN_FUNCTION BN_UINT bn_ray_1d_pair(BN_UINT k) {
    return k >> 1u & 1u;
}

/* The domain and the pair of pair k. */
BN_FUNCTION BN_UINT bn_ray_2d_domain(BN_UINT ray, BN_UINT k) {
    return bn_draw_domain_child(ray, (k >> 1u) * 4u + 1u);
}

BN_FUNCTION BN_UINT bn_ray_2d_pair(BN_UINT k) {
    return k & 1u;
}

/* The domain of four numbers. */
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

/* The domain of a part of a ray that has a key, from which it draws as a ray does. */
BN_FUNCTION BN_UINT bn_ray_child_domain(BN_UINT ray, BN_UINT key) {
    return bn_draw_domain_child(bn_draw_domain_child(ray, BN_PATH_CHILDREN_KEY), key);
}

/* ---- Splits */

/* Branch k of `count` of a path, below the domain of a split. Other counts have other domains, as
 * index * count + k would meet between them. With a count of 0, path.index is the number of the first
 * branch. */
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

/* Number k of a loop, 32 bits, from the domain of the loop. Numbers 0 to 3 are those that WHITE draws
 * from it; the next four are those of the same hash a step further. */
BN_FUNCTION BN_UINT bn_loop_bits(bn_uint2 seed, bn_path path, BN_UINT domain, BN_UINT k) {
    bn_uint4 v =
        bn_draw_white_bits(seed, path.x, path.y, path.index, domain + (k >> 2u) * 0x9e3779b9u);
    BN_UINT odd = 0u - (k & 1u), upper = 0u - (k >> 1u & 1u);
    BN_UINT low = v.x ^ ((v.x ^ v.y) & odd);
    return low ^ ((low ^ v.z ^ ((v.z ^ v.w) & odd)) & upper);
}

#endif
