/* SPDX-License-Identifier: Apache-2.0
 * The inner loops of the mask generators and of bn_sample_wavefront(), compiled once per instruction set
 * and chosen at run time. They work on integers, so results are bit-identical for every set. */
#ifndef BN_SIMD_H
#define BN_SIMD_H

#include "simd/field.h"
#include <bn/bn.h>

#if defined(__GNUC__)
#define BN_INLINE static inline __attribute__((always_inline))
#else
#define BN_INLINE static inline
#endif

enum { BN_WINDOW_LANES = 16 };

/* The arguments of `count` draws. */
typedef struct bn_draw_lanes {
    size_t count;
    const int32_t *x, *y;
    const uint32_t *index, *domain;
} bn_draw_lanes;

typedef struct bn_simd {
    /* Sets (sign 1) or clears (sign -1) a texel and updates the requested extremes. */
    void (*field_change)(bn_field *field, bn_field_texel texel, int sign, int extremes);
    /* The texel with the lowest or highest energy; if there are several, the first in tile order. */
    bn_field_texel (*field_find)(const bn_field *field, int extreme);

    /* For two windows of rows x row_lanes values in images with the same stride: the sum of
     * weight * clamp(value, low, high) over the second window minus that over the first. row_lanes
     * is a multiple of BN_WINDOW_LANES. The true difference fits in 32 bits. */
    int32_t (*window_difference)(const int16_t *first, const int16_t *second, size_t stride,
                                 const int16_t *weights, uint32_t rows, uint32_t row_lanes,
                                 int16_t low, int16_t high);

    /* The gradient of `columns` texels in a row: sums over the pairs of weight * clamp(centre -
     * other, -limit, limit) * 2^shift, each product rounded to its upper half as (a b + 2^14) /
     * 2^15. Each weight is repeated BN_WINDOW_LANES times; the weights add up to less than 2^15.
     * Reads and writes up to the next multiple of BN_WINDOW_LANES. */
    void (*relax_row)(const int16_t *centre, const ptrdiff_t *offsets, const int16_t *weights,
                      uint32_t pairs, uint32_t columns, int16_t limit, int32_t shift,
                      int16_t *gradient);

    /* Draws BLUE, SOBOL and WHITE samples into out[count][dimensions]. For two dimensions, `pair` is
     * that of bn_sample_2d(). NULL where nothing is faster than single draws. */
    void (*draw_many)(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                      const bn_draw_lanes *lanes, float *out);
} bn_simd;

/* This machine's best instruction set. For tests, the environment variable BN_SIMD=scalar chooses
 * plain C. */
const bn_simd *bn_simd_get(void);

#endif
