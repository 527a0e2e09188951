/* SPDX-License-Identifier: Apache-2.0
 * Which domain each decision of a path draws from, in HLSL: the text of bn_path.glsl, which must lie
 * beside this file. Include it after bn_draw.hlsl. bn_path.h explains the layout.
 *
 *     bn_path path = bn_path_start(uint(pixel.x), uint(pixel.y), index, 0);
 *     float4 u = bn_draw_blue_4d(seed, path.x, path.y, path.index, bn_path_ray_domain(path, depth)); */
#ifndef BN_PATH_HLSL
#define BN_PATH_HLSL

#include "bn_path.glsl"

#endif
