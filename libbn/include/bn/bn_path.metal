/* SPDX-License-Identifier: Apache-2.0
 * The decisions of a path in the Metal Shading Language: the text of bn_path.glsl, which must lie beside
 * this file. Include it after bn_draw.metal. bn_path.h explains the decisions. Draws take the words of
 * bn_tables() first:
 *
 *     bn_path path = bn_path_start(pixel.x, pixel.y, index, 0);
 *     float4 u = bn_ray_draw(bn_words, seed, bn_path_ray(path, depth)); */
#ifndef BN_PATH_METAL
#define BN_PATH_METAL

#include "bn_path.glsl"

#endif
