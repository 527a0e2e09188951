/* SPDX-License-Identifier: Apache-2.0
 * Blocks of samples for AVX-512, whose three-operand logic and 32 registers serve vectors of eight
 * as well. */
#define BN_BLOCK_RUNS bn_block_runs_avx512
#include "sampler_block.h"
