/* SPDX-License-Identifier: Apache-2.0
 * A path's decisions in HLSL. Include this file after bn_draw.hlsl; it includes bn_path.glsl, which must be
 * in the same folder. bn_path.h explains the decisions.
 *
 *     bn_path path = bn_path_start(pixel.x, pixel.y, index, 0);
 *     float4 u = bn_ray_draw(seed, bn_path_ray(path, depth)); */
#ifndef BN_PATH_HLSL
#define BN_PATH_HLSL

#define BN_FLOAT_BITS(v) asuint(v)
#include "bn_path.glsl"

#endif
