/* SPDX-License-Identifier: Apache-2.0
 * Fuzzes the readers of model files: they must not read beyond the bytes they are given, and what
 * they accept must be in range. */
#include "neural/onnx_memory.h"
#include "neural/onnx_model.h"
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

extern bool fuzz_input_was_read;
bool fuzz_input_was_read;

static void require(int condition, const char *what) {
    if (condition) return;
    fprintf(stderr, "fuzz_onnx_model: %s\n", what);
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    bn_onnx_model model;
    memset(&model, 0x5a, sizeof model);
    const bn_onnx_model before = model;
    const bn_result result = bn_onnx_model_read(bytes, size, &model);
    if (result == BN_SUCCESS) {
        fuzz_input_was_read = true;
        require(model.radius <= BN_MODEL_MOST_RADIUS, "radius");
        require(model.align >= 1 && model.align <= BN_MODEL_MOST_ALIGN, "align");
        require(model.channels >= 1 && model.channels <= BN_MODEL_MOST_CHANNELS, "channels");
        require(memchr(model.output, 0, sizeof model.output) != NULL, "output name");
        const bn_result memory =
            bn_onnx_memory_check(bytes, size, 256 + 2 * model.radius, BN_MODEL_MOST_ELEMENTS);
        require(memory == BN_SUCCESS || memory == BN_ERROR_BAD_DATA ||
                    memory == BN_ERROR_UNSUPPORTED,
                "result of the memory check");
    } else {
        require(result == BN_ERROR_BAD_DATA || result == BN_ERROR_UNSUPPORTED, "result");
        require(memcmp(&model, &before, sizeof model) == 0, "a failure wrote");
    }
    return 0;
}
