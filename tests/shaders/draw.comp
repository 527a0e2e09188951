#version 430
/* SPDX-License-Identifier: Apache-2.0
 * Computes the results of all cases from buffers. The tests replace each #include with the file's text. */
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
layout(std430, binding = 3) buffer result_table {
    uint results[];
};
#define BN_WORD(i) bn_words[i]
#include "bn_draw.glsl"
#include "bn_path.glsl"
#define BN_CDF(i) bn_cdf[i]
#include "bn_choose.glsl"

#define CASE(i) cases[16u * gl_GlobalInvocationID.x + (i)]
#include "answer.glsl"

void main() {
    uint at = 16u * gl_GlobalInvocationID.x;
    if (at >= uint(cases.length())) return;
    uint result[16];
    answer(result);
    for (uint i = 0u; i < 16u; ++i) results[at + i] = result[i];
}
