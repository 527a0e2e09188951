/* SPDX-License-Identifier: Apache-2.0
 * Shared by the tests of networks: the fake runtimes built beside them, the real one, and opening a
 * model in one. */
#ifndef BN_TESTS_NEURAL_H
#define BN_TESTS_NEURAL_H

#include "check.h"
#include "fake_onnxruntime.h"
#include "onnx_writer.h"
#include <bn/neural.h>
#include <dlfcn.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

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
    return state;
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

/* A path to ONNX Runtime: BN_TEST_ONNXRUNTIME, or that of the repository's Python environment. */
static inline const char *real_runtime(glob_t *found) {
    const char *given = getenv("BN_TEST_ONNXRUNTIME");
    if (given != NULL && *given != 0) return given;
    const char *pattern =
        BN_SOURCE_DIR "/.venv/lib*/python3*/site-packages/onnxruntime/capi/libonnxruntime.so*";
    return glob(pattern, 0, NULL, found) == 0 && found->gl_pathc > 0 ? found->gl_pathv[0] : NULL;
}

/* Redirects everything that the process prints to a temporary file. Returns the descriptor of the
 * real standard output. */
static inline int begin_silence(void) {
    FILE *file = tmpfile();
    fflush(stdout);
    const int kept = dup(STDOUT_FILENO);
    dup2(fileno(file), STDOUT_FILENO);
    dup2(fileno(file), STDERR_FILENO);
    return kept;
}

/* Restores standard output, copies to it what was printed, and returns the number of bytes. */
static inline long end_silence(int kept) {
    char text[4096];
    fflush(stdout);
    const int file = dup(STDOUT_FILENO);
    dup2(kept, STDOUT_FILENO);
    dup2(kept, STDERR_FILENO);
    close(kept);
    const long printed = (long)lseek(file, 0, SEEK_END);
    lseek(file, 0, SEEK_SET);
    for (ssize_t got; (got = read(file, text, sizeof text)) > 0;) {
        fwrite(text, 1, (size_t)got, stdout);
    }
    close(file);
    return printed;
}

/* Runs a test with the real runtime where there is one. Nothing may be printed meanwhile. */
static inline void with_real_runtime(void (*test)(const char *runtime)) {
    glob_t found = {0};
    const char *runtime = real_runtime(&found);
    if (runtime != NULL) {
        const int silence = begin_silence();
        test(runtime);
        const long printed = end_silence(silence);
        CHECK(check_failures > 0 || printed == 0);
    } else {
        printf("no ONNX Runtime at hand: its part is left out (set BN_TEST_ONNXRUNTIME)\n");
    }
    globfree(&found);
}

#endif
