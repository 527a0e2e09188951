/* SPDX-License-Identifier: Apache-2.0
 * bn_choose(), bn_choose_u32() and bn_choose_cdf() in the Metal Shading Language. This file includes
 * bn_choose.glsl, which must be in the same folder. bn_choose.h documents the functions; here u is a
 * reference, and bn_choose_cdf(cdf, count, u) takes a pointer to device memory.
 *
 *     float4 draw = bn_draw_blue_4d(bn_words, seed, uint(pixel.x), uint(pixel.y), index, domain);
 *     float u = draw.x;
 *     uint light = bn_choose_u32(light_count, u); */
#ifndef BN_CHOOSE_METAL
#define BN_CHOOSE_METAL

#define BN_UINT uint
#define BN_FUNCTION static inline
#define BN_BOOL bool
#define BN_FALSE false
#define BN_CHOOSE_U thread float &u
#define BN_CHOOSE_GET_U u
#define BN_TO_UINT(v) uint(v)
#define BN_TO_FLOAT(v) float(v)
#define BN_CHOOSE_TABLE const device float *cdf,
#define BN_CHOOSE_LIMIT(i) cdf[i]
#define BN_MULTIPLY_HIGH(a, b) metal::mulhi(a, b)
#include "bn_choose.glsl"

#endif
