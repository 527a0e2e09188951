#version 300 es
/* SPDX-License-Identifier: Apache-2.0
 * Computes the results of all cases from textures, as in WebGL 2. The tests replace each #include with the file's text.
 * Each pixel of the image is one word of a result, and a row contains the results of many cases. */
precision highp float;
precision highp int;
uniform highp usampler2D bn_words;
uniform highp usampler2D cases;
uniform highp sampler2D bn_cdf;
out highp uint word;
#define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
#include "bn_draw.glsl"
#include "bn_path.glsl"
#define BN_CDF(i) texelFetch(bn_cdf, ivec2(i, 0u), 0).r
#include "bn_choose.glsl"

uvec2 pixel;
#define CASE(i) texelFetch(cases, ivec2((pixel.x & ~15u) + (i), pixel.y), 0).r
#include "answer.glsl"

void main() {
    pixel = uvec2(ivec2(gl_FragCoord.xy));
    uint result[16];
    answer(result);
    word = result[pixel.x & 15u];
}
