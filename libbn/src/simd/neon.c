/* SPDX-License-Identifier: Apache-2.0
 * The inner loops for NEON (64-bit Arm). */
#define BN_SIMD_NEON 1
#include "simd/kernels.h"
