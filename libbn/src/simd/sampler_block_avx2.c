/* SPDX-License-Identifier: Apache-2.0
 * Blocks of samples for AVX2. */
#define BN_BLOCK_RUNS bn_block_runs_avx2
#include "sampler_block.h"
