#version 430
/* SPDX-License-Identifier: Apache-2.0
 * A compute shader that draws and chooses, as bn_draw.glsl and bn_choose.glsl say: what the validator
 * is given, with their texts in place of their names. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 0) readonly buffer bn_table {
    uint bn_words[];
};
layout(std430, binding = 1) writeonly buffer bn_samples {
    vec4 samples[];
};
#define BN_WORD(i) bn_words[i]
#include "bn_draw.glsl"
layout(std430, binding = 2) readonly buffer bn_cdf_table {
    float bn_cdf[];
};
#define BN_CDF(i) bn_cdf[i]
#include "bn_choose.glsl"

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    uint at = (pixel.y * 512u + pixel.x) * 3u;
    uint domain = bn_domain_child(0u, gl_GlobalInvocationID.z);
    samples[at] = bn_draw_blue(pixel.x, pixel.y, 5u, domain);
    samples[at + 1u] = bn_draw_sobol(pixel.x, pixel.y, 5u, domain);
    vec4 u = bn_draw_white(pixel.x, pixel.y, 5u, domain);
    uint chosen = bn_choose_u32(7u, u.x) + bn_choose_cdf(3u, 5u, u.y);
    samples[at + 2u] = bn_choose(0.3, u.z) ? u : vec4(float(chosen));
}
