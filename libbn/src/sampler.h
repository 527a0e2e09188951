/* SPDX-License-Identifier: Apache-2.0
 * The sampler object, shared by its draws. */
#ifndef BN_SAMPLER_H
#define BN_SAMPLER_H

#include <bn/bn_draw.h>

struct bn_sampler {
    bn_draw_table table;
    uint32_t words[BN_WORD_COUNT]; /* table.words */
    uint32_t zorder_log2;          /* kind ZORDER: log2 of the block every pixel owns */
    /* Kind MASK, [mask_height][mask_width]: the digits that the scrambling of the first and of the
     * second dimension of a pair makes the values of the mask. One allocation. */
    uint32_t *mask_x, *mask_y;
    uint32_t mask_low_digits; /* those below the resolution of the mask */
    uint32_t mask_width, mask_height;
};

/* Fills table and words. */
void bn_blue_tables_fill(bn_sampler *sampler, int32_t kind, uint64_t seed_key);

void bn_draw_zorder(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t out[4]);

#endif
