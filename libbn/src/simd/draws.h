/* SPDX-License-Identifier: Apache-2.0
 * Draws BLUE, SOBOL and WHITE for many lanes at once, by compiling bn_draw.glsl with GCC's vector types in place of
 * numbers. Their operators let the code shared with shaders compile unchanged; only table lookups and bit reversal
 * have their own functions. */
#include "simd/simd.h"
#include "simd/vec_draws.h"
#include <bn/bn_device.h>
#include <string.h>

/* bn_draw.glsl defines these with vectors as members. */
typedef struct bn_uint4 bn_uint4;
typedef struct bn_uint2 bn_uint2;
typedef struct bn_blue_pixel bn_blue_pixel;

extern const uint32_t bn_tables_7[];

BN_INLINE uint32_t word_at(const uint32_t *words, uint32_t at) {
    return words[at];
}
BN_INLINE bn_uint4 row_at(const uint32_t *words, bn_u32v at);
BN_INLINE bn_uint2 half_row_at(const uint32_t *words, bn_u32v at);

/* Vectors in place of the scalars of bn_device.h. */
#undef BN_UINT
#undef BN_FUNCTION
#undef BN_WORD
#undef BN_ROW
#undef BN_HALF_ROW
#undef BN_ANY
#undef BN_REVERSE_BITS
#undef BN_KEY_FACTOR
#define BN_UINT bn_u32v
#define BN_FUNCTION BN_INLINE
#define BN_WORD(i) _Generic((i), uint32_t : word_at, bn_u32v : u32_gather)(bn_words, i)
#define BN_ROW(i) row_at(bn_words, i)
#define BN_HALF_ROW(i) half_row_at(bn_words, i)
#define BN_ANY(v) u32_any(v)
#define BN_REVERSE_BITS(v) u32_reverse_bits(v)
#include <bn/bn_draw.glsl>

BN_INLINE bn_uint4 row_at(const uint32_t *words, bn_u32v at) {
    bn_u32v v[4];
    u32_gather_rows(words, at, v);
    return (bn_uint4){v[0], v[1], v[2], v[3]};
}

BN_INLINE bn_uint2 half_row_at(const uint32_t *words, bn_u32v at) {
    bn_u32v v[2];
    u32_gather_half_rows(words, at, v);
    return (bn_uint2){v[0], v[1]};
}

/* The dimensions to draw: pair 0 or 1, dimension 0, or three or four dimensions. */
enum { ONE = 2, WIDE };

/* Draws a multiple of BN_U32_LANES lanes. `type` and `form` are constants, so the compiler removes
 * unused code. */
BN_INLINE void draw_loop(const bn_sampler *sampler, int32_t type, int form, uint32_t dimensions,
                         const bn_draw_lanes *lanes, float *out) {
    const uint32_t *words = bn_tables_7;
    const bn_u32v zero = {0};
    const bn_uint2 seed = {zero + sampler->seed[0], zero + sampler->seed[1]};
    for (size_t i = 0; i < lanes->count; i += BN_U32_LANES, out += BN_U32_LANES * dimensions) {
        const bn_u32v x = u32_load(lanes->x + i), y = u32_load(lanes->y + i);
        const bn_u32v index = u32_load(lanes->index + i), domain = u32_load(lanes->domain + i);
        if (form == WIDE) {
            const bn_uint4 v =
                type == BN_SAMPLER_BLUE    ? bn_draw_blue_bits(words, seed, x, y, index, domain)
                : type == BN_SAMPLER_SOBOL ? bn_draw_sobol_bits(seed, x, y, index, domain)
                                           : bn_draw_white_bits(seed, x, y, index, domain);
            bn_u32v all[4] = {v.x, v.y, v.z, v.w};
            u32_store_wide(all, dimensions, out);
        } else {
            const bn_u32v pair = zero + (form == ONE ? 0u : (uint32_t)form);
            const bn_uint2 v = type == BN_SAMPLER_BLUE
                                   ? bn_draw_blue_pair_bits(words, seed, x, y, index, domain, pair)
                               : type == BN_SAMPLER_SOBOL
                                   ? bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair)
                                   : bn_draw_white_pair_bits(seed, x, y, index, domain, pair);
            if (form == ONE) {
                u32_store_one(v.x, out);
            } else {
                u32_store_two(v.x, v.y, out);
            }
        }
    }
}

BN_INLINE void draw_type(const bn_sampler *sampler, int32_t type, uint32_t pair,
                         uint32_t dimensions, const bn_draw_lanes *lanes, float *out) {
    if (dimensions > 2) {
        draw_loop(sampler, type, WIDE, dimensions, lanes, out);
    } else if (dimensions == 1) {
        draw_loop(sampler, type, ONE, 1, lanes, out);
    } else if (pair == 0) {
        draw_loop(sampler, type, 0, 2, lanes, out);
    } else {
        draw_loop(sampler, type, 1, 2, lanes, out);
    }
}

static void draw_whole(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                       const bn_draw_lanes *lanes, float *out) {
    if (sampler->type == BN_SAMPLER_BLUE) {
        draw_type(sampler, BN_SAMPLER_BLUE, pair, dimensions, lanes, out);
    } else if (sampler->type == BN_SAMPLER_SOBOL) {
        draw_type(sampler, BN_SAMPLER_SOBOL, pair, dimensions, lanes, out);
    } else {
        draw_type(sampler, BN_SAMPLER_WHITE, pair, dimensions, lanes, out);
    }
}

/* The last lanes are copied into full vectors. */
static void draw_many(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                      const bn_draw_lanes *lanes, float *out) {
    const size_t left = lanes->count % BN_U32_LANES, at = lanes->count - left;
    bn_draw_lanes whole = *lanes;
    whole.count = at;
    draw_whole(sampler, pair, dimensions, &whole, out);
    if (left > 0) {
        int32_t x[BN_U32_LANES] = {0}, y[BN_U32_LANES] = {0};
        uint32_t index[BN_U32_LANES] = {0}, domain[BN_U32_LANES] = {0};
        float u[4 * BN_U32_LANES];
        const bn_draw_lanes last = {BN_U32_LANES, x, y, index, domain};
        memcpy(x, lanes->x + at, left * sizeof *x);
        memcpy(y, lanes->y + at, left * sizeof *y);
        memcpy(index, lanes->index + at, left * sizeof *index);
        memcpy(domain, lanes->domain + at, left * sizeof *domain);
        draw_whole(sampler, pair, dimensions, &last, u);
        memcpy(out + at * dimensions, u, left * dimensions * sizeof *u);
    }
}

#define BN_SIMD_DRAW_MANY draw_many
