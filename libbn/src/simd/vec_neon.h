/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h for NEON, in pairs of registers; vec.h describes the functions. */
#include <arm_neon.h>
#define BN_SIMD_TABLE bn_simd_neon
typedef struct bn_i32v {
    int32x4_t a, b;
} bn_i32v;
typedef struct bn_i16x16 {
    int16x8_t a, b;
} bn_i16x16;

/* Defines a function of two vectors from one instruction. */
#define BN_BINARY(name, type, operation)                                                           \
    static inline type name(type x, type y) {                                                      \
        type r = {operation(x.a, y.a), operation(x.b, y.b)};                                       \
        return r;                                                                                  \
    }

static inline bn_i32v i32_set(int32_t v) {
    bn_i32v r = {vdupq_n_s32(v), vdupq_n_s32(v)};
    return r;
}
static inline bn_i32v i32_load(const int32_t *p) {
    bn_i32v r = {vld1q_s32(p), vld1q_s32(p + 4)};
    return r;
}
static inline void i32_store(int32_t *p, bn_i32v x) {
    vst1q_s32(p, x.a);
    vst1q_s32(p + 4, x.b);
}
#define i32_load_any i32_load
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

BN_BINARY(i32_add, bn_i32v, vaddq_s32)
BN_BINARY(i32_subtract, bn_i32v, vsubq_s32)
BN_BINARY(i32_and, bn_i32v, vandq_s32)
BN_BINARY(i32_or, bn_i32v, vorrq_s32)
BN_BINARY(i32_min, bn_i32v, vminq_s32)
BN_BINARY(i32_max, bn_i32v, vmaxq_s32)
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

static inline int32_t i32_sum(bn_i32v x) {
    return vaddvq_s32(vaddq_s32(x.a, x.b));
}
BN_BINARY(i16_add, bn_i16x16, vaddq_s16)
BN_BINARY(i16_subtract_saturated, bn_i16x16, vqsubq_s16)
BN_BINARY(i16_multiply_upper, bn_i16x16, vqrdmulhq_s16)
static inline bn_i16x16 i16_shift_left(bn_i16x16 x, int32_t shift) {
    const int16x8_t by = vdupq_n_s16((int16_t)shift);
    bn_i16x16 r = {vshlq_s16(x.a, by), vshlq_s16(x.b, by)};
    return r;
}
static inline bn_i32v i16_multiply_add(bn_i32v sum, bn_i16x16 x, bn_i16x16 y) {
    sum.a = vmlal_s16(sum.a, vget_low_s16(x.a), vget_low_s16(y.a));
    sum.b = vmlal_s16(sum.b, vget_high_s16(x.a), vget_high_s16(y.a));
    sum.a = vmlal_s16(sum.a, vget_low_s16(x.b), vget_low_s16(y.b));
    sum.b = vmlal_s16(sum.b, vget_high_s16(x.b), vget_high_s16(y.b));
    return sum;
}
