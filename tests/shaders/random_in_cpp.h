/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BN_RANDOM_IN_CPP_H
#define BN_RANDOM_IN_CPP_H

#include <stdint.h>

/* The effects with a place in the layout. Without a lens, those of RANDOM_LENS, RANDOM_ENVIRONMENT and
 * RANDOM_CHOICE are names as all others are. */
#define RANDOM_PIXEL 0u
#define RANDOM_LENS 4u
#define RANDOM_DIRECTION 3u
#define RANDOM_LIGHT 5u
#define RANDOM_ENVIRONMENT 7u
#define RANDOM_CHOICE 6u

enum {
    RANDOM_ASKED = 5,   /* x, y, index, bounce, effect */
    RANDOM_NUMBERS = 10 /* rand1(), rand2(), rand3(), rand4() */
};

#ifdef __cplusplus
extern "C" {
#endif
void random_glsl(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                 float out[RANDOM_NUMBERS]);
void random_glsl_with_lens(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                           float out[RANDOM_NUMBERS]);
#ifdef __cplusplus
}
#endif

#endif
