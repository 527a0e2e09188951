/* SPDX-License-Identifier: Apache-2.0
 * Bounds what a model would allocate, before it runs. */
#ifndef BN_ONNX_MEMORY_H
#define BN_ONNX_MEMORY_H

#include <bn/bn.h>

/* The most elements, of up to eight bytes, that a model may hold at once on a processor. */
static const double BN_MODEL_MOST_ELEMENTS = 1 << 26;

/* Checks the graph of a model that bn_onnx_model_read() has accepted, for an input of `side` texels
 * each way and `most` elements at once. Errors: UNSUPPORTED (too large, or an operator whose results
 * cannot be bounded), BAD_DATA (an operator uses a value that no earlier one computes),
 * OUT_OF_MEMORY. */
bn_result bn_onnx_memory_check(const void *bytes, size_t size, uint32_t side, double most);

#endif
