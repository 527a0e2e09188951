/* SPDX-License-Identifier: Apache-2.0
 * bn_choose(), bn_choose_u32() and bn_choose_cdf() in HLSL. This file includes bn_choose.glsl, which must be
 * in the same folder. bn_choose.h documents them.
 *
 *     float4 u = bn_draw_blue_4d(seed, uint(pixel.x), uint(pixel.y), index, domain);
 *     uint light = bn_choose_u32(light_count, u.x);
 *
 * For bn_choose_cdf(first, count, u), first define how to read a table: #define BN_CDF(i) cdf[i] */
#ifndef BN_CHOOSE_HLSL
#define BN_CHOOSE_HLSL

#include "bn_choose.glsl"

#endif
