/* SPDX-License-Identifier: Apache-2.0
 * What a network runs on: the names of providers, CUDA in the fake ONNX Runtime, with and without a
 * GPU, and in the real one. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <math.h>
#include <stddef.h>

static void test_names(void) {
    static const char *const unknown[] = {"", "CUDA", "cuda ", "gpu", "CPUExecutionProvider"};
    model_parts parts = model_parts_default();
    bn_neural *neural;
    fake_state *state = fake_reset();
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; ++i) {
        neural = (bn_neural *)&parts;
        CHECK(open_on(unknown[i], &parts, FAKE_RUNTIME, 1, &neural) == BN_ERROR_INVALID_ARGUMENT);
        CHECK(neural == NULL);
    }
    CHECK(open_on("cpu", &parts, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
    CHECK(state->runs > 0 && state->cuda_runs == 0);
    bn_neural_close(neural);
}

/* Everything runs in sessions that cannot leave the GPU, in fewer tiles, with the same values. */
static void test_cuda(void) {
    enum { width = 700, height = 450, count = width * height };
    static float values[2][count];
    model_parts parts = model_parts_default();
    fake_state *state = fake_reset();
    for (int lacks_tf32 = 0; lacks_tf32 < 2; ++lacks_tf32) {
        int runs[2];
        for (int cuda = 0; cuda < 2; ++cuda) {
            bn_neural *neural;
            fake_reset();
            state->lacks_tf32 = lacks_tf32;
            CHECK(open_on(cuda ? "cuda" : NULL, &parts, FAKE_RUNTIME, 3, &neural) == BN_SUCCESS);
            CHECK(state->fallbacks == 0 && state->rough == 0);
            const int before = state->runs;
            CHECK(bn_neural_window(neural, -5, 9, width, height, 4, values[cuda], count) ==
                  BN_SUCCESS);
            CHECK(state->cuda_runs == (cuda ? state->runs : 0));
            runs[cuda] = state->runs - before;
            bn_neural_close(neural);
            CHECK(state->living == 0);
        }
        CHECK(runs[0] > 1 && runs[1] == 1);
        CHECK(memcmp(values[0], values[1], sizeof values[0]) == 0);
    }
}

/* A model that holds more per texel gets smaller tiles. */
static void test_memory(void) {
    enum { extent = 1100, count = extent * extent };
    static float values[count];
    for (uint32_t spare = 0; spare <= 80; spare += 80) {
        model_parts parts = model_parts_default();
        parts.spare_outputs = spare;
        bn_neural *neural;
        fake_state *state = fake_reset();
        CHECK(open_on("cuda", &parts, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
        const int before = state->runs;
        CHECK(bn_neural_window(neural, 0, 0, extent, extent, 1, values, count) == BN_SUCCESS);
        CHECK((state->runs - before == 1) == (spare == 0));
        bn_neural_close(neural);
    }
}

/* Without CUDA or without a GPU: an error. Whether the model is to blame, the status tells. */
static void test_nothing_to_run_on(void) {
    model_parts parts = model_parts_default();
    bn_neural *neural;
    for (int code = 0; code <= 11; ++code) {
        const int blames_model = code == 7 || code == 9 || code == 10;
        fake_state *state = fake_reset();
        state->error_code = code;
        state->lacks_cuda = code == 0;
        state->lacks_gpu = code != 0;
        CHECK(open_on("cuda", &parts, FAKE_RUNTIME, 1, &neural) ==
              (blames_model ? BN_ERROR_BAD_DATA : BN_ERROR_RUNTIME));
        CHECK(neural == NULL && state->living == 0 && state->runs == 0);
        CHECK(open_on("cpu", &parts, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
        bn_neural_close(neural);
    }
    fake_reset();
}

/* Where there is a GPU, its values are those of the processor but for rounding. Whatever there is,
 * nothing is printed. */
static void test_real_runtime(const char *runtime) {
    enum { extent = 300, count = extent * extent };
    static float plain[count], values[count];
    model_parts parts = model_parts_default();
    bn_neural *neural;
    for (int named = 0; named < 2; ++named) {
        CHECK(open_on(named ? "cpu" : NULL, &parts, runtime, 1, &neural) == BN_SUCCESS);
        CHECK(bn_neural_window(neural, 1, 2, extent, extent, 3, named ? values : plain, count) ==
              BN_SUCCESS);
        bn_neural_close(neural);
    }
    CHECK(memcmp(plain, values, sizeof plain) == 0);
    char library[4096];
    const char *slash = strrchr(runtime, '/');
    snprintf(library, sizeof library, "%.*s/libonnxruntime_providers_cuda.so",
             slash != NULL ? (int)(slash - runtime) : 1, slash != NULL ? runtime : ".");
    const bn_result result = open_on("cuda", &parts, runtime, 1, &neural);
    CHECK(result == BN_ERROR_RUNTIME || (result == BN_SUCCESS && access(library, F_OK) == 0));
    if (result != BN_SUCCESS) return;
    CHECK(bn_neural_window(neural, 1, 2, extent, extent, 3, values, count) == BN_SUCCESS);
    for (int i = 0; i < count; ++i) CHECK(fabsf(values[i] - plain[i]) < 1e-5f);
    bn_neural_close(neural);
}

int main(void) {
    test_names();
    test_cuda();
    test_memory();
    test_nothing_to_run_on();
    with_real_runtime(test_real_runtime);
    return check_result();
}
