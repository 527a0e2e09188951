/* SPDX-License-Identifier: Apache-2.0
 * draw.comp in HLSL. */
[[vk::binding(0)]] StructuredBuffer<uint> bn_words : register(t0);
[[vk::binding(1)]] StructuredBuffer<float> bn_cdf : register(t1);
[[vk::binding(2)]] StructuredBuffer<uint> cases : register(t2);
[[vk::binding(3)]] RWStructuredBuffer<uint> results : register(u0);
#define BN_WORD(i) bn_words[i]
#include "bn_draw.hlsl"
#include "bn_path.hlsl"
#define BN_CDF(i) bn_cdf[i]
#include "bn_choose.hlsl"

#define vec2 float2
#define vec4 float4
#define floatBitsToUint asuint
#define uintBitsToFloat asfloat
static uint at;
#define CASE(i) cases[at + (i)]
#include "answer.glsl"

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint count, stride, result[16];
    at = 16u * id.x;
    cases.GetDimensions(count, stride);
    if (at >= count) return;
    answer(result);
    for (uint i = 0u; i < 16u; ++i) results[at + i] = result[i];
}
