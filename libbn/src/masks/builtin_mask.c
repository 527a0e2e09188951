/* SPDX-License-Identifier: Apache-2.0
 * The built-in masks. libbn/data/README.md says how they were made and how good they are. */
#include <bn/bn.h>

extern const uint16_t bn_data_mask_16[], bn_data_mask_32[], bn_data_mask_64[], bn_data_mask_128[];
#ifndef BN_SMALL_DATA
extern const uint16_t bn_data_mask_256[];
#endif

const uint16_t *bn_builtin_mask(uint32_t size) {
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

bn_result bn_builtin_mask_copy(uint32_t size, uint32_t *ranks, size_t count) {
    const uint16_t *mask = bn_builtin_mask(size);
    if (ranks == NULL || mask == NULL) return BN_ERROR_INVALID_ARGUMENT;
    if (count != (size_t)size * size) return BN_ERROR_SIZE_MISMATCH;
    for (size_t i = 0; i < count; ++i) ranks[i] = mask[i];
    return BN_SUCCESS;
}
