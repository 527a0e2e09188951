/* SPDX-License-Identifier: Apache-2.0
 * How tests control the fake ONNX Runtime, and the network that it computes. */
#ifndef BN_TESTS_FAKE_ONNXRUNTIME_H
#define BN_TESTS_FAKE_ONNXRUNTIME_H

#include <stdint.h>

typedef struct fake_state {
    int calls, fail_at; /* of the functions that can fail; the one numbered fail_at does */
    int error_code;     /* of all statuses */
    int living;         /* objects, statuses too */
    int spoil_from;     /* from this call on, outputs end with spoil_with; 0: never */
    float spoil_with;
    int meet; /* runs wait until two are under way at once */
    int running, most_running, runs;
    int telemetry_disabled, spinning, log_level;
    int lacks_cuda, lacks_tf32, lacks_gpu, lacks_table, lacks_base;
    const char *version;             /* NULL: one that will do */
    int cuda_runs, rough, fallbacks; /* rough: sessions of low precision; fallbacks: that may leave
                                      * CUDA */
    uint32_t asked_version;
} fake_state;

typedef fake_state *(*fake_state_getter)(void);

/* The bytes of a model. */
typedef struct fake_model {
    int radius, align, spacing; /* spacing 0 leaves the entry out */
    uint32_t channels;
} fake_model;

/* The output of the fake network, from the first, the middle and the last texel of the window that
 * an output texel sees. */
static inline float fake_network(uint32_t channel, float first, float middle, float last) {
    return (channel % 2 ? 1 - middle : middle) * 0.5f + first * 0.25f + last * 0.125f;
}

#endif
