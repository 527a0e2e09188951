/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h in pairs of registers of four 32-bit or eight 16-bit integers; vec.h
 * says what each function does. The including file defines types and functions of one register. */
#define BN_I32_LANES 8
typedef struct bn_i32x8 {
    bn_i32x4 a, b;
} bn_i32x8, bn_i32v;
typedef struct bn_i16x16 {
    bn_i16x8 a, b;
} bn_i16x16;

/* A function of two vectors from an instruction. */
#define BN_BINARY(name, type, operation)                                                           \
    static inline type name(type x, type y) {                                                      \
        type r = {operation(x.a, y.a), operation(x.b, y.b)};                                       \
        return r;                                                                                  \
    }

static inline bn_i32v i32_set(int32_t v) {
    bn_i32v r = {i32x4_set(v), i32x4_set(v)};
    return r;
}
static inline bn_i32v i32_load(const int32_t *p) {
    bn_i32v r = {i32x4_load(p), i32x4_load(p + 4)};
    return r;
}
static inline bn_i32v i32_load_rows(const int32_t *p, ptrdiff_t step) {
    bn_i32v r = {i32x4_load_any(p), i32x4_load_any(p + 4)};
    (void)step;
    return r;
}
static inline void i32_store(int32_t *p, bn_i32v x) {
    i32x4_store(p, x.a);
    i32x4_store(p + 4, x.b);
}
static inline bn_i32x8 x8_zero(void) {
    return i32_set(0);
}
static inline bn_i16x16 i16_set(int16_t v) {
    bn_i16x16 r = {i16x8_set(v), i16x8_set(v)};
    return r;
}
static inline bn_i16x16 i16_load(const int16_t *p) {
    bn_i16x16 r = {i16x8_load(p), i16x8_load(p + 8)};
    return r;
}
static inline bn_i16x16 i16_clamp(bn_i16x16 x, bn_i16x16 low, bn_i16x16 high) {
    bn_i16x16 r = {i16x8_min(i16x8_max(x.a, low.a), high.a),
                   i16x8_min(i16x8_max(x.b, low.b), high.b)};
    return r;
}
static inline void i16_store(int16_t *p, bn_i16x16 x) {
    i16x8_store(p, x.a);
    i16x8_store(p + 8, x.b);
}
