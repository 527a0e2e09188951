/* SPDX-License-Identifier: Apache-2.0
 * Shared by the vector types of all x86 sets: extremes of four integers. */
#include <immintrin.h>

static inline int32_t sse_lowest(__m128i a) {
    a = _mm_min_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_min_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
static inline int32_t sse_highest(__m128i a) {
    a = _mm_max_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_max_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
