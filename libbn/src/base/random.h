/* SPDX-License-Identifier: Apache-2.0
 * A sequential random number generator for the mask generators. */
#ifndef BN_RANDOM_H
#define BN_RANDOM_H

#include "base/assert.h"
#include "base/hash.h"

/* SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014). */
typedef struct bn_random {
    uint64_t state;
} bn_random;

/* A stream that shares no numbers with other hashes of the seed, such as bn_mix64(seed). */
static inline bn_random bn_random_seeded(uint64_t seed) {
    bn_random random = {bn_mix64(seed ^ bn_mix64(0x9e3779b97f4a7c17u))};
    return random;
}

static inline uint64_t bn_random_next(bn_random *random) {
    random->state += 0x9e3779b97f4a7c15u;
    return bn_mix64(random->state);
}

/* A random integer below `bound`, computed by multiplication. Its bias is below bound / 2^32. */
static inline uint32_t bn_random_below(bn_random *random, uint32_t bound) {
    BN_ASSERT(bound > 0);
    return (uint32_t)((bn_random_next(random) >> 32) * bound >> 32);
}

#endif
