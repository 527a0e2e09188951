/* SPDX-License-Identifier: Apache-2.0
 * Annealing of one channel. */
#ifndef BN_ANNEAL_SCALAR_H
#define BN_ANNEAL_SCALAR_H

#include "masks/anneal_job.h"

/* Improves the ranks of a job. Errors: OUT_OF_MEMORY, CANCELLED. */
bn_result bn_anneal_scalar(bn_anneal_job *job);

#endif
