/* SPDX-License-Identifier: Apache-2.0
 * The built-in masks. libbn/data/README.md describes how they were made and their quality. */
#include <bn/bn.h>

extern const uint16_t bn_data_mask_16[], bn_data_mask_32[], bn_data_mask_64[], bn_data_mask_128[];
#ifndef BN_SMALL_DATA
extern const uint16_t bn_data_mask_256[];
#endif

static const uint16_t *ranks_of(uint32_t size) {
    switch (size) {
    case 16:
        return bn_data_mask_16;
    case 32:
        return bn_data_mask_32;
    case 64:
        return bn_data_mask_64;
    case 128:
        return bn_data_mask_128;
#ifndef BN_SMALL_DATA
    case 256:
        return bn_data_mask_256;
#endif
    default:
        return NULL;
    }
}

bn_mask bn_builtin_mask(uint32_t size) {
    return bn_mask_u16(ranks_of(size), size, size);
}
