/* SPDX-License-Identifier: Apache-2.0
 * bn_draw.glsl and bn_path.glsl as a shader sees them, without their headers: the words of GLSL that
 * they use are defined for a C compiler, and the tables are the words of
 * bn_tables(). `uint` stays defined for more texts. */
#ifndef BN_DRAWS_IN_C_H
#define BN_DRAWS_IN_C_H

#include <bn/bn.h>

typedef struct bn_uint4 bn_uint4;
typedef struct bn_uint2 bn_uint2;
typedef struct bn_blue_pixel bn_blue_pixel;
typedef struct bn_path bn_path;

static const uint32_t *glsl_words;

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define BN_WORD(i) glsl_words[i]
#define BN_DRAW_IN_C /* without the functions that return vectors of floats */
#define uint uint32_t
/* Without the instructions that newer versions of GLSL have, so that their replacements are tested. */
#define BN_UINT uint
#define BN_FUNCTION static
#define BN_TABLE
#define BN_PASS_TABLE
#include <bn/bn_draw.glsl>
#include <bn/bn_path.glsl>

#endif
