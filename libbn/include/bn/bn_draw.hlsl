/* SPDX-License-Identifier: Apache-2.0
 * BLUE, SOBOL and WHITE draws in HLSL (shader model 5.0 and later). This file includes bn_draw.glsl, which
 * must be in the same folder. Define BN_WORD(i) to read word i of bn_tables(), then include this file. The
 * seed comes from bn_sampler_seed():
 *
 *     StructuredBuffer<uint> bn_words : register(t0);
 *     #define BN_WORD(i) bn_words[i]
 *
 *     float4 u = bn_draw_blue_4d(seed, uint(pixel.x), uint(pixel.y), index, bn_domain_child(0, ray));
 *
 * For a ByteAddressBuffer, define BN_WORD(i) as bn_words.Load(4 * (i)). bn_draw.glsl documents the functions
 * and the tables. bn_draw_blue_bits() and its variants return all 32 bits of each number as a uint4. */
#ifndef BN_DRAW_HLSL
#define BN_DRAW_HLSL

#define BN_UINT uint
#define BN_FLOAT2 float2
#define BN_FLOAT4 float4
#define bn_uint2 uint2
#define bn_uint4 uint4
#define BN_FUNCTION
#define BN_TABLE
#define BN_PASS_TABLE
#define BN_REVERSE_BITS(v) reversebits(v)
#define bn_draw_domain_child bn_domain_child
#include "bn_draw.glsl"

#endif
