/* SPDX-License-Identifier: Apache-2.0
 * A four-dimensional Sobol' sequence, Owen-scrambled in every pixel and domain on its own: a
 * baseline whose four dimensions are stratified together. The sampler "sobol" is padded instead:
 * its pairs (0,1) and (2,3) are two-dimensional sequences in unrelated orders.
 *
 * Digits come from the matrices of Joe and Kuo's first four dimensions ("Constructing Sobol
 * Sequences with Better Two-Dimensional Projections", 2008): every 2^m samples from a multiple of
 * 2^m on are a (3, m, 4)-net in base 2. Index and coordinates go through nested uniform
 * scramblings, which keep the nets, by hashes as in Laine and Karras, "Stratified Sampling for
 * Stochastic Transparency", 2011, and Burley, "Practical Hash-based Owen Scrambling", 2020. All of
 * it is integer arithmetic, in C and C++, so that the benchmarks measure the same sampler. */
#ifndef SOBOL4D_H
#define SOBOL4D_H

#include <stdint.h>

/* Row k: bit k of an index contributes these digits to the four dimensions. Recurrences of the
 * polynomials 1, x + 1, x^2 + x + 1 and x^3 + x + 1, with the initial numbers 1; 1, 3; 1, 3, 1. */
static const uint32_t sobol4d_directions[32][4] = {
    {0x80000000u, 0x80000000u, 0x80000000u, 0x80000000u},
    {0x40000000u, 0xc0000000u, 0xc0000000u, 0xc0000000u},
    {0x20000000u, 0xa0000000u, 0x60000000u, 0x20000000u},
    {0x10000000u, 0xf0000000u, 0x90000000u, 0x50000000u},
    {0x08000000u, 0x88000000u, 0xe8000000u, 0xf8000000u},
    {0x04000000u, 0xcc000000u, 0x5c000000u, 0x74000000u},
    {0x02000000u, 0xaa000000u, 0x8e000000u, 0xa2000000u},
    {0x01000000u, 0xff000000u, 0xc5000000u, 0x93000000u},
    {0x00800000u, 0x80800000u, 0x68800000u, 0xd8800000u},
    {0x00400000u, 0xc0c00000u, 0x9cc00000u, 0x25400000u},
    {0x00200000u, 0xa0a00000u, 0xee600000u, 0x59e00000u},
    {0x00100000u, 0xf0f00000u, 0x55900000u, 0xe6d00000u},
    {0x00080000u, 0x88880000u, 0x80680000u, 0x78080000u},
    {0x00040000u, 0xcccc0000u, 0xc09c0000u, 0xb40c0000u},
    {0x00020000u, 0xaaaa0000u, 0x60ee0000u, 0x82020000u},
    {0x00010000u, 0xffff0000u, 0x90550000u, 0xc3050000u},
    {0x00008000u, 0x80008000u, 0xe8808000u, 0x208f8000u},
    {0x00004000u, 0xc000c000u, 0x5cc0c000u, 0x51474000u},
    {0x00002000u, 0xa000a000u, 0x8e606000u, 0xfbea2000u},
    {0x00001000u, 0xf000f000u, 0xc5909000u, 0x75d93000u},
    {0x00000800u, 0x88008800u, 0x6868e800u, 0xa0858800u},
    {0x00000400u, 0xcc00cc00u, 0x9c9c5c00u, 0x914e5400u},
    {0x00000200u, 0xaa00aa00u, 0xeeee8e00u, 0xdbe79e00u},
    {0x00000100u, 0xff00ff00u, 0x5555c500u, 0x25db6d00u},
    {0x00000080u, 0x80808080u, 0x8000e880u, 0x58800080u},
    {0x00000040u, 0xc0c0c0c0u, 0xc0005cc0u, 0xe54000c0u},
    {0x00000020u, 0xa0a0a0a0u, 0x60008e60u, 0x79e00020u},
    {0x00000010u, 0xf0f0f0f0u, 0x9000c590u, 0xb6d00050u},
    {0x00000008u, 0x88888888u, 0xe8006868u, 0x800800f8u},
    {0x00000004u, 0xccccccccu, 0x5c009c9cu, 0xc00c0074u},
    {0x00000002u, 0xaaaaaaaau, 0x8e00eeeeu, 0x200200a2u},
    {0x00000001u, 0xffffffffu, 0xc5005555u, 0x50050093u},
};

/* The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
 * Generators", 2014). */
static inline uint64_t sobol4d_mix(uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

static inline uint32_t sobol4d_reverse(uint32_t v) {
    v = (v >> 16) | (v << 16);
    v = ((v >> 8) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8);
    v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
    v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
    return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

/* Nested uniform scrambling: flips each bit by a hash of the bits above it. The multipliers are
 * those of Vegdahl, "Building a Better LK Hash", 2021. */
static inline uint32_t sobol4d_scramble(uint32_t digits, uint32_t seed) {
    uint32_t v = sobol4d_reverse(digits);
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return sobol4d_reverse(v);
}

/* Sample `index` of a pixel in the domain `key`: four numbers in [0, 1), multiples of 2^-24. */
static inline void sobol4d_draw(uint64_t seed, int32_t x, int32_t y, uint32_t index, uint32_t key,
                                float u[4]) {
    const uint64_t golden = 0x9e3779b97f4a7c15u; /* SplitMix64's increment */
    const uint64_t pixel = ((uint64_t)(uint32_t)y << 32) | (uint32_t)x;
    const uint64_t own =
        sobol4d_mix(sobol4d_mix(sobol4d_mix(seed + golden) + key + golden) ^ pixel);
    const uint64_t first = sobol4d_mix(own + golden), second = sobol4d_mix(own + 2 * golden),
                   third = sobol4d_mix(own + 3 * golden);
    const uint32_t seeds[4] = {(uint32_t)first, (uint32_t)(first >> 32), (uint32_t)second,
                               (uint32_t)(second >> 32)};
    uint32_t digits[4] = {0, 0, 0, 0};
    const uint32_t shuffled = sobol4d_scramble(index, (uint32_t)third);
    for (int bit = 0; bit < 32; ++bit) {
        const uint32_t mask = 0u - ((shuffled >> bit) & 1u);
        for (int d = 0; d < 4; ++d) digits[d] ^= mask & sobol4d_directions[bit][d];
    }
    for (int d = 0; d < 4; ++d)
        u[d] = (float)(sobol4d_scramble(digits[d], seeds[d]) >> 8) * (1.0f / 16777216.0f);
}

#endif
