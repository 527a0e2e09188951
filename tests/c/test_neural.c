/* SPDX-License-Identifier: Apache-2.0
 * Neural masks and windows, computed in a fake ONNX Runtime: noise, tiles, wrapping, threads, CUDA,
 * failing calls and unusable libraries. tests/python uses the real runtime and also tests the metadata of
 * models. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "masks.h"
#include "neural.h"
#include <math.h>
#include <pthread.h>
#include <stdio.h>

static const int64_t FARTHEST = (int64_t)1 << 40;

static bn_result mask_of(const bn_neural *neural, uint32_t width, uint32_t height, uint64_t seed,
                         uint32_t *ranks) {
    bn_mask mask = bn_mask_u32(ranks, width, height);
    if (neural != NULL) mask.channels = bn_neural_channels(neural);
    return bn_neural_mask(neural, &mask, seed, NULL, NULL);
}

static bn_result window_of(const bn_neural *neural, int64_t x0, int64_t y0, uint32_t width,
                           uint32_t height, uint64_t seed, float *values, size_t count) {
    return bn_neural_window(neural, x0, y0, width, height, seed, values, count, NULL, NULL);
}

/* ---- Noise */

static float noise_of(int64_t x, int64_t y, uint64_t seed) {
    float noise = -1;
    CHECK(bn_neural_noise(x, y, 1, 1, seed, &noise, 1) == BN_SUCCESS);
    return noise;
}

static void test_noise(void) {
    enum { width = 300, height = 200, count = width * height };
    float *noise = malloc(count * sizeof *noise);
    CHECK(bn_neural_noise(-7, 5, width, height, 3, noise, count) == BN_SUCCESS);
    for (int i = 0; i < count; ++i)
        CHECK(noise[i] >= 0 && noise[i] < 1 && noise[i] * 0x1p24f == floorf(noise[i] * 0x1p24f));
    CHECK(noise[2 * width + 9] == noise_of(2, 7, 3));
    /* The noise is the same on every machine. The trainer relies on this. */
    CHECK(noise_of(0, 0, 0) == 0x1p-24f * 3407499);
    CHECK(noise_of(-1, 1, 7) == 0x1p-24f * 2805431);
    CHECK(noise_of(-FARTHEST, FARTHEST - 1, UINT64_MAX) == 0x1p-24f * 11651764);
    CHECK(bn_neural_noise(0, 0, 2, 2, 0, NULL, 4) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(0, 0, 0, 2, 0, noise, 0) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(0, 0, 2, 0, 0, noise, 0) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(2 * FARTHEST - 1, 0, 2, 2, 0, noise, 4) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(0, -2 * FARTHEST - 1, 2, 2, 0, noise, 4) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(0, INT64_MIN, 2, 2, 0, noise, 4) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(INT64_MAX, 0, 2, 2, 0, noise, 4) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_neural_noise(0, 0, 2, 2, 0, noise, 5) == BN_ERROR_SIZE_MISMATCH);
    CHECK(noise[0] == noise_of(-7, 5, 3));
    free(noise);
}

/* ---- Tiles */

static int64_t wrapped(int64_t v, uint32_t period) {
    const int64_t remainder = v % (int64_t)period;
    return remainder < 0 ? remainder + period : remainder;
}

/* The expected output of the fake network at a texel. If an extent is 0, the noise does not wrap. */
static float expected_at(uint32_t channel, int64_t x, int64_t y, int64_t radius, uint64_t seed,
                         uint32_t width, uint32_t height) {
    float corner[3];
    for (int i = 0; i < 3; ++i) {
        const int64_t px = x + (i - 1) * radius, py = y + (i - 1) * radius;
        corner[i] = noise_of(width == 0 ? px : wrapped(px, width),
                             height == 0 ? py : wrapped(py, height), seed);
    }
    return fake_network(channel, corner[0], corner[1], corner[2]);
}

