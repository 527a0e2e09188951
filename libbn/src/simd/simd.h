/* SPDX-License-Identifier: Apache-2.0
 * The inner loops of the mask makers, compiled once per instruction set and chosen at run time. All
 * of them work in integers: every set gives the same bits. */
#ifndef BN_SIMD_H
#define BN_SIMD_H

#include "../energy_field.h"

enum { BN_WINDOW_LANES = 16 };

typedef struct bn_simd {
    const char *name;

    /* Sets (sign 1) or clears (sign -1) a texel and updates the extremes asked for. */
    void (*field_change)(bn_field *field, bn_field_texel texel, int sign, int extremes);
    /* The texel of the lowest or the highest energy; on ties the first in the order of the tiles.
     */
    bn_field_texel (*field_find)(const bn_field *field, int extreme);

    /* Two windows of rows x row_lanes values, row_lanes a multiple of BN_WINDOW_LANES, in images of
     * the same stride: the sum of weight * clamp(value, low, high) over the second window minus
     * that over the first. The true difference fits 32 bits. */
    int32_t (*window_difference)(const int16_t *first, const int16_t *second, size_t stride,
                                 const int16_t *weights, uint32_t rows, uint32_t row_lanes,
                                 int16_t low, int16_t high);
} bn_simd;

/* The best set this machine has. The environment variable BN_SIMD limits it to "scalar", "sse4.1",
 * "avx2", "avx512" or "neon"; tests use it. */
const bn_simd *bn_simd_get(void);

#endif
