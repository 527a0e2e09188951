/* SPDX-License-Identifier: Apache-2.0
 * Progress and cancelling of masks and windows of a network. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <pthread.h>
#include <string.h>

enum { WIDTH = 1100, HEIGHT = 900, COUNT = WIDTH * HEIGHT };
static uint32_t ranks[COUNT];
static float values[COUNT];

typedef struct watcher {
    pthread_t thread;
    int calls, stop_at; /* the call to stop at; 0: none */
    double last;
    int good;
} watcher;

static int32_t watch(void *user, double fraction) {
    watcher *w = user;
    w->good =
        w->good && pthread_equal(w->thread, pthread_self()) && fraction >= w->last && fraction <= 1;
    w->last = fraction;
    return ++w->calls == w->stop_at;
}

static bn_result make(uint32_t threads, int window, int stop_at, watcher *w, int *runs) {
    model_parts parts = model_parts_default();
    message model;
    make_model(&parts, &model);
    bn_neural_options options = fake_options(&model);
    options.threads = threads;
    options.progress = watch;
    options.progress_user = w;
    fake_state *state = fake_reset();
    bn_neural *neural;
    memset(w, 0, sizeof *w);
    CHECK(bn_neural_open(&options, &neural) == BN_SUCCESS && w->calls == 0);
    w->thread = pthread_self();
    w->stop_at = stop_at;
    w->good = 1;
    memset(ranks, 0x5a, sizeof ranks);
    state->runs = 0;
    const bn_result result = window
                                 ? bn_neural_window(neural, 5, 6, WIDTH, HEIGHT, 1, values, COUNT)
                                 : bn_neural_mask(neural, WIDTH, HEIGHT, 1, ranks, COUNT);
    *runs = state->runs;
    bn_neural_close(neural);
    CHECK(w->good && state->living == 0);
    return result;
}

int main(void) {
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        for (int window = 0; window < 2; ++window) {
            watcher w = {0};
            int all, some;
            CHECK(make(threads, window, 0, &w, &all) == BN_SUCCESS && all >= 12 && w.calls >= 1);
            CHECK(threads > 1 || (w.calls == all + 1 && w.last > 0.9));
            /* At the start. */
            CHECK(make(threads, window, 1, &w, &some) == BN_ERROR_CANCELLED);
            CHECK(w.calls == 1 && some == 0);
            /* In the middle: other threads finish the tiles they have begun, and begin no others.
             * With luck they have taken all of them before the calling thread asks again. */
            const int stop_at = threads == 1 ? 4 : 2;
            const bn_result result = make(threads, window, stop_at, &w, &some);
            CHECK(result == (w.calls == stop_at ? BN_ERROR_CANCELLED : BN_SUCCESS));
            CHECK(threads > 1 || (w.calls == stop_at && some == 2));
            if (result == BN_SUCCESS) continue;
            for (size_t i = 0; i < COUNT && !window; ++i) CHECK(ranks[i] == 0x5a5a5a5au);
        }
    }
    return check_result();
}
