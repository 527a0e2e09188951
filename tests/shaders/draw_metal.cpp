/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in Metal, compiled as C++ with stand-ins for what it takes from that language. */
#include "metal_in_cpp.h"
#include <string.h>

#include "bn/bn_choose.metal"
#include "bn/bn_draw.metal"
#include "bn/bn_path.metal"
#undef device
#undef thread
#undef constant

#include "run_on_host.h"

static uint bits_of(float v) {
    uint bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static float number_of(uint bits) {
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void answer(const uint *words, const float *cdf, const uint *asked, uint *result) {
    const uint x = asked[1], y = asked[2], index = asked[3], kind = asked[0] & 3u;
    const uint pair = asked[0] >> 2;
    const uint2 seed = {asked[10], asked[11]};
    const uint domain = bn_domain_child(asked[4], asked[5]);
    const uint4 bits = kind == 0   ? bn_draw_blue_bits(words, seed, x, y, index, domain)
                       : kind == 1 ? bn_draw_sobol_bits(seed, x, y, index, domain)
                                   : bn_draw_white_bits(seed, x, y, index, domain);
    const float4 draw = kind == 0   ? bn_draw_blue(words, seed, x, y, index, domain)
                        : kind == 1 ? bn_draw_sobol(seed, x, y, index, domain)
                                    : bn_draw_white(seed, x, y, index, domain);
    const uint2 v = kind == 0   ? bn_draw_blue_pair_bits(words, seed, x, y, index, domain, pair)
                    : kind == 1 ? bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair)
                                : bn_draw_white_pair_bits(seed, x, y, index, domain, pair);
    const float2 w = kind == 0   ? bn_draw_blue_pair(words, seed, x, y, index, domain, pair)
                     : kind == 1 ? bn_draw_sobol_pair(seed, x, y, index, domain, pair)
                                 : bn_draw_white_pair(seed, x, y, index, domain, pair);
    result[0] = domain;
    memcpy(result + 1, &bits, sizeof bits);
    memcpy(result + 5, &draw, sizeof draw);
    float u = number_of(asked[7]);
    result[9] = bn_choose(number_of(asked[6]), u);
    result[10] = bits_of(u);
    u = number_of(asked[7]);
    result[11] = bn_choose_u32(asked[8], u);
    result[12] = bits_of(u);
    u = number_of(asked[7]);
    result[13] = bn_choose_cdf(cdf + (asked[9] & 255u), asked[9] >> 8, u);
    result[14] = bits_of(u);
    result[15] = v.x + 3 * v.y + 5 * bits_of(w.x) + 7 * bits_of(w.y);

    const uint k = asked[13], count = asked[14];
    const bn_path path = bn_path_start(x, y, index, asked[15]);
    const uint ray = bn_path_ray_domain(path, asked[12]);
    const uint split = bn_ray_split_domain(ray, k);
    const bn_path branch = bn_path_branch(path, split, count, k);
    const bn_path last = bn_path_branch(branch, split, count, count);
    result[15] +=
        9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray +
        19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray, k) +
        23u * bn_ray_1d_pair(k) + 25u * bn_ray_2d_domain(ray, k) + 27u * bn_ray_2d_pair(k) +
        29u * bn_ray_4d_domain(ray, k) + 31u * split + 33u * branch.x + 35u * branch.y +
        37u * branch.index + 39u * branch.domain + 41u * last.index + 43u * last.domain +
        45u * bn_path_rng_bits(seed, branch, split, k) + 47u * bn_ray_keyed_domain(ray, k);
}
