/* SPDX-License-Identifier: Apache-2.0
 * The inner loops in plain C. */
#define BN_SIMD_SCALAR 1
#include "simd/kernels.h"
