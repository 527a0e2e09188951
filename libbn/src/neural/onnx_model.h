/* SPDX-License-Identifier: Apache-2.0
 * What the library reads from a model before ONNX Runtime sees it. */
#ifndef BN_ONNX_MODEL_H
#define BN_ONNX_MODEL_H

#include <bn/bn.h>

enum {
    BN_MODEL_MOST_RADIUS = 256,
    BN_MODEL_MOST_ALIGN = 64,
    BN_MODEL_MOST_CHANNELS = 16,
    BN_MODEL_MOST_NODES = 65536,
    BN_MODEL_MOST_SPACING = 100 * 100,
    BN_MODEL_NAME_SIZE = 128,
    BN_MODEL_QUANTILES = 65
};
#define BN_MODEL_MOST_BYTES ((size_t)64 << 20)

typedef struct bn_onnx_model {
    uint32_t radius; /* texels of noise around the output on every side */
    uint32_t align;  /* positions and extents are multiples of this */
    uint32_t channels;
    char output[BN_MODEL_NAME_SIZE]; /* name of the output, zero-terminated */
    uint32_t sparse_spacing;         /* of masks, in hundredths of a texel; 0 for none */
    int has_quantiles;
    float quantiles[BN_MODEL_QUANTILES]; /* entry i: i/64 of the outputs lie below it */
} bn_onnx_model;

/* Reads the bytes of a model file. Errors: BAD_DATA (not in the format that bn_neural_open
 * describes), UNSUPPORTED (another version of it; external data, operators outside the ONNX
 * standard, functions or control flow). */
bn_result bn_onnx_model_read(const void *bytes, size_t size, bn_onnx_model *model);

#endif
