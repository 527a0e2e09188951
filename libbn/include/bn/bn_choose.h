/* SPDX-License-Identifier: Apache-2.0
 * Make a discrete choice with a random number and reuse the remainder.
 *
 * A choice needs only the leading digits of a number. These functions choose, then rescale the part of [0, 1)
 * that made the choice to [0, 1). So the choice and the next decision come from one well-stratified pair, and
 * a draw is saved:
 *
 *     float u[4];
 *     bn_sample_4d(sampler, x, y, index, domain, u);
 *     const uint32_t light = bn_choose_u32(light_count, &u[0]);
 *     vec3 point = point_on_light(light, u[0], u[1]);
 *     vec3 direction = bn_choose(coat_probability, &u[2]) ? sample_coat(u[2], u[3]) : sample_base(u[2], u[3]);
 *
 * Order the items so that neighbours in the list are neighbours in space.
 *
 * Precision. A draw is a multiple of 2^-24 and represents the step of that width above it. The remainder is
 * the middle of the step, rescaled and rounded down to a multiple of 2^-24, always below 1. An item that is w
 * steps wide leaves w different remainders, spread evenly: an item with a probability of 1/256 leaves 16
 * bits, from which you can choose again. A choice of probability 1 leaves the draw as it was.
 *
 * Range. A u below 0 or NaN counts as 0, one of 1 or more as the last step, also in programs compiled with
 * -ffast-math. Digits of u finer than 2^-24 are dropped.
 *
 * These are inline functions, __host__ __device__ in CUDA and HIP; shaders have them in bn_choose.glsl and
 * the files beside it (docs/shaders.md), with the same bits. A choice takes a few nanoseconds,
 * bn_choose_cdf() O(log count). */
#ifndef BN_BN_CHOOSE_H
#define BN_BN_CHOOSE_H

#include <bn/bn_device.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns 1 with the given probability, exactly if *u < probability; else 0. Either way *u becomes the
 * remainder. The chance is the probability rounded up to a multiple of 2^-24: if it is far below 2^-12,
 * divide by the rounded probability, or your estimate is biased by the difference. A probability
 * of 0 or less, or NaN, never returns 1; one of 1 or more always does. */
BN_DEVICE_INLINE int bn_choose(float probability, float *u);

/* Returns one of `count` items, all equally likely: each has 2^24 / count steps, rounded up or down. Above
 * 2^24 items, only 2^24 of them can be chosen, evenly spread. A count of 0 returns 0. */
BN_DEVICE_INLINE uint32_t bn_choose_u32(uint32_t count, float *u);

/* Returns item i with a probability in proportion to cdf[i] - cdf[i - 1]: the first item for which *u * sum <
 * cdf[i]. The cumulative weights ascend to any positive sum, from 1e-30 to 1e30. Limits are rounded up to
 * steps, 2^-24 of the sum; if they are whole steps, the probabilities are exact. Items without a step between
 * their limits are never chosen. Any table is safe: out of order, with NaN or with another sum, some item is
 * chosen. A count of 0 returns 0.
 *
 * For a 2-D map, choose the row with one number of a pair and the column with the other, from a table for
 * each row. One search over all texels would break the stratification of the pair. */
BN_DEVICE_INLINE uint32_t bn_choose_cdf(const float *cdf, uint32_t count, float *u);

/* ---- The text that shaders share */

/* Whether v > 0, by its bits: where -ffast-math assumes that there is no NaN, comparisons miss it. */
BN_DEVICE_INLINE int bn_choose_positive(float v) {
    union {
        float number;
        uint32_t bits;
    } u;
    u.number = v;
    return u.bits - 1u < 0x7f800000u;
}

#ifndef BN_DEVICE_TOO /* GPUs are slow at double, and divide integers as shaders do */
/* The quotient in double. Its distance from the next integer is 2^-24 or more, unless it is one; so rounding
 * cannot reach another, even where -ffast-math multiplies by the reciprocal. */
BN_HOST_INLINE uint32_t bn_choose_stretched(uint32_t place, uint32_t width) {
    const double middle = 2.0 * BN_CAST(double, BN_CAST(int32_t, place)) + 1.0;
    const double steps = BN_CAST(double, BN_CAST(int32_t, width));
    return BN_TO_UINT(middle * 8388608.0 / steps + 1.0 / 67108864.0);
}
#define BN_CHOOSE_STRETCH(place, width) bn_choose_stretched(place, width)
#endif

#define BN_CHOOSE_U float *u
#define BN_CHOOSE_GET_U (*u)
/* The first parameter, with its comma, where shaders have the place of the table instead. */
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
