/* SPDX-License-Identifier: Apache-2.0
 * Cycles' sampling pattern `blue`: the libbn numbers that path_rng_1D() and its variants return. README.md shows
 * the layout in a table. The draws use 32-bit integer arithmetic and run on every device; they read their table
 * from sample_pattern_lut. */
#pragma once

CCL_NAMESPACE_BEGIN

#define BN_UINT uint
#define BN_FUNCTION ccl_device_inline
#define BN_TABLE KernelGlobals kg,
#define BN_PASS_TABLE kg,
#define BN_WORD(i) __float_as_uint(kernel_data_fetch(sample_pattern_lut, (i)))
#define BN_REVERSE_BITS(v) reverse_integer_bits(v)
#include "kernel/sample/bn_draw.glsl"
#include "kernel/sample/bn_path.glsl"

/* Packs the pixel's coordinates, which must be below 65536, and combines them with the seed. Cycles also hashes the
 * result to seed generators. */
ccl_device_inline uint blue_pixel(KernelGlobals kg, const int x, const int y) {
    return ((uint(x) & 0xffffu) | uint(y) << 16) ^ kernel_data.integrator.seed;
}

ccl_device_inline bn_path blue_path(KernelGlobals kg, const uint rng_pixel, const uint sample) {
    const uint pixel = rng_pixel ^ kernel_data.integrator.seed;
    return bn_path_start(pixel & 0xffffu, pixel >> 16, sample, 0u);
}

/* The seed is stored after the tables. */
ccl_device_inline bn_uint2 blue_seed(KernelGlobals kg) {
    bn_uint2 seed;
    seed.x = BN_WORD(BN_WORD_COUNT);
    seed.y = BN_WORD(BN_WORD_COUNT + 1);
    return seed;
}

/* Pair 0 or 1 of a domain, in [0, 1). */
ccl_device_inline float2 blue_pair(KernelGlobals kg, const bn_path path, const uint domain,
                                   const uint pair) {
    const bn_uint2 v =
        bn_draw_blue_pair_bits(kg, blue_seed(kg), path.x, path.y, path.index, domain, pair);
    return make_float2(float(v.x >> 8) * (1.0f / 16777216.0f),
                       float(v.y >> 8) * (1.0f / 16777216.0f));
}

/* The domain of a decision. The pixel position and the lens share the domain of ray 0. Time and the first light
 * share the camera's domain. A scattered ray's direction uses that ray's domain. Every other decision has its own
 * domain. */
ccl_device_inline uint blue_domain(const bn_path path, const int dimension) {
    const uint bounce = uint(dimension) / PRNG_BOUNCE_NUM, slot = uint(dimension) % PRNG_BOUNCE_NUM;
    if (dimension == PRNG_BOUNCE_NUM + PRNG_LIGHT) {
        return bn_path_camera_domain(path);
    }
    const uint ray = bn_path_ray_domain(path, bounce);
    if (bounce == 0u || slot == PRNG_SURFACE_BSDF) {
        return ray;
    }
    return bn_ray_4d_domain(ray, slot);
}

ccl_device_inline float blue_sample_1D(KernelGlobals kg, const uint rng_pixel, const uint sample,
                                       const int dimension) {
    const bn_path path = blue_path(kg, rng_pixel, sample);
    const uint bounce = uint(dimension) / PRNG_BOUNCE_NUM, slot = uint(dimension) % PRNG_BOUNCE_NUM;
    const uint ray = bn_path_ray_domain(path, bounce);
    return blue_pair(kg, path, bn_ray_1d_domain(ray, 4u * slot), 0u).x;
}

ccl_device_inline float2 blue_sample_2D(KernelGlobals kg, const uint rng_pixel, const uint sample,
                                        const int dimension) {
    const bn_path path = blue_path(kg, rng_pixel, sample);
    return blue_pair(kg, path, blue_domain(path, dimension), 0u);
}

/* A pair and a number: a point on a light and the light, or a direction and the lobe. For PRNG_LENS_TIME, the time and
 * then the lens. */
ccl_device_inline float3 blue_sample_3D(KernelGlobals kg, const uint rng_pixel, const uint sample,
                                        const int dimension) {
    const bn_path path = blue_path(kg, rng_pixel, sample);
    const uint domain = blue_domain(path, dimension);
    if (dimension == PRNG_LENS_TIME) {
        const float2 time = blue_pair(kg, path, bn_path_camera_domain(path), 1u),
                     lens = blue_pair(kg, path, domain, 1u);
        return make_float3(time.x, lens.x, lens.y);
    }
    const float2 two = blue_pair(kg, path, domain, 0u), more = blue_pair(kg, path, domain, 1u);
    return make_float3(two.x, two.y, dimension == PRNG_BOUNCE_NUM + PRNG_LIGHT ? more.y : more.x);
}

ccl_device_inline float4 blue_sample_4D(KernelGlobals kg, const uint rng_pixel, const uint sample,
                                        const int dimension) {
    const bn_path path = blue_path(kg, rng_pixel, sample);
    const uint domain = blue_domain(path, dimension);
    const float2 two = blue_pair(kg, path, domain, 0u), more = blue_pair(kg, path, domain, 1u);
    return make_float4(two.x, two.y, more.x, more.y);
}

CCL_NAMESPACE_END
