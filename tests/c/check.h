/* SPDX-License-Identifier: Apache-2.0
 * Shared by all C tests. CHECK() counts and prints failures; check_result() returns the exit status. */
#ifndef BN_TESTS_CHECK_H
#define BN_TESTS_CHECK_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

static int check_failures;
static int check_count;

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        ++check_count;                                                                             \
        if (!(condition)) {                                                                        \
            if (++check_failures <= 50) printf("%s:%d: %s\n", __FILE__, __LINE__, #condition);     \
        }                                                                                          \
    } while (0)

/* A small generator for test data (Marsaglia, "Xorshift RNGs", 2003). The state must not be 0. */
static inline uint32_t next_random(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    return *state ^= *state << 5;
}

static inline uint32_t bits_of(float v) {
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

static inline float float_of(uint32_t bits) {
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Returns the program's exit status: 0 if there was at least one check and none failed. */
static inline int check_result(void) {
    printf("%d checks, %d failed\n", check_count, check_failures);
    return check_failures == 0 && check_count > 0 ? 0 : 1;
}

#endif
