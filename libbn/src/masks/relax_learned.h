/* SPDX-License-Identifier: Apache-2.0
 * Relaxation by the learned schedule: bn_relax() with 0 steps. */
#ifndef BN_RELAX_LEARNED_H
#define BN_RELAX_LEARNED_H

#include <bn/bn.h>

enum { BN_RELAX_MOST_THREADS = 64 };

/* Writes the ranks of width x height texels, whose ends bn_eliminate_ends() has yet to order. Of the
 * options it reads the seed and progress. Errors: OUT_OF_MEMORY, CANCELLED. */
bn_result bn_relax_learned(const bn_relax_options *options, uint32_t threads, uint32_t width,
                           uint32_t height, uint32_t *ranks);

#endif
