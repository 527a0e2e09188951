/* SPDX-License-Identifier: Apache-2.0
 * The sampler types. To add one, add a file, its function below and a row in sampler.c. */
#ifndef BN_TYPES_H
#define BN_TYPES_H

#include "simd/simd.h"
#include <bn/bn_draw.h>

/* Draws the pairs whose bits are set in `pairs`. May also write the rest of `out`. */
typedef void (*bn_draw_bits)(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                             uint32_t domain, uint32_t pairs, uint32_t out[4]);

typedef struct bn_sampler_row {
    bn_draw_bits draw;   /* NULL for BLUE, which bn_draw.h draws inline */
    int in_lanes;        /* whether bn_simd draws it */
    int blocks_in_lanes; /* whether many indices of a pixel are drawn as lanes, too */
} bn_sampler_row;

extern const bn_sampler_row bn_sampler_types[];

void bn_draw_zorder(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pairs, uint32_t out[4]);
void bn_draw_mask(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  uint32_t pairs, uint32_t out[4]);

#endif