static void test_windows(void) {
    static const struct {
        int64_t x0, y0;
        uint32_t width, height;
    } windows[] = {{0, 0, 1, 1},
                   {-3, 2, 17, 5},
                   {1000, -77, 300, 310},
                   {5, -2000, 1, 900},
                   {-1, -1, 900, 2},
                   {-77, 41, 509, 767},
                   {-((int64_t)1 << 40), 0, 33, 64},
                   {((int64_t)1 << 40) - 40, -((int64_t)1 << 40), 40, 3}};
    static const fake_model models[] = {{1, 1, 0, 1}, {9, 1, 0, 2}, {0, 4, 0, 1}, {24, 3, 0, 3}};
    for (size_t m = 0; m < sizeof models / sizeof *models; ++m) {
        for (uint32_t threads = 1; threads <= 4; threads += 3) {
            bn_neural *neural;
            CHECK(open_model(&models[m], NULL, FAKE_RUNTIME, threads, &neural) == BN_SUCCESS);
            CHECK(bn_neural_channels(neural) == models[m].channels);
            for (size_t w = 0; w < sizeof windows / sizeof *windows; ++w) {
                const uint32_t width = windows[w].width, height = windows[w].height;
                const size_t count = (size_t)width * height * models[m].channels;
                float *values = malloc(count * sizeof *values);
                CHECK(window_of(neural, windows[w].x0, windows[w].y0, width, height, w, values,
                                count) == BN_SUCCESS);
                for (size_t i = 0; i<count; i += count> 5000 ? 97 : 1) {
                    const uint32_t c = (uint32_t)(i / width / height);
                    const int64_t x = windows[w].x0 + (int64_t)(i % width);
                    const int64_t y = windows[w].y0 + (int64_t)(i / width % height);
                    CHECK(values[i] == expected_at(c, x, y, models[m].radius, w, 0, 0));
                }
                free(values);
            }
            bn_neural_close(neural);
        }
    }
}

/* With a sparse spacing of s texels, the first and last count / s^2 ranks of each channel are reordered.
 * All other ranks stay the same. */
static void test_sparse_spacing(void) {
    enum { extent = 64, count = extent * extent, points = count / 16 };
    static uint32_t ranks[4][2 * count];
    static const int spacings[4] = {0, 10000, 400, 400}; /* 10000 is too sparse for this mask */
    for (int i = 0; i < 4; ++i) {
        const fake_model model = {.align = 1, .radius = 1, .spacing = spacings[i], .channels = 2};
        bn_neural *neural;
        CHECK(open_model(&model, NULL, FAKE_RUNTIME, (uint32_t)(i == 3 ? 3 : 1), &neural) ==
              BN_SUCCESS);
        CHECK(mask_of(neural, extent, extent, 5, ranks[i]) == BN_SUCCESS);
        bn_neural_close(neural);
    }
    CHECK(memcmp(ranks[0], ranks[1], sizeof ranks[0]) == 0);
    CHECK(memcmp(ranks[2], ranks[3], sizeof ranks[2]) == 0);
    int moved = 0;
    for (int i = 0; i < 2 * count; ++i) {
        const uint32_t before = ranks[0][i], after = ranks[2][i];
        const int first = before < points, last = before >= count - points;
        CHECK(first == (after < points) && last == (after >= count - points));
        CHECK(first || last || before == after);
        moved += before != after;
    }
    CHECK(moved > 2 * points);
}

