/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h in plain C, as arrays; vec.h describes the functions. */
#include <string.h>

#define BN_SIMD_NAME "scalar"
#define BN_SIMD_TABLE bn_simd_scalar
#define BN_I32_LANES 8

/* A function of two vectors, defined by its operation on one lane. */
#define BN_BINARY(name, type, lanes, lane)                                                         \
    static inline type name(type x, type y) {                                                      \
        for (int i = 0; i < (lanes); ++i) x.v[i] = lane;                                           \
        return x;                                                                                  \
    }

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
#define i32_load_any i32_load
static inline void i32_store(int32_t *p, bn_i32v x) {
    memcpy(p, x.v, sizeof x.v);
}
BN_BINARY(i32_add, bn_i32v, 8, x.v[i] + y.v[i])
BN_BINARY(i32_subtract, bn_i32v, 8, x.v[i] - y.v[i])
BN_BINARY(i32_and, bn_i32v, 8, x.v[i] & y.v[i])
BN_BINARY(i32_or, bn_i32v, 8, x.v[i] | y.v[i])
BN_BINARY(i32_min, bn_i32v, 8, y.v[i] < x.v[i] ? y.v[i] : x.v[i])
BN_BINARY(i32_max, bn_i32v, 8, y.v[i] > x.v[i] ? y.v[i] : x.v[i])
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
BN_BINARY(x8_subtract, bn_i32x8, 8, x.v[i] - y.v[i])
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
BN_BINARY(i16_add, bn_i16x16, 16, (int16_t)(x.v[i] + y.v[i]))
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
BN_BINARY(i16_multiply_upper, bn_i16x16, 16, (int16_t)((x.v[i] * y.v[i] + (1 << 14)) >> 15))
static inline bn_i32x8 i16_multiply_add(bn_i32x8 sum, bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 8; ++i) {
        sum.v[i] += (uint32_t)(x.v[2 * i] * y.v[2 * i] + x.v[2 * i + 1] * y.v[2 * i + 1]);
    }
    return sum;
}
