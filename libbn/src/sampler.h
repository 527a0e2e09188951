/* SPDX-License-Identifier: Apache-2.0
 * The sampler object, shared by the single draws and the block. */
#ifndef BN_SAMPLER_H
#define BN_SAMPLER_H

#include <bn/bn_draw.h>

struct bn_sampler {
    bn_draw_table table;
    uint32_t zorder_log2; /* kind ZORDER: log2 of the block every pixel owns */
    uint32_t *mask;       /* kind MASK: values as 32-bit fractions, [mask_height][mask_width] */
    uint32_t mask_width, mask_height;
};

#endif
