/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in CUDA and HIP. With RUN_ON_HOST it is a program of C++ that compares. */
#include <bn/bn_choose.h>
#include <bn/bn_draw.h>
#include <bn/bn_path.h>

BN_DEVICE_INLINE uint32_t bits_of(float v) {
    union {
        float number;
        uint32_t bits;
    } u;
    u.number = v;
    return u.bits;
}

BN_DEVICE_INLINE float number_of(uint32_t v) {
    union {
        uint32_t bits;
        float number;
    } u;
    u.bits = v;
    return u.number;
}

BN_DEVICE_INLINE void answer(const uint32_t *words, const float *cdf, const uint32_t *asked, uint32_t *result) {
    const int32_t x = int32_t(asked[1]), y = int32_t(asked[2]);
    const uint32_t index = asked[3], domain = bn_draw_domain_child(asked[4], asked[5]);
    const uint32_t kind = asked[0] & 3u, pair = asked[0] >> 2;
    bn_uint2 seed;
    seed.x = asked[10];
    seed.y = asked[11];
    bn_uint4 bits;
    bn_uint2 v;
    float draw[4], w[2];
    if (kind == 0) {
        bits = bn_draw_blue_bits(words, seed, asked[1], asked[2], index, domain);
        bn_draw_blue(words, seed, x, y, index, domain, draw);
        v = bn_draw_blue_pair_bits(words, seed, asked[1], asked[2], index, domain, pair);
        bn_draw_blue_pair(words, seed, x, y, index, domain, pair, w);
    } else if (kind == 1) {
        bits = bn_draw_sobol_bits(seed, asked[1], asked[2], index, domain);
        bn_draw_sobol(seed, x, y, index, domain, draw);
        v = bn_draw_sobol_pair_bits(seed, asked[1], asked[2], index, domain, pair);
        bn_draw_sobol_pair(seed, x, y, index, domain, pair, w);
    } else {
        bits = bn_draw_white_bits(seed, asked[1], asked[2], index, domain);
        bn_draw_white(seed, x, y, index, domain, draw);
        v = bn_draw_white_pair_bits(seed, asked[1], asked[2], index, domain, pair);
        bn_draw_white_pair(seed, x, y, index, domain, pair, w);
    }
    result[0] = domain;
    result[1] = bits.x;
    result[2] = bits.y;
    result[3] = bits.z;
    result[4] = bits.w;
    for (int d = 0; d < 4; ++d) result[5 + d] = bits_of(draw[d]);

    float u = number_of(asked[7]);
    result[9] = uint32_t(bn_choose(number_of(asked[6]), &u));
    result[10] = bits_of(u);
    u = number_of(asked[7]);
    result[11] = bn_choose_u32(asked[8], &u);
    result[12] = bits_of(u);
    u = number_of(asked[7]);
    result[13] = bn_choose_cdf(cdf + (asked[9] & 255u), asked[9] >> 8, &u);
    result[14] = bits_of(u);
    result[15] = v.x + 3 * v.y + 5 * bits_of(w[0]) + 7 * bits_of(w[1]);

    const uint32_t k = asked[13], count = asked[14];
    const bn_path path = bn_path_start(x, y, index, asked[15]);
    const uint32_t ray = bn_path_ray_domain(path, asked[12]);
    const uint32_t split = bn_ray_split_domain(ray, k);
    const bn_path branch = bn_path_branch(path, split, count, k);
    const bn_path last = bn_path_branch(branch, split, count, count);
    result[15] += 9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray +
                  19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray, k) + 23u * bn_ray_1d_pair(k) +
                  25u * bn_ray_2d_domain(ray, k) + 27u * bn_ray_2d_pair(k) + 29u * bn_ray_4d_domain(ray, k) + 31u * split +
                  33u * branch.x + 35u * branch.y + 37u * branch.index + 39u * branch.domain + 41u * last.index +
                  43u * last.domain + 45u * bn_path_rng_bits(seed, branch, split, k) +
                  47u * bn_ray_keyed_domain(ray, k);
}

#ifdef RUN_ON_HOST
#include "run_on_host.h"
#else
extern "C" __global__ void draw(const uint32_t *words, const float *cdf, const uint32_t *cases, uint32_t *results,
                                uint32_t first) {
    /* One thread a block, so that compilers without the headers of CUDA and HIP can compile this. */
    answer(words, cdf, cases + 16u * first, results + 16u * first);
}
#endif
