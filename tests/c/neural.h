/* SPDX-License-Identifier: Apache-2.0
 * What the tests of networks share: the libraries built beside them, and opening a model in one. */
#ifndef BN_TESTS_NEURAL_H
#define BN_TESTS_NEURAL_H

#include "fake_onnxruntime.h"
#include "onnx_writer.h"
#include <bn/bn.h>
#include <dlfcn.h>

/* The stand-in's levers, at rest; its library stays loaded. */
static inline fake_state *fake_reset(void) {
    static fake_state *state;
    if (state == NULL) {
        void *handle = dlopen(BN_FAKE_DIR "/libfake_onnxruntime.so", RTLD_NOW | RTLD_LOCAL);
        void *symbol = handle != NULL ? dlsym(handle, "fake_get_state") : NULL;
        fake_state_getter getter;
        memcpy(&getter, &symbol, sizeof getter);
        state = getter();
    }
    const int living = state->living;
    memset(state, 0, sizeof *state);
    state->living = living;
    return state;
}

static inline bn_result open_parts(const model_parts *parts, const char *runtime, uint32_t threads,
                                   bn_neural **neural) {
    message model;
    make_model(parts, &model);
    bn_neural_options options = bn_neural_options_default();
    options.model = model.bytes;
    options.model_size = model.size;
    options.runtime_path = runtime;
    options.threads = threads;
    return bn_neural_open(&options, neural);
}

#define FAKE_RUNTIME BN_FAKE_DIR "/libfake_onnxruntime.so"

#endif
