/* SPDX-License-Identifier: Apache-2.0
 * Shared by the mask tests: checks of ranks, short calls of the generators and measures, and a progress
 * callback that can cancel. */
#ifndef BN_TESTS_MASKS_H
#define BN_TESTS_MASKS_H

#include "check.h"
#include <bn/bn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static inline int is_permutation(const uint32_t *ranks, size_t count) {
    unsigned char *seen = calloc(count, 1);
    size_t good = 0;
    for (size_t i = 0; i < count; ++i) {
        if (ranks[i] < count && !seen[ranks[i]]) {
            seen[ranks[i]] = 1;
            ++good;
        }
    }
    free(seen);
    return good == count;
}

static inline void fill_white(uint32_t *ranks, size_t count, uint32_t seed) {
    uint32_t state = seed * 2654435761u + 1u;
    for (size_t i = 0; i < count; ++i) ranks[i] = (uint32_t)i;
    for (size_t i = count; i > 1; --i) {
        size_t other = next_random(&state) % i;
        uint32_t rank = ranks[other];
        ranks[other] = ranks[i - 1];
        ranks[i - 1] = rank;
    }
}

static inline bn_result anneal_channels(const bn_anneal_options *options, uint32_t width,
                                        uint32_t height, uint32_t channels, uint32_t *ranks) {
    bn_mask mask = bn_mask_u32(ranks, width, height);
    mask.channels = channels;
    return bn_anneal(options, &mask, NULL, NULL);
}

static inline double error_of(const uint32_t *ranks, uint32_t width, uint32_t height,
                              double sigma) {
    double error = 1;
    const bn_mask mask = bn_mask_u32(ranks, width, height);
    CHECK(bn_mask_error(&mask, sigma, &error, NULL, NULL) == BN_SUCCESS);
    return error;
}

/* A progress callback that can cancel. It counts all calls, calls with fraction 0, and wrong fractions. */
typedef struct watch {
    int cancel_at; /* 0: never */
    int calls, at_zero, backwards;
    double last;
} watch;

static inline int32_t watch_progress(void *user, double fraction) {
    watch *w = user;
    w->backwards += !(fraction >= w->last && fraction < 1);
    w->at_zero += fraction == 0;
    w->last = fraction;
    return ++w->calls == w->cancel_at;
}

/* Counts the texels that have changed since their bytes were set to 0x5a. */
static inline size_t count_touched(const uint32_t *ranks, size_t count) {
    size_t touched = 0;
    for (size_t i = 0; i < count; ++i) touched += ranks[i] != 0x5a5a5a5au;
    return touched;
}

static inline uint64_t hash_ranks(const uint32_t *ranks, size_t count) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < count; ++i) hash = (hash ^ ranks[i]) * 0x100000001b3u;
    return hash;
}

#endif