static void test_masks(void) {
    static const uint32_t extents[][2] = {{1, 1},   {2, 3},    {5, 1},    {16, 16},
                                          {33, 20}, {301, 99}, {190, 700}};
    const fake_model model = {.radius = 7, .align = 1, .channels = 2};
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        bn_neural *neural;
        CHECK(open_model(&model, NULL, FAKE_RUNTIME, threads, &neural) == BN_SUCCESS);
        for (size_t e = 0; e < sizeof extents / sizeof *extents; ++e) {
            const uint32_t width = extents[e][0], height = extents[e][1];
            const size_t texels = (size_t)width * height;
            uint32_t *ranks = malloc(2 * texels * sizeof *ranks);
            uint32_t *expected = malloc(texels * sizeof *expected);
            float *values = malloc(texels * sizeof *values);
            CHECK(mask_of(neural, width, height, e, ranks) == BN_SUCCESS);
            for (uint32_t c = 0; c < 2; ++c) {
                for (size_t i = 0; i < texels; ++i) {
                    values[i] = expected_at(c, (int64_t)(i % width), (int64_t)(i / width), 7, e,
                                            width, height);
                }
                CHECK(bn_ranks_from_values(values, texels, expected) == BN_SUCCESS);
                CHECK(memcmp(ranks + c * texels, expected, texels * sizeof *ranks) == 0);
                CHECK(is_permutation(ranks + c * texels, texels));
            }
            free(ranks);
            free(expected);
            free(values);
        }
        bn_neural_close(neural);
    }
}

static void test_threads_are_used(void) {
    enum { extent = 300, count = extent * extent };
    static uint32_t ranks[count];
    bn_neural *neural;
    fake_state *state = fake_reset();
    CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 2, &neural) == BN_SUCCESS);
    CHECK(state->telemetry_disabled == 0); /* because this program had already loaded the runtime */
    CHECK(state->spinning == 0 && state->log_level == 4 && state->asked_version == 21);
    state->most_running = 0;
    state->meet = 1;
    CHECK(mask_of(neural, extent, extent, 0, ranks) == BN_SUCCESS);
    CHECK(state->most_running == 2);
    bn_neural_close(neural);
    CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
    state->most_running = state->meet = 0;
    CHECK(mask_of(neural, extent, extent, 0, ranks) == BN_SUCCESS);
    CHECK(state->most_running == 1 && state->runs > 2);
    bn_neural_close(neural);
    CHECK(state->living == 0);
}

/* ---- Progress */

typedef struct watcher {
    pthread_t thread;
    int calls, stop_at, bad; /* stop_at: the call that cancels; 0: none */
    double last;
} watcher;

static int32_t watch_thread(void *user, double fraction) {
    watcher *w = user;
    w->bad += !pthread_equal(w->thread, pthread_self()) || !(fraction >= w->last && fraction <= 1);
    w->last = fraction;
    return ++w->calls == w->stop_at;
}

/* Cancelling stops a mask or window. Other threads finish the tiles they have begun. */
static void test_progress(void) {
    enum { width = 1100, height = 900, count = width * height };
    static uint32_t ranks[count];
    static float values[count];
    static const int stops[] = {0, 1, 2};
    const bn_mask mask = bn_mask_u32(ranks, width, height);
    for (int run = 0; run < 3 * 2 * 2; ++run) {
        const int stop_at = stops[run % 3], threads = run / 3 % 2 * 2 + 1, window = run / 6;
        watcher w = {pthread_self(), 0, stop_at, 0, 0};
        bn_neural_options options = fake_options(&plain);
        options.threads = (uint32_t)threads;
        fake_state *state = fake_reset();
        bn_neural *neural;
        CHECK(bn_neural_open(&options, &neural) == BN_SUCCESS && w.calls == 0);
        state->runs = 0;
        memset(ranks, 0x5a, sizeof ranks);
        const bn_result result = window ? bn_neural_window(neural, 5, 6, width, height, 1, values,
                                                           count, watch_thread, &w)
                                        : bn_neural_mask(neural, &mask, 1, watch_thread, &w);
        /* Other threads may finish everything before the calling thread reports progress again. */
        const int stopped = stop_at > 0 && w.calls == stop_at;
        CHECK(result == (stopped ? BN_ERROR_CANCELLED : BN_SUCCESS) && w.bad == 0);
        CHECK(stop_at == 0 ? state->runs >= 12 && (threads > 1 || w.last > 0)
                           : stop_at > 1 || stopped);
        if (stop_at == 1) CHECK(state->runs == 0);
        if (threads == 1 && stop_at > 0) CHECK(stopped && state->runs < 12);
        if (stopped) CHECK(count_touched(ranks, count) == 0);
        bn_neural_close(neural);
        CHECK(state->living == 0);
    }
}

