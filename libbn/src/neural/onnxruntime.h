/* SPDX-License-Identifier: Apache-2.0
 * A model in ONNX Runtime, which is itself loaded at run time. */
#ifndef BN_ONNXRUNTIME_H
#define BN_ONNXRUNTIME_H

#include <bn/bn.h>

typedef struct bn_runtime bn_runtime;

/* What the model runs on: an execution provider of ONNX Runtime. */
typedef enum bn_provider { BN_PROVIDER_CPU, BN_PROVIDER_CUDA } bn_provider;

/* Loads ONNX Runtime from library_path (NULL: searches as bn_neural_open describes) and opens the
 * model, whose bytes are not kept. Errors: RUNTIME (no runtime, or one that cannot be used or lacks the
 * provider; no device for it, or one that cannot run all of the model), BAD_DATA (it rejects the
 * model), OUT_OF_MEMORY, UNSUPPORTED (this system cannot load libraries). */
bn_result bn_runtime_open(const char *library_path, bn_provider provider, const void *model,
                          size_t size, bn_runtime **runtime);
void bn_runtime_close(bn_runtime *runtime);

/* A tensor of shape (1, channels, height, width). */
typedef struct bn_tensor {
    float *values;
    uint32_t channels, height, width;
} bn_tensor;

/* Runs the model on the calling thread alone; several threads may call it at once. Errors: RUNTIME,
 * also if the model's output has another shape than `output`. */
bn_result bn_runtime_run(const bn_runtime *runtime, const bn_tensor *input, const char *output_name,
                         const bn_tensor *output);

#endif
