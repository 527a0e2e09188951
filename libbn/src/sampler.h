/* SPDX-License-Identifier: Apache-2.0
 * The sampler object, shared by the single draws and the block. */
#ifndef BN_SAMPLER_H
#define BN_SAMPLER_H

#include "sampler_block.h"

struct bn_sampler {
    bn_draw_table table;
    bn_block_plan block;
    uint32_t zorder_log2; /* kind ZORDER: log2 of the block every pixel owns */
    /* Kind MASK, [mask_height][mask_width]: the digits that the scrambling of the first and of the
     * second dimension of a pair makes the values of the mask. One allocation. */
    uint32_t *mask_x, *mask_y;
    uint32_t mask_low_digits; /* those below the resolution of the mask */
    uint32_t mask_width, mask_height;
};

#endif
