/* SPDX-License-Identifier: Apache-2.0
 * The built-in masks. libbn/data/README.md describes how they were made and their quality. */
#include <bn/bn.h>

extern const uint16_t bn_data_mask_16[], bn_data_mask_32[], bn_data_mask_64[], bn_data_mask_128[];
#ifndef BN_SMALL_DATA
extern const uint16_t bn_data_mask_256[];
#endif

/* Of 16, 32, 64 ... texels along each axis. */
static const uint16_t *const masks_by_size[] = {
    bn_data_mask_16,  bn_data_mask_32, bn_data_mask_64, bn_data_mask_128,
#ifndef BN_SMALL_DATA
    bn_data_mask_256,
#endif
};

bn_mask bn_builtin_mask(uint32_t size) {
    const uint16_t *ranks = NULL;
    for (uint32_t i = 0; i < sizeof masks_by_size / sizeof *masks_by_size; ++i) {
        if (size == 16u << i) ranks = masks_by_size[i];
    }
    return bn_mask_u16(ranks, size, size);
}
