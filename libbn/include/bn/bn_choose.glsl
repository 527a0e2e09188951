/* SPDX-License-Identifier: Apache-2.0
 * Makes discrete choices with a random number and rescales its remainder for reuse: bn_choose(),
 * bn_choose_u32() and bn_choose_cdf() in the common subset of GLSL, HLSL, Metal, CUDA and C.
 * bn_choose.h documents them. bn_choose.h, bn_choose.hlsl and bn_choose.metal include this file;
 * libbn/tools/make_wgsl.py translates it to the WGSL files. Results are bit-identical in all
 * languages, except that shader compilers may flush subnormal numbers to 0 and treat NaN as any value.
 *
 * In a shader (GLSL 3.30 or GLSL ES 3.00, no extensions), include this file, with or without
 * bn_draw.glsl:
 *
 *     vec4 u = bn_draw_blue_4d(seed, uint(pixel.x), uint(pixel.y), index, domain);
 *     uint light = bn_choose_u32(light_count, u.x);
 *     bool coat = bn_choose(coat_probability, u.z);
 *
 * For bn_choose_cdf(first, count, u), define how to read a table. `first` is the index of the
 * table's first entry:
 *
 *     layout(std430, binding = 1) readonly buffer cdf_table { float cdf[]; };
 *     #define BN_CDF(i) cdf[i] */
#ifndef BN_CHOOSE_GLSL
#define BN_CHOOSE_GLSL

#ifndef BN_FUNCTION
#ifdef GL_ES
precision highp float;
precision highp int;
#endif
#define BN_UINT uint
#define BN_FUNCTION
#endif

#ifndef BN_CHOOSE_U
#define BN_BOOL bool
#define BN_FALSE false
#define BN_TO_UINT(v) uint(v)
#define BN_TO_FLOAT(v) float(v)
#define BN_CHOOSE_U inout float u
#define BN_CHOOSE_GET_U u
#define BN_CHOOSE_TABLE uint first,
#ifdef BN_CDF
#define BN_CHOOSE_LIMIT(i) BN_CDF(first + (i))
#endif
#endif

#define BN_CHOOSE_STEPS 0x1000000u /* steps of 2^-24 in [0, 1) */

#ifndef BN_CHOOSE_POSITIVE
#define BN_CHOOSE_POSITIVE(v) bn_choose_positive(v)
/* No comparison is true for NaN. */
BN_FUNCTION BN_BOOL bn_choose_positive(float v) {
    return v > 0.0f;
}
#endif

/* The step that contains u; 0 for NaN. */
BN_FUNCTION BN_UINT bn_choose_step(float u) {
    if (!BN_CHOOSE_POSITIVE(u)) return 0u;
    return u < 1.0f ? BN_TO_UINT(u * 16777216.0f) : BN_CHOOSE_STEPS - 1u;
}

/* The number of steps below a limit: those for which u < limit. */
BN_FUNCTION BN_UINT bn_choose_steps_below(float limit) {
    if (!BN_CHOOSE_POSITIVE(limit)) return 0u;
    float steps = (limit < 1.0f ? limit : 1.0f) * 16777216.0f;
    BN_UINT whole = BN_TO_UINT(steps);
    return BN_TO_FLOAT(whole) < steps ? whole + 1u : whole;
}

#ifndef BN_CHOOSE_STRETCH
#define BN_CHOOSE_STRETCH(at, width) bn_choose_stretch(at, width)
/* (at + 1/2) / width in steps, rounded down, by long division. Requires at < width <=
 * 2^24. */
BN_FUNCTION BN_UINT bn_choose_stretch(BN_UINT at, BN_UINT width) {
    BN_UINT rest = 2u * at + 1u;
    BN_UINT quotient = rest / width;
    rest = (rest - quotient * width) << 8u;
    quotient = quotient << 8u | rest / width;
    rest = (rest - rest / width * width) << 8u;
    quotient = quotient << 8u | rest / width;
    rest = (rest - rest / width * width) << 7u;
    return quotient << 7u | rest / width;
}
#endif

