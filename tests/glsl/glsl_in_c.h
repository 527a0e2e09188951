/* SPDX-License-Identifier: Apache-2.0
 * The words of GLSL that bn_draw.glsl uses, for a C compiler: its text is in the common subset of
 * both languages but for these, and for the names it shares with bn_draw.h. */
#ifndef BN_GLSL_IN_C_H
#define BN_GLSL_IN_C_H

#include <bn/bn_draw.h>

/* Names with their own suffix, so that both forms can be called. */
#define bn_hash32 bn_hash32_glsl
#define bn_domain_child bn_domain_child_glsl
#define bn_owen_reversed bn_owen_reversed_glsl
#define bn_owen bn_owen_glsl
#define bn_sobol_second bn_sobol_second_glsl
#define bn_blue_pixel bn_blue_pixel_glsl
#define bn_draw_blue_pixel bn_draw_blue_pixel_glsl
#define bn_draw_flip bn_draw_flip_glsl
#define bn_draw_times_x bn_draw_times_x_glsl
#define bn_draw_times_x_plus_1 bn_draw_times_x_plus_1_glsl
#define bn_draw_second_pair bn_draw_second_pair_glsl
#define bn_draw_member bn_draw_member_glsl
#define bn_draw_blue_digits bn_draw_blue_digits_glsl
#define bn_draw_continue bn_draw_continue_glsl
#define bn_draw_blue_reflect bn_draw_blue_reflect_glsl
#define bn_draw_blue bn_draw_blue_glsl
#define bn_draw_sobol bn_draw_sobol_glsl
#define bn_draw_white bn_draw_white_glsl

typedef uint32_t bn_glsl_uint;
typedef struct uvec2 {
    bn_glsl_uint x, y;
} uvec2;
typedef struct uvec4 {
    bn_glsl_uint x, y, z, w;
} uvec4;
typedef struct vec4 {
    float x, y, z, w;
} vec4;
typedef struct bn_blue_pixel_glsl bn_blue_pixel_glsl;

/* A type's name with parentheses makes a value of it. */
#define uint bn_glsl_uint
#define float(a) ((float)(a))
#define uvec2(a, b) ((uvec2){a, b})
#define uvec4(a, b, c, d) ((uvec4){a, b, c, d})
#define vec4(a, b, c, d) ((vec4){a, b, c, d})

#define bitfieldReverse bn_reverse_bits
#define umulExtended(a, b, high, low)                                                              \
    do {                                                                                           \
        uint64_t product = (uint64_t)(a) * (b);                                                    \
        (high) = (uint32_t)(product >> 32);                                                        \
        (low) = (uint32_t)product;                                                                 \
    } while (0)

#endif
