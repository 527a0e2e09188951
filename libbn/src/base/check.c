/* SPDX-License-Identifier: Apache-2.0
 * Argument checks. Products of extents are compared with their limit by division, before they are formed, so
 * no product can wrap. Floats are classified by their bits. A mask is checked in one pass over its texels,
 * with one bit per rank. */
#include "base/check.h"
#include "base/assert.h"
#include "base/memory.h"
#include <string.h>

int bn_product(const uint32_t factors[4], uint64_t limit, uint64_t *product) {
    uint64_t total = 1;
    for (int i = 0; i < 4; ++i) {
        if (factors[i] != 0 && total > limit / factors[i]) return 0;
        total *= factors[i];
    }
    *product = total;
    return 1;
}

bn_result bn_check_extents(uint32_t width, uint32_t height, uint32_t depth, uint32_t channels,
                           size_t count) {
    const uint32_t extents[4] = {width, height, depth, 1};
    uint64_t texels;
    if (width == 0 || height == 0 || depth == 0 || channels == 0) return BN_ERROR_INVALID_ARGUMENT;
    if (!bn_product(extents, BN_MOST_TEXELS, &texels)) return BN_ERROR_OUT_OF_MEMORY;
    /* Below 2^63, so the product cannot wrap. */
    return count == texels * channels ? BN_SUCCESS : BN_ERROR_SIZE_MISMATCH;
}

uint32_t bn_mask_rank(const bn_mask *mask, size_t at) {
    BN_ASSERT(mask->rank_bits == 16 || mask->rank_bits == 32);
    if (mask->rank_bits == 16) return ((const uint16_t *)mask->ranks)[at];
    return ((const uint32_t *)mask->ranks)[at];
}

static bn_result check_permutation(const bn_mask *mask, size_t count) {
    uint64_t *seen = bn_allocate_zero(count / 64 + 1, sizeof *seen);
    if (seen == NULL) return BN_ERROR_OUT_OF_MEMORY;
    int good = 1;
    for (size_t i = 0; i < count && good; ++i) {
        const uint32_t rank = bn_mask_rank(mask, i);
        good = rank < count && !(seen[rank / 64] >> rank % 64 & 1);
        if (good) seen[rank / 64] |= (uint64_t)1 << rank % 64;
    }
    bn_free(seen);
    return good ? BN_SUCCESS : BN_ERROR_BAD_DATA;
}

bn_result bn_check_mask(const bn_mask *mask) {
    if (mask == NULL || mask->ranks == NULL || mask->depth != 1 || mask->channels != 1 ||
        (mask->rank_bits != 16 && mask->rank_bits != 32)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    const size_t count = (size_t)mask->width * mask->height;
    const bn_result result = bn_check_extents(mask->width, mask->height, 1, 1, count);
    return result == BN_SUCCESS ? check_permutation(mask, count) : result;
}

bn_result bn_check_new_mask(const bn_mask *mask, size_t *count) {
    if (mask == NULL || mask->ranks == NULL || (mask->rank_bits != 16 && mask->rank_bits != 32) ||
        mask->width == 0 || mask->height == 0 || mask->depth == 0 || mask->channels == 0) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    const uint32_t extents[4] = {mask->width, mask->height, mask->depth, 1};
    uint64_t texels;
    if (!bn_product(extents, BN_MOST_TEXELS, &texels) ||
        texels > SIZE_MAX / sizeof(uint32_t) / mask->channels) {
        return BN_ERROR_OUT_OF_MEMORY;
    }
    if (mask->rank_bits == 16 && texels > 1u << 16) return BN_ERROR_INVALID_ARGUMENT;
    *count = (size_t)texels * mask->channels;
    return BN_SUCCESS;
}

void bn_mask_write(const bn_mask *mask, const uint32_t *ranks, size_t count) {
    void *to = (void *)mask->ranks;
    for (size_t i = 0; i < count; ++i) {
        if (mask->rank_bits == 16) {
            BN_ASSERT(ranks[i] <= UINT16_MAX);
            ((uint16_t *)to)[i] = (uint16_t)ranks[i];
        } else {
            ((uint32_t *)to)[i] = ranks[i];
        }
    }
}

bn_mask bn_mask_channel(const bn_mask *mask, uint32_t channel) {
    BN_ASSERT(channel < mask->channels);
    const size_t bytes = (size_t)mask->width * mask->height * mask->depth * (mask->rank_bits / 8);
    bn_mask one = *mask;
    one.ranks = (const unsigned char *)mask->ranks + channel * bytes;
    one.channels = 1;
    return one;
}

int bn_in_range(double value, double low, double high) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    if ((bits & 0x7ff0000000000000u) == 0x7ff0000000000000u) return 0;
    return value >= low && value <= high;
}

int32_t bn_largest_bits(const float *values, size_t count) {
    int32_t largest = 0;
    for (size_t i = 0; i < count; ++i) { /* without a branch, so that compilers vectorise it */
        int32_t bits;
        memcpy(&bits, values + i, sizeof bits);
        bits &= INT32_MAX;
        largest = bits > largest ? bits : largest;
    }
    return largest;
}
