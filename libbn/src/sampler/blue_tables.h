/* SPDX-License-Identifier: Apache-2.0
 * The tables that the draws of bn_draw.h read. */
#ifndef BN_BLUE_TABLES_H
#define BN_BLUE_TABLES_H

#include "sampler/sampler_object.h"

/* Fills `table` and `words` of a zero-initialised sampler. */
void bn_blue_tables_fill(bn_sampler *sampler, int32_t kind, uint64_t seed_key);

#endif
