/* SPDX-License-Identifier: Apache-2.0
 * Metadata of a model, in the format that bn_neural_open describes. */
#ifndef BN_MODEL_H
#define BN_MODEL_H

#include "neural/onnxruntime.h"

enum {
    BN_MODEL_MOST_RADIUS = 256,
    BN_MODEL_MOST_ALIGN = 64,
    BN_MODEL_MOST_CHANNELS = 16,
    BN_MODEL_MOST_SPACING = 100 * 100,
    BN_MODEL_QUANTILES = 65
};
#define BN_MODEL_MOST_BYTES ((size_t)64 << 20)

typedef struct bn_model {
    uint32_t radius; /* texels of noise around the output on every side */
    uint32_t align;  /* positions and extents are multiples of this */
    uint32_t channels;
    char output[BN_RUNTIME_TEXT_SIZE]; /* name of the output, zero-terminated */
    uint32_t sparse_spacing;           /* for masks, in hundredths of a texel; 0: none */
    int has_quantiles;
    float quantiles[BN_MODEL_QUANTILES]; /* entry i: i/64 of the outputs lie below it */
} bn_model;

/* Reads metadata and shapes through ONNX Runtime. Errors: BAD_DATA (not in this format),
 * UNSUPPORTED (another format version), RUNTIME. */
bn_result bn_model_read(const bn_runtime *runtime, bn_model *model);

#endif
