/* SPDX-License-Identifier: Apache-2.0
 * The vector types of kernels.h, for the instruction set that the including file defines.
 *
 * bn_i32v holds BN_I32_LANES 32-bit integers, whose sums wrap. Loads and stores are aligned, except
 * for i32_load_any. i32_equal_bits returns one bit per lane; i32_lowest, i32_highest and i32_sum reduce
 * all lanes.
 *
 * bn_i16x16 holds 16 values. i16_multiply_add adds the products of all lanes to 8 sums, in any order;
 * i16_multiply_upper computes (a b + 2^14) >> 15. */
#ifndef BN_SIMD_VEC_H
#define BN_SIMD_VEC_H

#include <stddef.h>
#include <stdint.h>

#define BN_I32_LANES 8

static inline uint32_t first_bit(uint64_t bits) {
#if defined(__GNUC__)
    return (uint32_t)__builtin_ctzll(bits);
#else
    uint32_t i = 0;
    while (i < 63 && !(bits >> i & 1)) ++i;
    return i;
#endif
}

#if defined(BN_SIMD_AVX2)
#include "simd/vec_avx2.h"
#elif defined(BN_SIMD_NEON)
#include "simd/vec_neon.h"
#else
#include "simd/vec_scalar.h"
#endif
#undef BN_BINARY

#endif
