/* SPDX-License-Identifier: Apache-2.0
 * The inner loops for AVX2. */
#define BN_SIMD_AVX2 1
/* GCC does not align these vectors on the stack on 64-bit Windows (GCC bug 54412). */
#if !defined(_WIN32) || defined(__clang__)
#include "simd/draws.h"
#endif
#include "simd/kernels.h"
