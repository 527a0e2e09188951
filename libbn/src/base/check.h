/* SPDX-License-Identifier: Apache-2.0
 * Argument checks. Every function returns the same error for the same mistake. */
#ifndef BN_CHECK_H
#define BN_CHECK_H

#include <bn/bn.h>

/* The maximum number of texels in a mask: the algorithms count them in 32-bit integers. */
#define BN_MOST_TEXELS ((uint64_t)INT32_MAX)

/* Stores the product of four factors in *product. Returns 0 if it exceeds `limit`. */
int bn_product(const uint32_t factors[4], uint64_t limit, uint64_t *product);

/* Checks that `count` elements make up `channels` masks of width x height x depth texels. Errors:
 * INVALID_ARGUMENT (a zero extent), OUT_OF_MEMORY (a mask has more than BN_MOST_TEXELS),
 * SIZE_MISMATCH. */
bn_result bn_check_extents(uint32_t width, uint32_t height, uint32_t depth, uint32_t channels,
                           size_t count);

/* The rank of texel `at` in memory order, in a mask that has passed one of the checks below. */
uint32_t bn_mask_rank(const bn_mask *mask, size_t at);

/* Checks that `mask` is a single-channel 2-D mask in which each rank from 0 to count - 1 occurs once.
 * Errors: INVALID_ARGUMENT (also for NULL), OUT_OF_MEMORY (as above), BAD_DATA (not a permutation).
 * Needs one bit of memory per texel. */
bn_result bn_check_mask(const bn_mask *mask);

/* Checks a mask before it is written, and counts the ranks in all its channels. Errors: INVALID_ARGUMENT
 * (NULL, a zero extent, rank_bits other than 16 or 32, or too few for the ranks), OUT_OF_MEMORY (a channel
 * with more than BN_MOST_TEXELS, or a total that exceeds the address space). */
bn_result bn_check_new_mask(const bn_mask *mask, size_t *count);

/* Writes the ranks of a mask that has passed bn_check_new_mask(). */
void bn_mask_write(const bn_mask *mask, const uint32_t *ranks, size_t count);

/* One channel of a mask. */
bn_mask bn_mask_channel(const bn_mask *mask, uint32_t channel);

/* Whether low <= value <= high; false for NaN and infinities. Examines the bits, so that a compiler that
 * assumes finite values (-ffast-math) cannot drop the check. */
int bn_in_range(double value, double low, double high);

/* The largest bits of the values without their signs: BN_INFINITY_BITS if one is infinite, more if one is NaN. */
enum { BN_INFINITY_BITS = 0x7f800000 };
int32_t bn_largest_bits(const float *values, size_t count);

#endif
