/* SPDX-License-Identifier: Apache-2.0
 * The inner loops for AVX2. */
#define BN_SIMD_AVX2 1
#include "simd/kernels.h"
