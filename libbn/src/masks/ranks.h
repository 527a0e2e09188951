/* SPDX-License-Identifier: Apache-2.0
 * Ranks of values, made by several threads. */
#ifndef BN_RANKS_H
#define BN_RANKS_H

#include <bn/bn.h>

/* bn_ranks_from_values() on up to `threads` threads, at least 1: fewer if there are few values. The
 * ranks do not depend on the number of threads. */
bn_result bn_ranks_on_threads(const float *values, size_t count, uint32_t threads, uint32_t *ranks);

#endif
