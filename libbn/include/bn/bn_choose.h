/* SPDX-License-Identifier: Apache-2.0
 * Makes discrete choices with a random number and rescales its remainder for reuse.
 *
 * A choice uses only the leading digits of a number. These functions make the choice, then rescale the chosen
 * part of [0, 1) to the whole interval. That lets the choice and the next decision share one well-stratified
 * pair, which saves a draw:
 *
 *     float u[4];
 *     bn_sample_4d(sampler, x, y, index, domain, u);
 *     const uint32_t light = bn_choose_u32(light_count, &u[0]);
 *     vec3 point = point_on_light(light, u[0], u[1]);
 *     vec3 direction = bn_choose(coat_probability, &u[2]) ? sample_coat(u[2], u[3]) : sample_base(u[2], u[3]);
 *
 * Order the items so that neighbours in the list are close in space.
 *
 * Precision. A draw is a multiple of 2^-24 and stands for the step of that width above it. The remainder is
 * the step's centre, rescaled and rounded down to a multiple of 2^-24, so it is always below 1. An item that
 * is w steps wide leaves w evenly spaced remainders: an item with probability 1/256 leaves 16 bits, which you
 * can use for another choice. A choice with probability 1 leaves the draw unchanged.
 *
 * Range. A negative u or a NaN counts as 0, and a u of 1 or more counts as the last step, even with
 * -ffast-math. Digits of u finer than 2^-24 are discarded.
 *
 * The functions are inline, and __host__ __device__ in CUDA and HIP. Shaders get bit-identical results from
 * bn_choose.glsl and related files (docs/shaders.md). A choice takes a few nanoseconds; bn_choose_cdf() is
 * O(log count). */
#ifndef BN_BN_CHOOSE_H
#define BN_BN_CHOOSE_H

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

#include <bn/bn_device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns 1 with the given probability (that is, if *u < probability) and 0 otherwise. In both cases, *u
 * becomes the remainder. The probability is rounded up to a multiple of 2^-24. If it is far below 2^-12,
 * divide by the rounded value; otherwise the difference biases your estimate. Never returns 1 if the
 * probability is NaN or at most 0, and always does if it is 1 or more. */
BN_DEVICE_INLINE int bn_choose(float probability, float *u);

/* Returns one of `count` equally likely items: each spans 2^24 / count steps, rounded up or down. If there
 * are more than 2^24 items, only 2^24 evenly spaced ones can be chosen. Returns 0 if count is 0. */
BN_DEVICE_INLINE uint32_t bn_choose_u32(uint32_t count, float *u);

/* Returns item i with probability proportional to cdf[i] - cdf[i - 1]: the first item for which *u * sum <
 * cdf[i]. The cumulative weights must be non-decreasing, with a sum between 1e-30 and 1e30. They are rounded
 * up to multiples of 2^-24 of the sum; if they are already multiples, the probabilities are exact. An item
 * whose bounds round to the same step is never chosen. Any table is safe: even if it is out of order,
 * contains a NaN or has a sum outside that range, the function returns an item. Returns 0 if count is 0.
 *
 * For a 2-D map, use one number of a pair to choose the row, and the other to choose the column from that
 * row's table. A single search over all texels would break the pair's stratification. */
BN_DEVICE_INLINE uint32_t bn_choose_cdf(const float *cdf, uint32_t count, float *u);

/* ---- Code shared with shaders */

/* Whether v > 0, tested on its bits because -ffast-math assumes that no operand of a comparison is NaN. */
BN_DEVICE_INLINE int bn_choose_positive(float v) {
    return bn_float_bits(v) - 1u < 0x7f800000u;
}

#ifndef BN_DEVICE_TOO /* double is slow on GPUs, so they divide integers as shaders do */
/* The quotient, computed in double. It is an integer or at least 2^-24 away from the next one, so rounding
 * cannot reach another integer, even where -ffast-math multiplies by the reciprocal. */
BN_HOST_INLINE uint32_t bn_choose_stretched(uint32_t at, uint32_t width) {
    const double middle = 2.0 * BN_CAST(double, BN_CAST(int32_t, at)) + 1.0;
    const double steps = BN_CAST(double, BN_CAST(int32_t, width));
    return BN_TO_UINT(middle * 8388608.0 / steps + 1.0 / 67108864.0);
}
#define BN_CHOOSE_STRETCH(at, width) bn_choose_stretched(at, width)
#endif

#define BN_CHOOSE_U float *u
#define BN_CHOOSE_GET_U (*u)
/* The first parameter, with its comma. In shaders it is the index of the table's first entry. */
#define BN_CHOOSE_TABLE const float *cdf,
#define BN_CHOOSE_LIMIT(i) cdf[i]
#define BN_CHOOSE_POSITIVE(v) bn_choose_positive(v)
#include <bn/bn_choose.glsl>

#undef BN_CHOOSE_U
#undef BN_CHOOSE_GET_U
#undef BN_CHOOSE_TABLE
#undef BN_CHOOSE_LIMIT
#undef BN_CHOOSE_POSITIVE
#undef BN_CHOOSE_STRETCH
#include <bn/bn_device.h>

#ifdef __cplusplus
}
#endif

#endif
