/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h, for each instruction set.
 *
 * bn_i32v: BN_I32_LANES integers of 32 bits, 8 or 16. Loads and stores are aligned, except that
 * i32_load_rows fetches eight from anywhere, and with 16 lanes another eight `step` further on.
 * bn_i32x8 and bn_i16x16: sums and values of the annealer, whatever the registers. */
#ifndef BN_SIMD_VEC_H
#define BN_SIMD_VEC_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint32_t first_bit(uint64_t bits) {
#if defined(__GNUC__)
    return (uint32_t)__builtin_ctzll(bits);
#else
    uint32_t i = 0;
    while (i < 63 && !(bits >> i & 1)) ++i;
    return i;
#endif
}

#if defined(BN_SIMD_SSE41) || defined(BN_SIMD_AVX2) || defined(BN_SIMD_AVX512)
#include <immintrin.h>
static inline int32_t sse_lowest(__m128i a) {
    a = _mm_min_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_min_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
static inline int32_t sse_highest(__m128i a) {
    a = _mm_max_epi32(a, _mm_shuffle_epi32(a, 0x4e));
    return _mm_cvtsi128_si32(_mm_max_epi32(a, _mm_shuffle_epi32(a, 0xb1)));
}
#endif

#if defined(BN_SIMD_AVX2) || defined(BN_SIMD_AVX512)
#if defined(BN_SIMD_AVX2)
#define BN_SIMD_NAME "avx2"
#define BN_SIMD_TABLE bn_simd_avx2
#else
#define BN_SIMD_NAME "avx512"
#define BN_SIMD_TABLE bn_simd_avx512
#endif

#if !defined(BN_SIMD_AVX512)
#define BN_I32_LANES 8
typedef __m256i bn_i32v;
static inline bn_i32v i32_set(int32_t a) {
    return _mm256_set1_epi32(a);
}
static inline bn_i32v i32_load(const int32_t *p) {
    return _mm256_load_si256((const __m256i *)(const void *)p);
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    (void)step;
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
static inline void i32_store(int32_t *p, bn_i32v a) {
    _mm256_store_si256((__m256i *)(void *)p, a);
}
static inline bn_i32v i32_add(bn_i32v a, bn_i32v b) {
    return _mm256_add_epi32(a, b);
}
static inline bn_i32v i32_subtract(bn_i32v a, bn_i32v b) {
    return _mm256_sub_epi32(a, b);
}
static inline bn_i32v i32_and(bn_i32v a, bn_i32v b) {
    return _mm256_and_si256(a, b);
}
static inline bn_i32v i32_or(bn_i32v a, bn_i32v b) {
    return _mm256_or_si256(a, b);
}
static inline bn_i32v i32_min(bn_i32v a, bn_i32v b) {
    return _mm256_min_epi32(a, b);
}
static inline bn_i32v i32_max(bn_i32v a, bn_i32v b) {
    return _mm256_max_epi32(a, b);
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
#else
#define BN_I32_LANES 16
typedef __m512i bn_i32v;
static inline bn_i32v i32_set(int32_t a) {
    return _mm512_set1_epi32(a);
}
static inline bn_i32v i32_load(const int32_t *p) {
    return _mm512_load_si512((const void *)p);
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    __m256i first = _mm256_loadu_si256((const __m256i *)(const void *)p);
    __m256i second = _mm256_loadu_si256((const __m256i *)(const void *)(p + step));
    return _mm512_inserti64x4(_mm512_castsi256_si512(first), second, 1);
}
static inline void i32_store(int32_t *p, bn_i32v a) {
    _mm512_store_si512((void *)p, a);
}
static inline bn_i32v i32_add(bn_i32v a, bn_i32v b) {
    return _mm512_add_epi32(a, b);
}
static inline bn_i32v i32_subtract(bn_i32v a, bn_i32v b) {
    return _mm512_sub_epi32(a, b);
}
static inline bn_i32v i32_and(bn_i32v a, bn_i32v b) {
    return _mm512_and_si512(a, b);
}
static inline bn_i32v i32_or(bn_i32v a, bn_i32v b) {
    return _mm512_or_si512(a, b);
}
static inline bn_i32v i32_min(bn_i32v a, bn_i32v b) {
    return _mm512_min_epi32(a, b);
}
static inline bn_i32v i32_max(bn_i32v a, bn_i32v b) {
    return _mm512_max_epi32(a, b);
}
static inline int32_t i32_lowest(bn_i32v a) {
    __m256i b = _mm256_min_epi32(_mm512_castsi512_si256(a), _mm512_extracti64x4_epi64(a, 1));
    return sse_lowest(_mm_min_epi32(_mm256_castsi256_si128(b), _mm256_extracti128_si256(b, 1)));
}
static inline int32_t i32_highest(bn_i32v a) {
    __m256i b = _mm256_max_epi32(_mm512_castsi512_si256(a), _mm512_extracti64x4_epi64(a, 1));
    return sse_highest(_mm_max_epi32(_mm256_castsi256_si128(b), _mm256_extracti128_si256(b, 1)));
}
static inline uint32_t i32_equal_bits(bn_i32v a, bn_i32v b) {
    return _mm512_cmpeq_epi32_mask(a, b);
}
#endif

typedef __m256i bn_i32x8, bn_i16x16;

static inline bn_i32x8 x8_zero(void) {
    return _mm256_setzero_si256();
}
static inline bn_i32x8 x8_subtract(bn_i32x8 a, bn_i32x8 b) {
    return _mm256_sub_epi32(a, b);
}
static inline int32_t x8_sum(bn_i32x8 a) {
    __m128i s = _mm_add_epi32(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
    s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(s, _mm_shuffle_epi32(s, 0xb1)));
}
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
static inline bn_i16x16 i16_add(bn_i16x16 a, bn_i16x16 b) {
    return _mm256_add_epi16(a, b);
}
static inline bn_i16x16 i16_subtract_saturated(bn_i16x16 a, bn_i16x16 b) {
    return _mm256_subs_epi16(a, b);
}
static inline bn_i16x16 i16_shift_left(bn_i16x16 a, int32_t shift) {
    return _mm256_sll_epi16(a, _mm_cvtsi32_si128(shift));
}
static inline bn_i16x16 i16_multiply_upper(bn_i16x16 a, bn_i16x16 b) {
    return _mm256_mulhrs_epi16(a, b);
}
static inline bn_i32x8 i16_multiply_add(bn_i32x8 sum, bn_i16x16 a, bn_i16x16 b) {
    return _mm256_add_epi32(sum, _mm256_madd_epi16(a, b));
}

#elif defined(BN_SIMD_SSE41)
#define BN_SIMD_NAME "sse4.1"
#define BN_SIMD_TABLE bn_simd_sse41
typedef struct bn_halves {
    __m128i a, b;
} bn_halves, bn_i32x8, bn_i16x16;

#define BN_I32_LANES 8
typedef bn_halves bn_i32v;
static inline bn_i32v i32_set(int32_t v) {
    bn_i32v r = {_mm_set1_epi32(v), _mm_set1_epi32(v)};
    return r;
}
static inline bn_i32v i32_load(const int32_t *p) {
    bn_i32v r = {_mm_load_si128((const __m128i *)(const void *)(p)),
                 _mm_load_si128((const __m128i *)(const void *)(p + 4))};
    return r;
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    bn_i32v r = {_mm_loadu_si128((const __m128i *)(const void *)(p)),
                 _mm_loadu_si128((const __m128i *)(const void *)(p + 4))};
    (void)step;
    return r;
}
static inline void i32_store(int32_t *p, bn_i32v x) {
    _mm_store_si128((__m128i *)(void *)(p), x.a);
    _mm_store_si128((__m128i *)(void *)(p + 4), x.b);
}
static inline bn_i32v i32_add(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_add_epi32(x.a, y.a), _mm_add_epi32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_subtract(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_sub_epi32(x.a, y.a), _mm_sub_epi32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_and(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_and_si128(x.a, y.a), _mm_and_si128(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_or(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_or_si128(x.a, y.a), _mm_or_si128(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_min(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_min_epi32(x.a, y.a), _mm_min_epi32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_max(bn_i32v x, bn_i32v y) {
    bn_i32v r = {_mm_max_epi32(x.a, y.a), _mm_max_epi32(x.b, y.b)};
    return r;
}
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

static inline bn_i32x8 x8_zero(void) {
    bn_i32x8 r = {_mm_setzero_si128(), _mm_setzero_si128()};
    return r;
}
static inline bn_i32x8 x8_subtract(bn_i32x8 x, bn_i32x8 y) {
    bn_i32x8 r = {_mm_sub_epi32(x.a, y.a), _mm_sub_epi32(x.b, y.b)};
    return r;
}
static inline int32_t x8_sum(bn_i32x8 x) {
    __m128i s = _mm_add_epi32(x.a, x.b);
    s = _mm_add_epi32(s, _mm_shuffle_epi32(s, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(s, _mm_shuffle_epi32(s, 0xb1)));
}
static inline bn_i16x16 i16_set(int16_t v) {
    bn_i16x16 r = {_mm_set1_epi16(v), _mm_set1_epi16(v)};
    return r;
}
static inline bn_i16x16 i16_load(const int16_t *p) {
    bn_i16x16 r = {_mm_loadu_si128((const __m128i *)(const void *)p),
                   _mm_loadu_si128((const __m128i *)(const void *)(p + 8))};
    return r;
}
static inline bn_i16x16 i16_clamp(bn_i16x16 x, bn_i16x16 low, bn_i16x16 high) {
    bn_i16x16 r = {_mm_min_epi16(_mm_max_epi16(x.a, low.a), high.a),
                   _mm_min_epi16(_mm_max_epi16(x.b, low.b), high.b)};
    return r;
}
static inline void i16_store(int16_t *p, bn_i16x16 x) {
    _mm_storeu_si128((__m128i *)(void *)p, x.a);
    _mm_storeu_si128((__m128i *)(void *)(p + 8), x.b);
}
static inline bn_i16x16 i16_add(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {_mm_add_epi16(x.a, y.a), _mm_add_epi16(x.b, y.b)};
    return r;
}
static inline bn_i16x16 i16_subtract_saturated(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {_mm_subs_epi16(x.a, y.a), _mm_subs_epi16(x.b, y.b)};
    return r;
}
static inline bn_i16x16 i16_multiply_upper(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {_mm_mulhrs_epi16(x.a, y.a), _mm_mulhrs_epi16(x.b, y.b)};
    return r;
}
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

#elif defined(BN_SIMD_NEON)
#include <arm_neon.h>
#define BN_SIMD_NAME "neon"
#define BN_SIMD_TABLE bn_simd_neon
typedef struct bn_i32x8 {
    int32x4_t a, b;
} bn_i32x8;
typedef struct bn_i16x16 {
    int16x8_t a, b;
} bn_i16x16;

#define BN_I32_LANES 8
typedef bn_i32x8 bn_i32v;
static inline bn_i32v i32_set(int32_t v) {
    bn_i32v r = {vdupq_n_s32(v), vdupq_n_s32(v)};
    return r;
}
static inline bn_i32v i32_load(const int32_t *p) {
    bn_i32v r = {vld1q_s32(p), vld1q_s32(p + 4)};
    return r;
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    bn_i32v r = {vld1q_s32(p), vld1q_s32(p + 4)};
    (void)step;
    return r;
}
static inline void i32_store(int32_t *p, bn_i32v x) {
    vst1q_s32(p, x.a);
    vst1q_s32(p + 4, x.b);
}
static inline bn_i32v i32_add(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vaddq_s32(x.a, y.a), vaddq_s32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_subtract(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vsubq_s32(x.a, y.a), vsubq_s32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_and(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vandq_s32(x.a, y.a), vandq_s32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_or(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vorrq_s32(x.a, y.a), vorrq_s32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_min(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vminq_s32(x.a, y.a), vminq_s32(x.b, y.b)};
    return r;
}
static inline bn_i32v i32_max(bn_i32v x, bn_i32v y) {
    bn_i32v r = {vmaxq_s32(x.a, y.a), vmaxq_s32(x.b, y.b)};
    return r;
}
static inline int32_t i32_lowest(bn_i32v x) {
    return vminvq_s32(vminq_s32(x.a, x.b));
}
static inline int32_t i32_highest(bn_i32v x) {
    return vmaxvq_s32(vmaxq_s32(x.a, x.b));
}
static inline uint32_t i32_equal_bits(bn_i32v x, bn_i32v y) {
    static const uint16_t bit[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    uint16x8_t equal = vcombine_u16(vmovn_u32(vceqq_s32(x.a, y.a)), vmovn_u32(vceqq_s32(x.b, y.b)));
    return vaddvq_u16(vandq_u16(equal, vld1q_u16(bit)));
}

static inline bn_i32x8 x8_zero(void) {
    bn_i32x8 r = {vdupq_n_s32(0), vdupq_n_s32(0)};
    return r;
}
static inline bn_i32x8 x8_subtract(bn_i32x8 x, bn_i32x8 y) {
    bn_i32x8 r = {vsubq_s32(x.a, y.a), vsubq_s32(x.b, y.b)};
    return r;
}
static inline int32_t x8_sum(bn_i32x8 x) {
    return vaddvq_s32(vaddq_s32(x.a, x.b));
}
static inline bn_i16x16 i16_set(int16_t v) {
    bn_i16x16 r = {vdupq_n_s16(v), vdupq_n_s16(v)};
    return r;
}
static inline bn_i16x16 i16_load(const int16_t *p) {
    bn_i16x16 r = {vld1q_s16(p), vld1q_s16(p + 8)};
    return r;
}
static inline bn_i16x16 i16_clamp(bn_i16x16 x, bn_i16x16 low, bn_i16x16 high) {
    bn_i16x16 r = {vminq_s16(vmaxq_s16(x.a, low.a), high.a),
                   vminq_s16(vmaxq_s16(x.b, low.b), high.b)};
    return r;
}
static inline void i16_store(int16_t *p, bn_i16x16 x) {
    vst1q_s16(p, x.a);
    vst1q_s16(p + 8, x.b);
}
static inline bn_i16x16 i16_add(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {vaddq_s16(x.a, y.a), vaddq_s16(x.b, y.b)};
    return r;
}
static inline bn_i16x16 i16_subtract_saturated(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {vqsubq_s16(x.a, y.a), vqsubq_s16(x.b, y.b)};
    return r;
}
static inline bn_i16x16 i16_multiply_upper(bn_i16x16 x, bn_i16x16 y) {
    bn_i16x16 r = {vqrdmulhq_s16(x.a, y.a), vqrdmulhq_s16(x.b, y.b)};
    return r;
}
static inline bn_i16x16 i16_shift_left(bn_i16x16 x, int32_t shift) {
    const int16x8_t by = vdupq_n_s16((int16_t)shift);
    bn_i16x16 r = {vshlq_s16(x.a, by), vshlq_s16(x.b, by)};
    return r;
}
static inline bn_i32x8 i16_multiply_add(bn_i32x8 sum, bn_i16x16 x, bn_i16x16 y) {
    sum.a = vmlal_s16(sum.a, vget_low_s16(x.a), vget_low_s16(y.a));
    sum.b = vmlal_s16(sum.b, vget_high_s16(x.a), vget_high_s16(y.a));
    sum.a = vmlal_s16(sum.a, vget_low_s16(x.b), vget_low_s16(y.b));
    sum.b = vmlal_s16(sum.b, vget_high_s16(x.b), vget_high_s16(y.b));
    return sum;
}

#else
#define BN_SIMD_NAME "scalar"
#define BN_SIMD_TABLE bn_simd_scalar
#define BN_I32_LANES 8
typedef struct bn_i32v {
    int32_t v[8];
} bn_i32v;
static inline bn_i32v i32_set(int32_t v) {
    bn_i32v r;
    for (int i = 0; i < 8; ++i) r.v[i] = v;
    return r;
}
static inline bn_i32v i32_load(const int32_t *p) {
    bn_i32v r;
    memcpy(r.v, p, sizeof r.v);
    return r;
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    (void)step;
    return i32_load(p);
}
static inline void i32_store(int32_t *p, bn_i32v x) {
    memcpy(p, x.v, sizeof x.v);
}
static inline bn_i32v i32_add(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] += y.v[i];
    return x;
}
static inline bn_i32v i32_subtract(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] -= y.v[i];
    return x;
}
static inline bn_i32v i32_and(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] &= y.v[i];
    return x;
}
static inline bn_i32v i32_or(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] |= y.v[i];
    return x;
}
static inline bn_i32v i32_min(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] = y.v[i] < x.v[i] ? y.v[i] : x.v[i];
    return x;
}
static inline bn_i32v i32_max(bn_i32v x, bn_i32v y) {
    for (int i = 0; i < 8; ++i) x.v[i] = y.v[i] > x.v[i] ? y.v[i] : x.v[i];
    return x;
}
static inline int32_t i32_lowest(bn_i32v x) {
    int32_t low = x.v[0];
    for (int i = 1; i < 8; ++i) low = x.v[i] < low ? x.v[i] : low;
    return low;
}
static inline int32_t i32_highest(bn_i32v x) {
    int32_t high = x.v[0];
    for (int i = 1; i < 8; ++i) high = x.v[i] > high ? x.v[i] : high;
    return high;
}
static inline uint32_t i32_equal_bits(bn_i32v x, bn_i32v y) {
    uint32_t bits = 0;
    for (int i = 0; i < 8; ++i) bits |= (uint32_t)(x.v[i] == y.v[i]) << i;
    return bits;
}

/* Sums wrap, as they do in registers. */
typedef struct bn_i32x8 {
    uint32_t v[8];
} bn_i32x8;
typedef struct bn_i16x16 {
    int16_t v[16];
} bn_i16x16;

static inline bn_i32x8 x8_zero(void) {
    bn_i32x8 r = {{0}};
    return r;
}
static inline bn_i32x8 x8_subtract(bn_i32x8 x, bn_i32x8 y) {
    for (int i = 0; i < 8; ++i) x.v[i] -= y.v[i];
    return x;
}
static inline int32_t x8_sum(bn_i32x8 x) {
    uint32_t sum = 0;
    for (int i = 0; i < 8; ++i) sum += x.v[i];
    return (int32_t)sum;
}
static inline bn_i16x16 i16_set(int16_t v) {
    bn_i16x16 r;
    for (int i = 0; i < 16; ++i) r.v[i] = v;
    return r;
}
static inline bn_i16x16 i16_load(const int16_t *p) {
    bn_i16x16 r;
    memcpy(r.v, p, sizeof r.v);
    return r;
}
static inline bn_i16x16 i16_clamp(bn_i16x16 x, bn_i16x16 low, bn_i16x16 high) {
    for (int i = 0; i < 16; ++i) {
        x.v[i] = x.v[i] < low.v[i] ? low.v[i] : x.v[i];
        x.v[i] = x.v[i] > high.v[i] ? high.v[i] : x.v[i];
    }
    return x;
}
static inline void i16_store(int16_t *p, bn_i16x16 x) {
    memcpy(p, x.v, sizeof x.v);
}
static inline bn_i16x16 i16_add(bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 16; ++i) x.v[i] = (int16_t)(x.v[i] + y.v[i]);
    return x;
}
static inline bn_i16x16 i16_subtract_saturated(bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 16; ++i) {
        int32_t d = x.v[i] - y.v[i];
        x.v[i] = (int16_t)(d > INT16_MAX ? INT16_MAX : d < INT16_MIN ? INT16_MIN : d);
    }
    return x;
}
static inline bn_i16x16 i16_shift_left(bn_i16x16 x, int32_t shift) {
    for (int i = 0; i < 16; ++i) x.v[i] = (int16_t)(x.v[i] * (1 << shift));
    return x;
}
static inline bn_i16x16 i16_multiply_upper(bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 16; ++i) x.v[i] = (int16_t)((x.v[i] * y.v[i] + (1 << 14)) >> 15);
    return x;
}
static inline bn_i32x8 i16_multiply_add(bn_i32x8 sum, bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 8; ++i) {
        sum.v[i] += (uint32_t)(x.v[2 * i] * y.v[2 * i] + x.v[2 * i + 1] * y.v[2 * i + 1]);
    }
    return sum;
}
#endif

#endif
