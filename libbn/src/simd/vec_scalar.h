/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h in plain C, as arrays; vec.h describes the functions. */
#include <string.h>

#define BN_SIMD_TABLE bn_simd_scalar

/* Defines a function of two vectors by its operation on one lane. */
#define BN_BINARY(name, type, lanes, lane)                                                         \
    static inline type name(type x, type y) {                                                      \
        for (int i = 0; i < (lanes); ++i) x.v[i] = lane;                                           \
        return x;                                                                                  \
    }

/* Defines a vector type, and its functions that take one number or memory. */
#define BN_VECTOR(prefix, type, number, lanes)                                                     \
    typedef struct type {                                                                          \
        number v[lanes];                                                                           \
    } type;                                                                                        \
    static inline type prefix##_set(number v) {                                                    \
        type r;                                                                                    \
        for (int i = 0; i < (lanes); ++i) r.v[i] = v;                                              \
        return r;                                                                                  \
    }                                                                                              \
    static inline type prefix##_load(const number *p) {                                            \
        type r;                                                                                    \
        memcpy(r.v, p, sizeof r.v);                                                                \
        return r;                                                                                  \
    }                                                                                              \
    static inline void prefix##_store(number *p, type x) {                                         \
        memcpy(p, x.v, sizeof x.v);                                                                \
    }

BN_VECTOR(i32, bn_i32v, int32_t, 8)
#define i32_load_any i32_load
BN_BINARY(i32_add, bn_i32v, 8, (int32_t)((uint32_t)x.v[i] + (uint32_t)y.v[i]))
BN_BINARY(i32_subtract, bn_i32v, 8, (int32_t)((uint32_t)x.v[i] - (uint32_t)y.v[i]))
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

static inline int32_t i32_sum(bn_i32v x) {
    uint32_t sum = 0;
    for (int i = 0; i < 8; ++i) sum += (uint32_t)x.v[i];
    return (int32_t)sum;
}

BN_VECTOR(i16, bn_i16x16, int16_t, 16)
static inline bn_i16x16 i16_clamp(bn_i16x16 x, bn_i16x16 low, bn_i16x16 high) {
    for (int i = 0; i < 16; ++i) {
        x.v[i] = x.v[i] < low.v[i] ? low.v[i] : x.v[i];
        x.v[i] = x.v[i] > high.v[i] ? high.v[i] : x.v[i];
    }
    return x;
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
static inline bn_i32v i16_multiply_add(bn_i32v sum, bn_i16x16 x, bn_i16x16 y) {
    for (int i = 0; i < 8; ++i) {
        const int32_t two = x.v[2 * i] * y.v[2 * i] + x.v[2 * i + 1] * y.v[2 * i + 1];
        sum.v[i] = (int32_t)((uint32_t)sum.v[i] + (uint32_t)two);
    }
    return sum;
}
#undef BN_VECTOR
