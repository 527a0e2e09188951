/* SPDX-License-Identifier: Apache-2.0
 * Controls the fake ONNX Runtime and defines the network it computes. */
#ifndef BN_TESTS_FAKE_ONNXRUNTIME_H
#define BN_TESTS_FAKE_ONNXRUNTIME_H

#include <stdint.h>

typedef struct fake_state {
    int calls, fail_at; /* calls that can fail; call number fail_at fails */
    int error_code;     /* the error code of all statuses */
    int living;         /* live objects, including statuses */
    int spoil_from;     /* starting at this call, outputs end with spoil_with; 0: never */
    float spoil_with;
    int meet; /* runs wait until two are in progress at once */
    int running, most_running, runs;
    int telemetry_disabled, spinning, log_level;
    int lacks_cuda, lacks_tf32, lacks_gpu, lacks_table, lacks_base, needs_names;
    const char *version;  /* NULL: a supported version */
    int cuda_runs, rough; /* rough: low-precision sessions */
    int fallbacks;        /* CUDA sessions that may fall back to the CPU */
    uint32_t asked_version;
} fake_state;

typedef fake_state *(*fake_state_getter)(void);

/* The bytes of a model. */
typedef struct fake_model {
    int radius, align, spacing; /* a spacing of 0 omits the entry */
    uint32_t channels;
} fake_model;

/* Computes an output texel of the fake network from the first, middle and last texels of its receptive
 * field. */
static inline float fake_network(uint32_t channel, float first, float middle, float last) {
    return (channel % 2 ? 1 - middle : middle) * 0.5f + first * 0.25f + last * 0.125f;
}

#endif
