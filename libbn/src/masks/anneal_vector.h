/* SPDX-License-Identifier: Apache-2.0
 * Annealing of two to four channels. */
#ifndef BN_ANNEAL_VECTOR_H
#define BN_ANNEAL_VECTOR_H

#include "masks/anneal_job.h"

/* Improves the ranks of a job. Errors: OUT_OF_MEMORY, CANCELLED. */
bn_result bn_anneal_vector(bn_anneal_job *job);

#endif
