#version 430
/* SPDX-License-Identifier: Apache-2.0
 * Draws and chooses what each record of `cases` asks for, as shader_cases.c describes them, with the
 * texts of bn_draw.glsl and bn_choose.glsl in place of their names. */
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer bn_table {
    uint bn_words[];
};
layout(std430, binding = 1) readonly buffer bn_cdf_table {
    float bn_cdf[];
};
layout(std430, binding = 2) readonly buffer case_table {
    uint cases[];
};
layout(std430, binding = 3) writeonly buffer result_table {
    uint results[];
};
#define BN_WORD(i) bn_words[i]
#include "bn_draw.glsl"
#define BN_CDF(i) bn_cdf[i]
#include "bn_choose.glsl"

void main() {
    uint at = 16u * gl_GlobalInvocationID.x;
    if (at >= uint(cases.length())) return;
    uint kind = cases[at], x = cases[at + 1u], y = cases[at + 2u], index = cases[at + 3u];
    uint domain = bn_domain_child(cases[at + 4u], cases[at + 5u]);
    bn_uint4 bits;
    vec4 draw;
    if (kind == 0u) {
        bits = bn_draw_blue_bits(x, y, index, domain);
        draw = bn_draw_blue(x, y, index, domain);
    } else if (kind == 1u) {
        bits = bn_draw_sobol_bits(x, y, index, domain);
        draw = bn_draw_sobol(x, y, index, domain);
    } else {
        bits = bn_draw_white_bits(x, y, index, domain);
        draw = bn_draw_white(x, y, index, domain);
    }
    results[at] = domain;
    results[at + 1u] = bits.x;
    results[at + 2u] = bits.y;
    results[at + 3u] = bits.z;
    results[at + 4u] = bits.w;
    for (int d = 0; d < 4; ++d) results[at + 5u + uint(d)] = floatBitsToUint(draw[d]);

    float probability = uintBitsToFloat(cases[at + 6u]);
    float u = uintBitsToFloat(cases[at + 7u]);
    float left = u;
    results[at + 9u] = bn_choose(probability, left) ? 1u : 0u;
    results[at + 10u] = floatBitsToUint(left);
    left = u;
    results[at + 11u] = bn_choose_u32(cases[at + 8u], left);
    results[at + 12u] = floatBitsToUint(left);
    left = u;
    results[at + 13u] = bn_choose_cdf(cases[at + 9u], cases[at + 10u], left);
    results[at + 14u] = floatBitsToUint(left);
    results[at + 15u] = 0u;
}
