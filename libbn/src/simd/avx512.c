/* SPDX-License-Identifier: Apache-2.0
 * The inner loops for AVX-512 (F, BW, DQ, VL). */
#define BN_SIMD_AVX512 1
#include "simd/kernels.h"
