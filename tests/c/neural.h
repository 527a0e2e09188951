/* SPDX-License-Identifier: Apache-2.0
 * Shared by the tests of networks: the fake runtime that is built beside them, and opening a model in
 * it. */
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

/* Resets the state of the fake runtime, whose library stays loaded. */
static inline fake_state *fake_reset(void) {
    static fake_state *state;
    if (state == NULL) {
        void *handle = dlopen(FAKE_RUNTIME, RTLD_NOW | RTLD_LOCAL);
        void *symbol = handle != NULL ? dlsym(handle, "fake_get_state") : NULL;
        fake_state_getter getter;
        memcpy(&getter, &symbol, sizeof getter);
        state = getter();
    }
    const int living = state->living;
    memset(state, 0, sizeof *state);
    state->living = living;
    state->spinning = 1; /* as threads of ONNX Runtime do */
    return state;
}

/* A model of the fake runtime: lines of a key, an equals sign and a value, of which the first counts. */
typedef struct message {
    char bytes[4096];
    size_t size;
} message;

/* What a model is made of; start from model_parts_default(). */
typedef struct model_parts {
    const char *radius, *align, *spacing; /* of the metadata; NULL leaves the entry out */
    uint32_t channels;
    const char *first; /* lines that come before all others */
} model_parts;

static inline model_parts model_parts_default(void) {
    return (model_parts){.radius = "1", .align = "1", .channels = 1, .first = ""};
}

static inline void make_model(const model_parts *parts, message *model) {
    char spacing[64] = "";
    if (parts->spacing != NULL) {
        snprintf(spacing, sizeof spacing, "bn.sparse_spacing=%s\n", parts->spacing);
    }
    model->size = (size_t)snprintf(
        model->bytes, sizeof model->bytes,
        "%s\nbn.version=1\nbn.receptive_radius=%s\nbn.align=%s\n%sinputs=1\noutputs=1\n"
        "input=noise\noutput=mask\naxes=4\nelement=1\nbatch=1\nin_channels=1\nout_channels=%u\n",
        parts->first, parts->radius, parts->align, spacing, (unsigned)parts->channels);
}

/* Options for a model in the fake runtime. */
static inline bn_neural_options fake_options(const message *model) {
    bn_neural_options options = bn_neural_options_default();
    options.model = model->bytes;
    options.model_size = model->size;
    options.runtime_path = FAKE_RUNTIME;
    options.threads = 1;
    return options;
}

static inline bn_result open_on(const char *provider, const model_parts *parts, const char *runtime,
                                uint32_t threads, bn_neural **neural) {
    message model;
    make_model(parts, &model);
    bn_neural_options options = fake_options(&model);
    options.runtime_path = runtime;
    options.threads = threads;
    options.provider = provider;
    return bn_neural_open(&options, neural);
}

static inline bn_result open_parts(const model_parts *parts, const char *runtime, uint32_t threads,
                                   bn_neural **neural) {
    return open_on(NULL, parts, runtime, threads, neural);
}

#endif
