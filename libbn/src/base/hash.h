/* SPDX-License-Identifier: Apache-2.0
 * A 64-bit hash. The 32-bit hashes of the draws are in bn_draw.glsl. */
#ifndef BN_HASH_H
#define BN_HASH_H

#include <bn/bn.h>

/* The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
 * Generators", 2014), with the multipliers of Stafford's variant 13: a bijection in which every
 * input bit affects every output bit. */
static inline uint64_t bn_mix64(uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

#endif
