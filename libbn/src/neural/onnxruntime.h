/* SPDX-License-Identifier: Apache-2.0
 * A model in ONNX Runtime, which is loaded dynamically. */
#ifndef BN_ONNXRUNTIME_H
#define BN_ONNXRUNTIME_H

#include <bn/bn.h>

typedef struct bn_runtime bn_runtime;

/* An execution provider of ONNX Runtime. */
typedef enum bn_provider { BN_PROVIDER_CPU, BN_PROVIDER_CUDA } bn_provider;

/* Loads ONNX Runtime from library_path (NULL: searches as bn_neural_open describes) and opens the model,
 * whose bytes need not outlive the call. Errors: RUNTIME (no usable runtime, no such provider, or no device
 * that can run the whole model), BAD_DATA (the runtime rejects the model), OUT_OF_MEMORY, UNSUPPORTED (this
 * system cannot load libraries). */
bn_result bn_runtime_open(const char *library_path, bn_provider provider, const void *model,
                          size_t size, bn_runtime **runtime);
void bn_runtime_close(bn_runtime *runtime);

/* The longest metadata entry or name, including the terminating zero. */
enum { BN_RUNTIME_TEXT_SIZE = 1024 };

/* Reads an entry of the model's metadata, or an empty string if there is none. Errors: BAD_DATA (too
 * long), RUNTIME. */
bn_result bn_runtime_metadata(const bn_runtime *runtime, const char *key,
                              char text[BN_RUNTIME_TEXT_SIZE]);

typedef enum bn_runtime_side { BN_RUNTIME_INPUT, BN_RUNTIME_OUTPUT } bn_runtime_side;

/* Reads the name and the channel count of the model's only input or output. Errors: BAD_DATA (there
 * is not exactly one, or it is not a float tensor (1, C, h, w) with fixed, positive C), RUNTIME. */
bn_result bn_runtime_value(const bn_runtime *runtime, bn_runtime_side side,
                           char name[BN_RUNTIME_TEXT_SIZE], uint32_t *channels);

/* A tensor of shape (1, channels, height, width). */
typedef struct bn_tensor {
    float *values;
    uint32_t channels, height, width;
} bn_tensor;

/* Runs the model on the calling thread only; several threads may call it at once. Errors: RUNTIME, also if
 * the shape of the model's output differs from `output`. */
bn_result bn_runtime_run(const bn_runtime *runtime, const bn_tensor *input, const char *output_name,
                         const bn_tensor *output);

#endif
