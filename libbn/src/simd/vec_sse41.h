/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h for SSE4.1, in pairs of registers; vec.h says what each function
 * does. */
#include "simd/vec_x86.h"

#define BN_SIMD_NAME "sse4.1"
#define BN_SIMD_TABLE bn_simd_sse41
typedef __m128i bn_i32x4, bn_i16x8;
#define i32x4_set _mm_set1_epi32
#define i32x4_load(p) _mm_load_si128((const __m128i *)(const void *)(p))
#define i32x4_load_any(p) _mm_loadu_si128((const __m128i *)(const void *)(p))
#define i32x4_store(p, x) _mm_store_si128((__m128i *)(void *)(p), x)
#define i16x8_set _mm_set1_epi16
#define i16x8_load i32x4_load_any
#define i16x8_store(p, x) _mm_storeu_si128((__m128i *)(void *)(p), x)
#define i16x8_min _mm_min_epi16
#define i16x8_max _mm_max_epi16
#include "simd/vec_pairs.h"

BN_BINARY(i32_add, bn_i32v, _mm_add_epi32)
BN_BINARY(i32_subtract, bn_i32v, _mm_sub_epi32)
BN_BINARY(i32_and, bn_i32v, _mm_and_si128)
BN_BINARY(i32_or, bn_i32v, _mm_or_si128)
BN_BINARY(i32_min, bn_i32v, _mm_min_epi32)
BN_BINARY(i32_max, bn_i32v, _mm_max_epi32)
static inline int32_t i32_lowest(bn_i32v x) {
    return sse_lowest(_mm_min_epi32(x.a, x.b));
}
static inline int32_t i32_highest(bn_i32v x) {
    return sse_highest(_mm_max_epi32(x.a, x.b));
}
static inline uint32_t i32_equal_bits(bn_i32v x, bn_i32v y) {
    uint32_t low = (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(x.a, y.a)));
    uint32_t high = (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(x.b, y.b)));
    return low | high << 4;
}

BN_BINARY(x8_subtract, bn_i32x8, _mm_sub_epi32)
static inline int32_t x8_sum(bn_i32x8 x) {
    __m128i s = _mm_add_epi32(x.a, x.b);
    s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(s, _mm_shuffle_epi32(s, 0xb1)));
}
BN_BINARY(i16_add, bn_i16x16, _mm_add_epi16)
BN_BINARY(i16_subtract_saturated, bn_i16x16, _mm_subs_epi16)
BN_BINARY(i16_multiply_upper, bn_i16x16, _mm_mulhrs_epi16)
static inline bn_i16x16 i16_shift_left(bn_i16x16 x, int32_t shift) {
    const __m128i by = _mm_cvtsi32_si128(shift);
    bn_i16x16 r = {_mm_sll_epi16(x.a, by), _mm_sll_epi16(x.b, by)};
    return r;
}
static inline bn_i32x8 i16_multiply_add(bn_i32x8 sum, bn_i16x16 x, bn_i16x16 y) {
    bn_i32x8 r = {_mm_add_epi32(sum.a, _mm_madd_epi16(x.a, y.a)),
                  _mm_add_epi32(sum.b, _mm_madd_epi16(x.b, y.b))};
    return r;
}