/* ---- GPU */

/* CUDA sessions never fall back to the CPU. They use fewer tiles and compute the same values. */
static void test_cuda(void) {
    enum { width = 700, height = 450, count = width * height };
    static float values[2][count];
    fake_state *state = fake_reset();
    for (int lacks_tf32 = 0; lacks_tf32 < 2; ++lacks_tf32) {
        int runs[2];
        for (int cuda = 0; cuda < 2; ++cuda) {
            bn_neural *neural;
            fake_reset();
            state->lacks_tf32 = lacks_tf32;
            CHECK(open_model(&plain, cuda ? "cuda" : NULL, FAKE_RUNTIME, 3, &neural) == BN_SUCCESS);
            CHECK(state->fallbacks == 0 && state->rough == 0);
            const int before = state->runs;
            CHECK(window_of(neural, -5, 9, width, height, 4, values[cuda], count) == BN_SUCCESS);
            CHECK(state->cuda_runs == (cuda ? state->runs : 0));
            runs[cuda] = state->runs - before;
            bn_neural_close(neural);
            CHECK(state->living == 0);
        }
        CHECK(runs[0] > 1 && runs[1] == 1);
        CHECK(memcmp(values[0], values[1], sizeof values[0]) == 0);
    }
}

/* Opening a model fails without CUDA or a GPU. The error code shows whether the model is at fault. */
static void test_missing_gpu(void) {
    bn_neural *neural;
    for (int code = 0; code <= 11; ++code) {
        const int blames_model = code == 7 || code == 9 || code == 10;
        fake_state *state = fake_reset();
        state->error_code = code;
        state->lacks_cuda = code == 0;
        state->lacks_gpu = code != 0;
        CHECK(open_model(&plain, "cuda", FAKE_RUNTIME, 1, &neural) ==
              (blames_model ? BN_ERROR_BAD_DATA : BN_ERROR_RUNTIME));
        CHECK(neural == NULL && state->living == 0 && state->runs == 0);
        CHECK(open_model(&plain, "cpu", FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
        bn_neural_close(neural);
        /* A version that fails to fuse nodes without names gets a second chance. */
        state->needs_names = 1;
        CHECK(open_model(&plain, "cpu", FAKE_RUNTIME, 1, &neural) ==
              (code == 1 ? BN_SUCCESS : BN_ERROR_BAD_DATA));
        bn_neural_close(neural);
        CHECK(state->living == 0);
    }
    fake_reset();
}

/* ---- Failures */

static void test_arguments(void) {
    bn_neural *neural;
    uint32_t ranks[16];
    float values[16];
    const bn_result invalid = BN_ERROR_INVALID_ARGUMENT;
    const struct {
        bn_neural_options options;
        bn_result expected;
    } cases[] = {
        {{.model = &plain}, invalid},
        {{.model = &plain, .model_size = sizeof plain, .model_path = "model.onnx"}, invalid},
        {{.model_path = "model.onnx", .model_size = sizeof plain}, invalid},
        {{.model_path = ""}, invalid},
        {{.model_path = "/there/is/no/such/model.onnx"}, BN_ERROR_IO},
        {{.model_path = "/dev/null"}, BN_ERROR_BAD_DATA},
        {{.model_path = "/"}, BN_ERROR_IO},
        {{.model_path = "/dev/zero"}, BN_ERROR_BAD_DATA}, /* endless */
        {{.model = &plain, .model_size = sizeof plain, .runtime_path = ""}, invalid},
        {{.model = &plain, .model_size = sizeof plain, .provider = ""}, invalid},
        {{.model = &plain, .model_size = sizeof plain, .provider = "CUDA"}, invalid}};
    CHECK(bn_neural_open(NULL, NULL) == invalid);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        bn_neural_options options = cases[i].options;
        options.struct_size = sizeof options;
        if (options.runtime_path == NULL) options.runtime_path = FAKE_RUNTIME;
        neural = (bn_neural *)ranks;
        CHECK(bn_neural_open(&options, &neural) == cases[i].expected && neural == NULL);
    }
    bn_neural_close(NULL);
    CHECK(bn_neural_channels(NULL) == 0);

    CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
    memset(ranks, 7, sizeof ranks);
    CHECK(mask_of(NULL, 4, 4, 0, ranks) == invalid);
    CHECK(mask_of(neural, 4, 4, 0, NULL) == invalid);
    CHECK(mask_of(neural, 0, 4, 0, ranks) == invalid);
    CHECK(mask_of(neural, 4, 0, 0, ranks) == invalid);
    const bn_mask shapes[] = {{ranks, 32, 4, 2, 1, 2}, {ranks, 32, 4, 2, 2, 1}};
    for (int i = 0; i < 2; ++i) CHECK(bn_neural_mask(neural, &shapes[i], 0, NULL, NULL) == invalid);
    CHECK(mask_of(neural, UINT32_MAX, UINT32_MAX, 0, ranks) == BN_ERROR_OUT_OF_MEMORY);
    for (int i = 0; i < 16; ++i) CHECK(ranks[i] == 0x07070707);
    CHECK(window_of(NULL, 0, 0, 4, 4, 0, values, 16) == invalid);
    CHECK(window_of(neural, 0, 0, 4, 4, 0, NULL, 16) == invalid);
    CHECK(window_of(neural, 0, 0, 0, 4, 0, values, 0) == invalid);
    CHECK(window_of(neural, 0, 0, 4, 0, 0, values, 0) == invalid);
    CHECK(window_of(neural, 0, 0, 4, 4, 0, values, 17) == BN_ERROR_SIZE_MISMATCH);
    CHECK(window_of(neural, FARTHEST - 3, 0, 4, 4, 0, values, 16) == invalid);
    CHECK(window_of(neural, 0, -FARTHEST - 1, 4, 4, 0, values, 16) == invalid);
    CHECK(window_of(neural, INT64_MIN, INT64_MAX, 4, 4, 0, values, 16) == invalid);
    CHECK(window_of(neural, FARTHEST - 4, -FARTHEST, 4, 4, 0, values, 16) == BN_SUCCESS);
    bn_neural_close(neural);
}

/* Makes every runtime call that can fail do so once. No failure leaks memory, changes the output or moves a
 * network from the GPU to the CPU. */
static void test_failing_calls(const char *provider) {
    enum { extent = 40, count = extent * extent };
    static uint32_t ranks[count];
    const int cuda = provider != NULL;
    fake_state *state = fake_reset();
    int runtime = 0, bad_data = 0;
    for (int fail_at = 1;; ++fail_at) {
        bn_neural *neural;
        fake_reset();
        state->fail_at = fail_at;
        bn_result result = open_model(&plain, provider, FAKE_RUNTIME, 1, &neural);
        memset(ranks, 7, sizeof ranks);
        if (result == BN_SUCCESS) {
            result = mask_of(neural, extent, extent, 0, ranks);
            if (result == BN_ERROR_RUNTIME) CHECK(ranks[0] == 0x07070707 && ranks[1] == ranks[0]);
            CHECK(state->cuda_runs == (cuda ? state->runs : 0) && state->fallbacks == 0);
        } else {
            CHECK(neural == NULL);
        }
        bn_neural_close(neural);
        CHECK(state->living == 0);
        if (state->calls < fail_at) break;
        runtime += result == BN_ERROR_RUNTIME;
        bad_data += result == BN_ERROR_BAD_DATA;
        CHECK(result == BN_ERROR_RUNTIME || result == (cuda ? BN_SUCCESS : BN_ERROR_BAD_DATA));
    }
    /* On the CPU, failing to create the session or to try the model counts as bad data. */
    CHECK(runtime > (cuda ? 15 : 6) && bad_data == (cuda ? 0 : 4));
    fake_reset();
}

static void test_values_that_are_not_finite(void) {
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    enum { extent = 20, count = extent * extent };
    uint32_t ranks[count] = {0};
    float values[count];
    for (int i = 0; i < 3; ++i) {
        fake_state *state = fake_reset();
        bn_neural *neural;
        state->spoil_from = 1;
        state->spoil_with = bad[i];
        CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_ERROR_BAD_DATA);
        state->spoil_from = 0;
        CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
        state->spoil_from = 1;
        memset(ranks, 0, sizeof ranks);
        CHECK(mask_of(neural, extent, extent, 0, ranks) == BN_ERROR_BAD_DATA);
        CHECK(window_of(neural, 0, 0, extent, extent, 0, values, count) == BN_ERROR_BAD_DATA);
        CHECK(ranks[0] == 0 && ranks[1] == 0);
        /* Windows clamp finite values to [0, 1). */
        state->spoil_with = i == 0 ? 3.0f : i == 1 ? -0.25f : 1.0f;
        CHECK(window_of(neural, 0, 0, extent, extent, 0, values, count) == BN_SUCCESS);
        CHECK(values[count - 1] == (i == 1 ? 0 : 1 - 0x1p-24f));
        CHECK(mask_of(neural, extent, extent, 0, ranks) == BN_SUCCESS);
        CHECK(ranks[count - 1] == (i == 1 ? 0 : count - 1));
        bn_neural_close(neural);
    }
    fake_reset();
}

