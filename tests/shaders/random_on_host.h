/* SPDX-License-Identifier: Apache-2.0 */
#ifndef BN_RANDOM_ON_HOST_H
#define BN_RANDOM_ON_HOST_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The effects with a place in the layout. Without RANDOM_WITH_LENS, those of the lens, the environment
 * and the choice are names as all others are. */
#define RANDOM_PIXEL 0u
#define RANDOM_LENS 4u
#define RANDOM_DIRECTION 3u
#define RANDOM_LIGHT 5u
#define RANDOM_ENVIRONMENT 7u
#define RANDOM_CHOICE 6u

enum {
    RANDOM_ASKED = 7,   /* x, y, index, bounce, effect, two words of a seed */
    RANDOM_NUMBERS = 10 /* rand1(), rand2(), rand3(), rand4() */
};

void random_glsl(const uint32_t *words, const uint32_t asked[RANDOM_ASKED],
                 float out[RANDOM_NUMBERS]);

#ifdef __cplusplus
}
#endif

#endif