#ifndef BN_MULTIPLY_HIGH
#define BN_MULTIPLY_HIGH(a, b) bn_multiply_high(a, b)
/* The upper half of the 64-bit product, computed from half-word products. */
BN_FUNCTION BN_UINT bn_multiply_high(BN_UINT a, BN_UINT b) {
    BN_UINT low = (a & 0xffffu) * (b & 0xffffu);
    BN_UINT left = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    BN_UINT right = (a & 0xffffu) * (b >> 16u) + (left & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u);
}
#endif

BN_FUNCTION float bn_choose_float(BN_UINT at) {
    return BN_TO_FLOAT(at) * (1.0f / 16777216.0f);
}

BN_FUNCTION BN_BOOL bn_choose(float probability, BN_CHOOSE_U) {
    BN_UINT at = bn_choose_step(BN_CHOOSE_GET_U);
    BN_UINT limit = bn_choose_steps_below(probability);
    BN_UINT low = at < limit ? 0u : limit;
    BN_UINT width = at < limit ? limit : BN_CHOOSE_STEPS - limit;
    BN_CHOOSE_GET_U = bn_choose_float(BN_CHOOSE_STRETCH(at - low, width));
    return at < limit;
}

/* Multiplies the step's centre by count: the integer part is the choice, and the fraction is the
 * remainder. */
BN_FUNCTION BN_UINT bn_choose_u32(BN_UINT count, BN_CHOOSE_U) {
    BN_UINT n = count > 0u ? count : 1u;
    BN_UINT middle = 2u * bn_choose_step(BN_CHOOSE_GET_U) + 1u;
    BN_UINT low = middle * n;
    BN_CHOOSE_GET_U = bn_choose_float(low >> 1u & (BN_CHOOSE_STEPS - 1u));
    return BN_MULTIPLY_HIGH(middle, n) << 7u | low >> 25u;
}

/* Whether a step, in a table's units, lies below a limit. */
BN_FUNCTION BN_BOOL bn_choose_is_below(BN_UINT at, float unit, float limit) {
    if (!BN_CHOOSE_POSITIVE(limit)) return BN_FALSE;
    return BN_TO_FLOAT(at) * unit < limit;
}

/* The number of steps below a limit. GPU quotients may be off by a few steps; products are not. */
BN_FUNCTION BN_UINT bn_choose_steps_of(float unit, float limit) {
    BN_UINT at = BN_CHOOSE_STEPS;
    if (bn_choose_is_below(BN_CHOOSE_STEPS - 1u, unit, limit)) return at;
    if (!BN_CHOOSE_POSITIVE(limit)) return 0u;
    float quotient = limit / unit;
    if (quotient < 16777216.0f) at = BN_TO_UINT(quotient);
    while (at > 0u && !bn_choose_is_below(at - 1u, unit, limit)) at -= 1u;
    while (bn_choose_is_below(at, unit, limit)) at += 1u;
    return at;
}

#ifdef BN_CHOOSE_LIMIT
BN_FUNCTION BN_UINT bn_choose_cdf(BN_CHOOSE_TABLE BN_UINT count, BN_CHOOSE_U) {
    BN_UINT at = bn_choose_step(BN_CHOOSE_GET_U);
    BN_UINT item = 0u, last = count > 0u ? count - 1u : 0u;
    BN_UINT end = last, low = 0u, high = BN_CHOOSE_STEPS;
    float sum = 1.0f;
    if (last > 0u) sum = BN_CHOOSE_LIMIT(last);
    if (!BN_CHOOSE_POSITIVE(sum) || sum < 1e-30f || sum > 1e30f) sum = 1.0f;
    float unit = sum * (1.0f / 16777216.0f);
    while (item < last) {
        BN_UINT middle = item + (last - item) / 2u;
        if (bn_choose_is_below(at, unit, BN_CHOOSE_LIMIT(middle))) {
            last = middle;
        } else {
            item = middle + 1u;
        }
    }
    if (item > 0u) low = bn_choose_steps_of(unit, BN_CHOOSE_LIMIT(item - 1u));
    if (item < end) high = bn_choose_steps_of(unit, BN_CHOOSE_LIMIT(item));
    BN_CHOOSE_GET_U = bn_choose_float(BN_CHOOSE_STRETCH(at - low, high - low));
    return item;
}
#endif

#endif
