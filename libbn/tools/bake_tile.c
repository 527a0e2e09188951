/* SPDX-License-Identifier: Apache-2.0
 * Memory, random numbers and sums for bn_bake_sampler. Sums have a fixed inner stride, so that compilers
 * vectorise them in a fixed order. Random numbers are counters hashed by splitmix64 (Steele, Lea and Flood,
 * "Fast Splittable Pseudorandom Number Generators", 2014). */
#include "bake_tile.h"
#include <stdio.h>
#include <stdlib.h>

void *bake_allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "bn_bake_sampler: no memory for %zu bytes; close other programs\n",
                count * size);
        exit(1);
    }
    return memory;
}

/* ---- Random numbers ---- */

uint64_t bake_mix(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

bake_random bake_random_make(uint64_t seed, uint64_t what, uint64_t which) {
    bake_random r = {bake_mix(bake_mix(bake_mix(seed) + what) + which), 0};
    return r;
}

uint64_t bake_random_bits(bake_random *r) {
    return bake_mix(r->key ^ bake_mix(r->counter++));
}

double bake_random_double(bake_random *r) {
    return (double)(bake_random_bits(r) >> 11) * (1.0 / 9007199254740992.0);
}

uint32_t bake_random_below(bake_random *r, uint32_t limit) {
    return (uint32_t)((bake_random_bits(r) >> 32) * limit >> 32);
}

int bake_count(const bake_options *options, double count, int least) {
    double scaled = options->effort * count;
    return scaled > least ? (int)scaled : least;
}

int bake_pixel_of(int block, int place) {
    return (block / 16 * 4 + place / 4) * SIDE + block % 16 * 4 + place % 4;
}

float bake_inner_product(const float *a, const float *b, int count) {
    float lane[16] = {0}, sum = 0;
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += a[i + k] * b[i + k];
    }
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum;
}
