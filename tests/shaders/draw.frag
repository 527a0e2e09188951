#version 300 es
/* SPDX-License-Identifier: Apache-2.0
 * Draws in a fragment shader with the words in a texture, as in WebGL 2, for the validator: with the texts
 * of bn_draw.glsl and bn_choose.glsl in place of their names. */
precision highp float;
uniform highp usampler2D bn_words;
uniform uint index;
out vec4 colour;
#define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
#include "bn_draw.glsl"
#include "bn_choose.glsl"

void main() {
    uvec2 pixel = uvec2(ivec2(gl_FragCoord.xy));
    uint domain = bn_domain_child(0u, 1u);
    colour = bn_draw_blue(pixel.x, pixel.y, index, domain) + bn_draw_sobol(pixel.x, pixel.y, index, domain);
    vec4 u = bn_draw_white(pixel.x, pixel.y, index, domain);
    if (bn_choose(0.3, u.x) && bn_choose_u32(7u, u.y) > 2u) colour = u;
}
