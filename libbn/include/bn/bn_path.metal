/* SPDX-License-Identifier: Apache-2.0
 * A path's decisions in the Metal Shading Language. Include this file after bn_draw.metal; it includes
 * bn_path.glsl, which must be in the same folder. bn_path.h explains the decisions. The first argument of a
 * draw is the table returned by bn_tables():
 *
 *     bn_path path = bn_path_start(pixel.x, pixel.y, index, 0);
 *     float4 u = bn_ray_draw(bn_words, seed, bn_path_ray(path, depth)); */
#ifndef BN_PATH_METAL
#define BN_PATH_METAL

#define BN_FLOAT_BITS(v) as_type<uint>(v)
#include "bn_path.glsl"

#endif
