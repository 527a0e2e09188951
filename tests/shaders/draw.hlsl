/* SPDX-License-Identifier: Apache-2.0
 * The same as draw.comp in HLSL. */
[[vk::binding(0)]] StructuredBuffer<uint> bn_words : register(t0);
[[vk::binding(1)]] StructuredBuffer<float> bn_cdf : register(t1);
[[vk::binding(2)]] StructuredBuffer<uint> cases : register(t2);
[[vk::binding(3)]] RWStructuredBuffer<uint> results : register(u0);
#define BN_WORD(i) bn_words[i]
#include "bn_draw.hlsl"
#include "bn_path.hlsl"
#define BN_CDF(i) bn_cdf[i]
#include "bn_choose.hlsl"

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint at = 16u * id.x, count, stride;
    cases.GetDimensions(count, stride);
    if (at >= count) return;
    uint kind = cases[at] & 3u, x = cases[at + 1u], y = cases[at + 2u], index = cases[at + 3u];
    uint domain = bn_domain_child(cases[at + 4u], cases[at + 5u]);
    uint pair = cases[at] >> 2u;
    uint2 seed = uint2(cases[at + 10u], cases[at + 11u]);
    uint4 bits;
    uint2 v;
    float4 draw;
    float2 w;
    if (kind == 0u) {
        bits = bn_draw_blue_bits(seed, x, y, index, domain);
        draw = bn_draw_blue(seed, x, y, index, domain);
        v = bn_draw_blue_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_blue_pair(seed, x, y, index, domain, pair);
    } else if (kind == 1u) {
        bits = bn_draw_sobol_bits(seed, x, y, index, domain);
        draw = bn_draw_sobol(seed, x, y, index, domain);
        v = bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_sobol_pair(seed, x, y, index, domain, pair);
    } else {
        bits = bn_draw_white_bits(seed, x, y, index, domain);
        draw = bn_draw_white(seed, x, y, index, domain);
        v = bn_draw_white_pair_bits(seed, x, y, index, domain, pair);
        w = bn_draw_white_pair(seed, x, y, index, domain, pair);
    }
    results[at] = domain;
    for (uint d = 0u; d < 4u; ++d) {
        results[at + 1u + d] = bits[d];
        results[at + 5u + d] = asuint(draw[d]);
    }

    float probability = asfloat(cases[at + 6u]);
    float u = asfloat(cases[at + 7u]);
    float left = u;
    results[at + 9u] = bn_choose(probability, left) ? 1u : 0u;
    results[at + 10u] = asuint(left);
    left = u;
    results[at + 11u] = bn_choose_u32(cases[at + 8u], left);
    results[at + 12u] = asuint(left);
    left = u;
    results[at + 13u] = bn_choose_cdf(cases[at + 9u] & 255u, cases[at + 9u] >> 8u, left);
    results[at + 14u] = asuint(left);
    uint k = cases[at + 13u], branches = cases[at + 14u];
    bn_path path = bn_path_start(x, y, index, cases[at + 15u]);
    uint ray = bn_path_ray_domain(path, cases[at + 12u]);
    uint split = bn_ray_split_domain(ray, k);
    bn_path branch = bn_path_branch(path, split, branches, k);
    bn_path last = bn_path_branch(branch, split, branches, branches);
    uint path_words = 9u * path.x + 11u * path.y + 13u * path.index + 15u * path.domain + 17u * ray
        + 19u * bn_path_camera_domain(path) + 21u * bn_ray_1d_domain(ray, k) + 23u * bn_ray_1d_pair(k)
        + 25u * bn_ray_2d_domain(ray, k) + 27u * bn_ray_2d_pair(k) + 29u * bn_ray_4d_domain(ray, k) + 31u * split
        + 33u * branch.x + 35u * branch.y + 37u * branch.index + 39u * branch.domain + 41u * last.index
        + 43u * last.domain + 45u * bn_path_rng_bits(seed, branch, split, k)
        + 47u * bn_ray_keyed_domain(ray, k);
    results[at + 15u] = v.x + 3u * v.y + 5u * asuint(w.x) + 7u * asuint(w.y) + path_words;
}
