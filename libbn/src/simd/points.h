/* SPDX-License-Identifier: Apache-2.0
 * The pairs of bn_eliminate(), eight at a time, for AVX2 and AVX-512. A range has five or six points on
 * average, so that most take one turn of the loop. Weights are read one by one: gathers are slow on
 * some processors. */
#include "simd/simd.h"
#include <immintrin.h>

BN_INLINE int weight_at(const uint32_t *weights, int at) {
    return (int)weights[at];
}

static uint32_t eliminate_visit(const bn_eliminate_points *p, const bn_eliminate_range *ranges,
                                uint32_t count, uint32_t x, uint32_t y, int sign) {
    const uint32_t *weights = p->weight;
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i limit = _mm256_set1_epi32((int)p->limit), low = _mm256_set1_epi32(0xffff);
    const __m256i negate = _mm256_set1_epi32(sign < 0 ? -1 : 0);
    __m256i sums = _mm256_setzero_si256();
    for (uint32_t i = 0; i < count; ++i) {
        const __m256i here_x = _mm256_set1_epi32((int)(x + ranges[i].x));
        const __m256i here_y = _mm256_set1_epi32((int)(y + ranges[i].y));
        for (uint32_t at = ranges[i].first; at < ranges[i].last; at += BN_ELIMINATE_LANES) {
            const __m256i left = _mm256_set1_epi32((int)(ranges[i].last - at));
            const __m256i valid = _mm256_cmpgt_epi32(left, lanes);
            const __m256i dx = _mm256_sub_epi32(
                here_x, _mm256_loadu_si256((const __m256i *)(const void *)(p->x + at)));
            const __m256i dy = _mm256_sub_epi32(
                here_y, _mm256_loadu_si256((const __m256i *)(const void *)(p->y + at)));
            /* Both differences fit 16 bits, side by side, for the sum of their squares. */
            const __m256i d = _mm256_or_si256(_mm256_and_si256(dx, low), _mm256_slli_epi32(dy, 16));
            const __m256i square = _mm256_min_epu32(_mm256_madd_epi16(d, d), limit);
            const __m256i entry = _mm256_blendv_epi8(limit, square, valid);
            const __m128i e0 = _mm256_castsi256_si128(entry);
            const __m128i e1 = _mm256_extracti128_si256(entry, 1);
            const __m256i weight = _mm256_setr_epi32(weight_at(weights, _mm_extract_epi32(e0, 0)),
                                                     weight_at(weights, _mm_extract_epi32(e0, 1)),
                                                     weight_at(weights, _mm_extract_epi32(e0, 2)),
                                                     weight_at(weights, _mm_extract_epi32(e0, 3)),
                                                     weight_at(weights, _mm_extract_epi32(e1, 0)),
                                                     weight_at(weights, _mm_extract_epi32(e1, 1)),
                                                     weight_at(weights, _mm_extract_epi32(e1, 2)),
                                                     weight_at(weights, _mm_extract_epi32(e1, 3)));
            __m256i *energy = (__m256i *)(void *)(p->energy + at);
            const __m256i change = _mm256_sub_epi32(_mm256_xor_si256(weight, negate), negate);
            _mm256_storeu_si256(energy, _mm256_add_epi32(_mm256_loadu_si256(energy), change));
            sums = _mm256_add_epi32(sums, weight);
        }
    }
    __m128i sum = _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0x4e));
    sum = _mm_add_epi32(sum, _mm_shuffle_epi32(sum, 0xb1));
    return (uint32_t)_mm_cvtsi128_si32(sum);
}

#define BN_SIMD_ELIMINATE_VISIT eliminate_visit
