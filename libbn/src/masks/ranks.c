/* SPDX-License-Identifier: Apache-2.0
 * Ranks of values and values of ranks.
 *
 * Floats are mapped to integers of the same order and sorted with their positions by a radix sort
 * from the least significant digit, in three passes of 11 bits. That takes linear time and is
 * stable, so equal values keep their order. 16 bytes of scratch memory per value. */
#include "base/memory.h"
#include <bn/bn.h>
#include <string.h>

enum { BN_RADIX_BITS = 11, BN_RADIX_PASSES = 3, BN_RADIX_SIZE = 1 << BN_RADIX_BITS };

/* An unsigned integer in the order of the floats. Both zeros have the same key. */
static uint32_t ordered_key(uint32_t bits) {
    if (bits == 0x80000000u) bits = 0;
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks) {
    if (values == NULL || ranks == NULL || count == 0) return BN_ERROR_INVALID_ARGUMENT;
    if (count > UINT32_MAX) return BN_ERROR_OUT_OF_MEMORY;
    uint64_t *buffer = bn_allocate(count, 2 * sizeof *buffer);
    size_t(*starts)[BN_RADIX_SIZE] = bn_allocate_zero(BN_RADIX_PASSES, sizeof *starts);
    bn_result result = BN_SUCCESS;
    if (buffer == NULL || starts == NULL) {
        result = BN_ERROR_OUT_OF_MEMORY;
        goto done;
    }
    uint64_t *from = buffer, *to = buffer + count;
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        if ((bits & 0x7fffffffu) > 0x7f800000u) {
            result = BN_ERROR_BAD_DATA;
            goto done;
        }
        uint32_t key = ordered_key(bits);
        from[i] = (uint64_t)key << 32 | (uint32_t)i;
        for (uint32_t pass = 0; pass < BN_RADIX_PASSES; ++pass) {
            ++starts[pass][key >> pass * BN_RADIX_BITS & (BN_RADIX_SIZE - 1)];
        }
    }
    for (uint32_t pass = 0; pass < BN_RADIX_PASSES; ++pass) {
        size_t sum = 0;
        for (uint32_t digit = 0; digit < BN_RADIX_SIZE; ++digit) {
            size_t next = sum + starts[pass][digit];
            starts[pass][digit] = sum;
            sum = next;
        }
        for (size_t i = 0; i < count; ++i) {
            uint32_t digit = from[i] >> (32 + pass * BN_RADIX_BITS) & (BN_RADIX_SIZE - 1);
            to[starts[pass][digit]++] = from[i];
        }
        uint64_t *swap = from;
        from = to;
        to = swap;
    }
    for (size_t i = 0; i < count; ++i) ranks[(uint32_t)from[i]] = (uint32_t)i;
done:
    bn_free(buffer);
    bn_free(starts);
    return result;
}

float bn_rank_to_float(uint32_t rank, size_t count) {
    if (count == 0) return 0;
    if (rank >= count) rank = (uint32_t)(count - 1);
    double value = (rank + 0.5) / (double)count;
    if (value > 1 - 0x1p-24) return 1 - 0x1p-24f;
    float rounded = (float)value;
    if ((double)rounded > value) {
        uint32_t bits;
        memcpy(&bits, &rounded, sizeof bits);
        --bits;
        memcpy(&rounded, &bits, sizeof rounded);
    }
    return rounded;
}
