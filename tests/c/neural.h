/* SPDX-License-Identifier: Apache-2.0
 * Shared by the network tests. Locates the fake runtime, which is built next to them, and opens models
 * in it. */
#ifndef BN_TESTS_NEURAL_H
#define BN_TESTS_NEURAL_H

#include "check.h"
#include "fake_onnxruntime.h"
#include <bn/neural.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FAKE_RUNTIME BN_FAKE_DIR "/libfake_onnxruntime.so"

/* The state of a fake runtime. Its library stays loaded. */
static inline fake_state *fake_state_of(const char *library) {
    void *handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    void *symbol = handle != NULL ? dlsym(handle, "fake_get_state") : NULL;
    fake_state_getter getter;
    memcpy(&getter, &symbol, sizeof getter);
    return getter();
}

static inline fake_state *fake_reset(void) {
    fake_state *const state = fake_state_of(FAKE_RUNTIME);
    const int living = state->living;
    memset(state, 0, sizeof *state);
    state->living = living;
    state->spinning = 1; /* as ONNX Runtime's threads do */
    return state;
}

static const fake_model plain = {.radius = 1, .align = 1, .channels = 1};

/* Options for opening a model in the fake runtime. */
static inline bn_neural_options fake_options(const fake_model *model) {
    bn_neural_options options = bn_neural_options_default();
    options.model = model;
    options.model_size = sizeof *model;
    options.runtime_path = FAKE_RUNTIME;
    options.threads = 1;
    return options;
}

static inline bn_result open_model(const fake_model *model, const char *provider,
                                   const char *runtime, uint32_t threads, bn_neural **neural) {
    bn_neural_options options = fake_options(model);
    options.runtime_path = runtime;
    options.threads = threads;
    options.provider = provider;
    return bn_neural_open(&options, neural);
}

#endif
