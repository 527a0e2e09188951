/* SPDX-License-Identifier: Apache-2.0
 * Which domain each decision of a path draws from, in the Metal Shading Language: the text of
 * bn_path.glsl, which must lie beside this file. Include it after bn_draw.metal. bn_path.h explains
 * the layout.
 *
 *     bn_path path = bn_path_start(uint(pixel.x), uint(pixel.y), index, 0);
 *     uint ray = bn_path_ray_domain(path, depth);
 *     float4 u = bn_draw_blue_4d(bn_words, seed, path.x, path.y, path.index, ray); */
#ifndef BN_PATH_METAL
#define BN_PATH_METAL

#include "bn_path.glsl"

#endif
