/* SPDX-License-Identifier: Apache-2.0
 * BLUE, SOBOL and WHITE draws in the Metal Shading Language. This file includes bn_draw.glsl, which must be
 * in the same folder. BLUE draws take the words of bn_tables(), a `const device uint *`, as their first
 * argument. The seed comes from bn_sampler_seed():
 *
 *     #include <metal_stdlib>
 *     #include "bn_draw.metal"
 *
 *     float4 u = bn_draw_blue_4d(bn_words, seed, uint(pixel.x), uint(pixel.y), index, bn_domain_child(0, ray));
 *
 * If the words are in the constant address space, first define BN_WORDS as `constant uint *`. bn_draw.glsl
 * documents the functions and the tables. bn_draw_blue_bits() and its variants return all 32 bits of each
 * number as a uint4. */
#ifndef BN_DRAW_METAL
#define BN_DRAW_METAL

#ifndef BN_WORDS
#define BN_WORDS const device uint *
#endif
#define BN_UINT uint
#define BN_FLOAT2 float2
#define BN_FLOAT4 float4
#define bn_uint2 uint2
#define bn_uint4 uint4
#define BN_FUNCTION static inline
#define BN_TABLE BN_WORDS bn_words,
#define BN_PASS_TABLE bn_words,
#define BN_WORD(i) bn_words[i]
#define BN_REVERSE_BITS(v) metal::reverse_bits(v)
#define bn_draw_domain_child bn_domain_child
#include "bn_draw.glsl"

#endif
