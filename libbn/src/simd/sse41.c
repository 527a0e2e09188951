/* SPDX-License-Identifier: Apache-2.0
 * The inner loops for SSE4.1. */
#define BN_SIMD_SSE41 1
#include "simd/kernels.h"
