/* SPDX-License-Identifier: Apache-2.0
 * Converts values to ranks, and ranks to values.
 *
 * Floats are mapped to integer keys with the same order. A radix sort then sorts keys and positions
 * together in three passes, least significant digit first. It is stable, so equal values keep their
 * order. Takes linear time and 16 bytes of scratch memory per value. */
#include "base/assert.h"
#include "base/memory.h"
#include <bn/bn.h>
#include <string.h>

/* Three digits cover a key, and the counts of one digit fit in the first-level cache. */
enum { BN_DIGIT_BITS = 11, BN_DIGITS = 3, BN_DIGIT_VALUES = 1 << BN_DIGIT_BITS };
_Static_assert(BN_DIGIT_BITS *BN_DIGITS >= 32, "the digits must cover a key");

/* An unsigned integer that sorts in the same order as the floats. Both zeros have the key 2^31.
 * Reads only bits, so that the host's floating-point environment has no effect. */
static inline uint32_t key_at(const float *values, size_t i) {
    uint32_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    const uint32_t sign = 0u - (bits >> 31);
    return ((bits ^ (sign & 0x7fffffffu)) - sign) ^ 0x80000000u;
}

static inline uint32_t digit(uint32_t key, uint32_t place) {
    return key >> (place * BN_DIGIT_BITS) & (BN_DIGIT_VALUES - 1);
}

bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks) {
    /* The keys of the infinities. NaNs have keys outside this range. */
    const uint32_t least = 0x80000000u - 0x7f800000u, most = 0x80000000u + 0x7f800000u;
    if (values == NULL || ranks == NULL || count == 0) return BN_ERROR_INVALID_ARGUMENT;
    if (count > UINT32_MAX) return BN_ERROR_OUT_OF_MEMORY;
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    uint64_t *pairs = bn_allocate(count, sizeof *pairs),
             *others = bn_allocate(count, sizeof *others);
    uint32_t(*starts)[BN_DIGIT_VALUES] = bn_allocate_zero(BN_DIGITS, sizeof *starts);
    if (pairs == NULL || others == NULL || starts == NULL) goto done;
    uint32_t bad = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t key = key_at(values, i);
        bad |= key < least || key > most;
        for (uint32_t d = 0; d < BN_DIGITS; ++d) ++starts[d][digit(key, d)];
    }
    result = bad ? BN_ERROR_BAD_DATA : BN_SUCCESS;
    if (bad) goto done;
    for (uint32_t d = 0; d < BN_DIGITS; ++d) {
        uint32_t sum = 0;
        for (uint32_t v = 0; v < BN_DIGIT_VALUES; ++v) {
            const uint32_t here = starts[d][v];
            starts[d][v] = sum;
            sum += here;
        }
        BN_ASSERT(sum == count);
    }
    /* A pair is a key, in the upper half, and its position. The last pass only assigns ranks. */
    for (size_t i = 0; i < count; ++i) {
        const uint32_t key = key_at(values, i);
        pairs[starts[0][digit(key, 0)]++] = (uint64_t)key << 32 | i;
    }
    for (size_t i = 0; i < count; ++i) {
        others[starts[1][digit((uint32_t)(pairs[i] >> 32), 1)]++] = pairs[i];
    }
    for (size_t i = 0; i < count; ++i) {
        ranks[(uint32_t)others[i]] = starts[2][digit((uint32_t)(others[i] >> 32), 2)]++;
    }
done:
    bn_free(pairs);
    bn_free(others);
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
