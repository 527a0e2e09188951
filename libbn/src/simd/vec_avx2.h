/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h for AVX2; vec.h describes the functions. */
#include <immintrin.h>

/* Defines a function of two vectors from one instruction. */
#define BN_BINARY(name, type, operation)                                                           \
    static inline type name(type a, type b) {                                                      \
        return operation(a, b);                                                                    \
    }

#define BN_SIMD_TABLE bn_simd_avx2
typedef __m256i bn_i32v;
static inline bn_i32v i32_set(int32_t a) {
    return _mm256_set1_epi32(a);
}
static inline bn_i32v i32_load(const int32_t *p) {
    return _mm256_load_si256((const __m256i *)(const void *)p);
}
static inline bn_i32v i32_load_any(const int32_t *p) {
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
static inline void i32_store(int32_t *p, bn_i32v a) {
    _mm256_store_si256((__m256i *)(void *)p, a);
}
BN_BINARY(i32_add, bn_i32v, _mm256_add_epi32)
BN_BINARY(i32_subtract, bn_i32v, _mm256_sub_epi32)
BN_BINARY(i32_and, bn_i32v, _mm256_and_si256)
BN_BINARY(i32_or, bn_i32v, _mm256_or_si256)
BN_BINARY(i32_min, bn_i32v, _mm256_min_epi32)
BN_BINARY(i32_max, bn_i32v, _mm256_max_epi32)
static inline int32_t sse_lowest(__m128i a) {
    a = _mm_min_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_min_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
static inline int32_t sse_highest(__m128i a) {
    a = _mm_max_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_max_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
static inline int32_t i32_lowest(bn_i32v a) {
    return sse_lowest(_mm_min_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1)));
}
static inline int32_t i32_highest(bn_i32v a) {
    return sse_highest(_mm_max_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1)));
}
static inline uint32_t i32_equal_bits(bn_i32v a, bn_i32v b) {
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b)));
}

static inline int32_t i32_sum(bn_i32v a) {
    __m128i s = _mm_add_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
    s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(s, _mm_shuffle_epi32(s, 0xb1)));
}

typedef __m256i bn_i16x16;
static inline bn_i16x16 i16_set(int16_t a) {
    return _mm256_set1_epi16(a);
}
static inline bn_i16x16 i16_load(const int16_t *p) {
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
static inline bn_i16x16 i16_clamp(bn_i16x16 a, bn_i16x16 low, bn_i16x16 high) {
    return _mm256_min_epi16(_mm256_max_epi16(a, low), high);
}
static inline void i16_store(int16_t *p, bn_i16x16 a) {
    _mm256_storeu_si256((__m256i *)(void *)p, a);
}
BN_BINARY(i16_add, bn_i16x16, _mm256_add_epi16)
BN_BINARY(i16_subtract_saturated, bn_i16x16, _mm256_subs_epi16)
static inline bn_i16x16 i16_shift_left(bn_i16x16 a, int32_t shift) {
    return _mm256_sll_epi16(a, _mm_cvtsi32_si128(shift));
}
BN_BINARY(i16_multiply_upper, bn_i16x16, _mm256_mulhrs_epi16)
static inline bn_i32v i16_multiply_add(bn_i32v sum, bn_i16x16 a, bn_i16x16 b) {
    return _mm256_add_epi32(sum, _mm256_madd_epi16(a, b));
}
