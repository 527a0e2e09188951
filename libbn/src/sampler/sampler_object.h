/* SPDX-License-Identifier: Apache-2.0
 * The contents of a sampler. */
#ifndef BN_SAMPLER_OBJECT_H
#define BN_SAMPLER_OBJECT_H

#include "simd/simd.h"
#include <bn/bn_draw.h>

struct bn_sampler {
    bn_draw_table table;
    uint32_t words[BN_WORD_COUNT]; /* table.words */
    const bn_simd *simd;           /* chosen when the sampler is created */
    uint32_t zorder_log2;          /* kind ZORDER: log2 of the block every pixel owns */
    uint32_t *mask_ranks;          /* kind MASK: [mask_height][mask_width] */
    uint64_t mask_scale;           /* 2^63 over the number of ranks, rounded up */
    uint32_t mask_low_digits;      /* a bit mask: the digits finer than the ranks */
    uint32_t mask_width, mask_height;
};

#endif