static void test_unusable_libraries(void) {
    /* libc.so.6 can be loaded but lacks ONNX Runtime's entry point. */
    static const char *const libraries[] = {"/there/is/no/such/library.so", __FILE__, "libc.so.6",
                                            "/"};
    static const fake_state lacking[] = {
        {.lacks_base = 1}, {.lacks_table = 1}, {.version = "1.16.3"}, {.version = "nightly"}};
    bn_neural *neural;
    for (size_t i = 0; i < sizeof libraries / sizeof *libraries; ++i) {
        CHECK(open_model(&plain, NULL, libraries[i], 1, &neural) == BN_ERROR_RUNTIME &&
              neural == NULL);
        setenv("BN_ONNXRUNTIME", libraries[i], 1);
        CHECK(open_model(&plain, NULL, NULL, 1, &neural) == BN_ERROR_RUNTIME);
        CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS);
        bn_neural_close(neural);
    }
    for (size_t i = 0; i < sizeof lacking / sizeof *lacking; ++i) {
        *fake_reset() = lacking[i];
        CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_ERROR_RUNTIME &&
              neural == NULL);
    }
    fake_state *state = fake_reset();
    state->version = "1.18.2";
    CHECK(open_model(&plain, NULL, FAKE_RUNTIME, 1, &neural) == BN_SUCCESS &&
          state->asked_version == 18);
    bn_neural_close(neural);
    fake_reset();
    setenv("BN_ONNXRUNTIME", FAKE_RUNTIME, 1);
    CHECK(open_model(&plain, NULL, NULL, 1, &neural) == BN_SUCCESS);
    bn_neural_close(neural);
    unsetenv("BN_ONNXRUNTIME");
    /* libbn disables telemetry if it loads the runtime itself. */
    unsetenv("ORT_DISABLE_TELEMETRY");
    CHECK(open_model(&plain, NULL, BN_FAKE_DIR "/libfake_other.so", 1, &neural) == BN_SUCCESS);
    state = fake_state_of(BN_FAKE_DIR "/libfake_other.so");
    CHECK(strcmp(getenv("ORT_DISABLE_TELEMETRY"), "1") == 0);
    CHECK(state->telemetry_disabled == 1);
    bn_neural_close(neural);
    CHECK(state->living == 0);
}

int main(void) {
    test_noise();
    test_windows();
    test_sparse_spacing();
    test_masks();
    test_threads_are_used();
    test_progress();
    test_cuda();
    test_missing_gpu();
    test_arguments();
    test_failing_calls(NULL);
    test_failing_calls("cuda");
    test_values_that_are_not_finite();
    test_unusable_libraries();
    return check_result();
}
