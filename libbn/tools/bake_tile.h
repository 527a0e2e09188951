/* SPDX-License-Identifier: Apache-2.0
 * Shared by the stages of bn_bake_sampler: the table under construction, random numbers, sums of products,
 * and the stages themselves. Each stage depends only on the previous table, the seed and the effort. */
#ifndef BN_BAKE_TILE_H
#define BN_BAKE_TILE_H

#include "pole_order.h"
#include <bn/bn_draw.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum {
    SIDE = 64,            /* tile side, in pixels */
    PIXELS = SIDE * SIDE, /* also the number of labels */
    BLOCKS = PIXELS / 16, /* of 4 x 4 pixels */
    MEMBERS = 4,
    POINTS = 256, /* the first samples of a pixel, which the searches judge */
    LEVELS = 9    /* 1, 2, 4 ... 256 samples */
};

static const double TURN = 6.283185307179586;
static const double SIGMA = 2.1; /* sigma of the blur through which an image is judged, in pixels */

typedef struct {
    pole_vectors member[MEMBERS];
    uint16_t label[MEMBERS][PIXELS]; /* block << 4 | place; members share the blocks */
} bake_table;

typedef struct {
    uint64_t seed;
    double effort;
} bake_options;

/* The sums of the vectors of all labels and of the first samples. A draw is the sum of one each, and of keys. */
typedef struct {
    uint32_t label[PIXELS][4], point[POINTS][4];
} bake_sums;

static inline void bake_sums_make(bake_sums *s, const pole_vectors *v) {
    for (uint32_t m = 0; m < PIXELS; ++m) pole_sum(v->label, m, s->label[m]);
    for (uint32_t i = 0; i < POINTS; ++i) pole_sum(v->index, i, s->point[i]);
}

/* ---- Memory and random numbers ---- */

/* Allocates zeroed memory; ends the program if memory runs out. */
static inline void *bake_allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "bn_bake_sampler: no memory for %zu bytes; close other programs\n",
                count * size);
        exit(1);
    }
    return memory;
}

/* Counters hashed by splitmix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators",
 * 2014). */
typedef struct {
    uint64_t key, counter;
} bake_random;

static inline uint64_t bake_mix(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

static inline bake_random bake_random_make(uint64_t seed, uint64_t what, uint64_t which) {
    bake_random r = {bake_mix(bake_mix(bake_mix(seed) + what) + which), 0};
    return r;
}

static inline uint64_t bake_random_bits(bake_random *r) {
    return bake_mix(r->key ^ bake_mix(r->counter++));
}

/* In [0, 1). */
static inline double bake_random_double(bake_random *r) {
    return (double)(bake_random_bits(r) >> 11) * (1.0 / 9007199254740992.0);
}

/* Below a limit of at most 2^16. */
static inline uint32_t bake_random_below(bake_random *r, uint32_t limit) {
    return (uint32_t)((bake_random_bits(r) >> 32) * limit >> 32);
}

/* effort * count, at least `least`. */
static inline int bake_count(const bake_options *options, double count, int least) {
    const double scaled = options->effort * count;
    return scaled > least ? (int)scaled : least;
}

/* ---- Images ---- */

/* Pixel i, from 0 to 15, of a block, row by row. */
static inline int bake_pixel_of(int block, int i) {
    return (block / 16 * 4 + i / 4) * SIDE + block % 16 * 4 + i % 4;
}

/* Sums of `count` products, a multiple of 16. Their fixed inner stride lets compilers vectorise them in a
 * fixed order. */
static inline float bake_inner_product(const float *a, const float *b, int count) {
    float lane[16] = {0}, sum = 0;
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += a[i + k] * b[i + k];
    }
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum;
}

/* The same with squares, added to `sum` in double. */
static inline double bake_add_squares(double sum, const float *v, int count) {
    float lane[16] = {0};
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += v[i + k] * v[i + k];
    }
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum;
}

/* The weight of two pixels' errors in the energy, as a function of their distance: the autocorrelation of
 * the blur along rows (1), columns (2) or both (3), scaled to 1 for the same pixel and mixed with that of
 * a narrow blur of one pixel. */
enum { BAKE_REACH = 11, BAKE_TAPS = 2 * BAKE_REACH + 1 };

typedef struct {
    float tap[BAKE_TAPS][BAKE_TAPS];
} bake_kernel;

void bake_kernel_add(bake_kernel *kernel, int axes, double narrow, double weight);

/* ---- The stages ---- */

/* Finds a member's vectors. `again` repeats the search with all other members fixed. */
void bake_vectors(bake_table *table, const bake_options *options, int member, int again);
/* Finds the quadtree down to the blocks, for all members. */
void bake_blocks(bake_table *table, const bake_options *options);
/* Finds a member's quadtree inside the blocks: the places. */
void bake_places(bake_table *table, const bake_options *options, int member);

/* Errors of smooth functions in single pixels: the mean logarithm of the ratios to Sobol', plus a penalty
 * for ratios above 1. */
typedef struct bake_smooth_judge bake_smooth_judge;
bake_smooth_judge *bake_smooth_begin(bake_random *r);
double bake_smooth_energy(const bake_smooth_judge *j, const uint32_t point[POINTS][4]);

/* ---- Features, by which labels are compared ---- */

/* Projected errors, in rows of `width` numbers, a multiple of 16. */
typedef struct {
    int width;
    float *rows;
} bake_features;

enum {
    FEATURES_OWN,
    FEATURES_STEP_X,
    FEATURES_STEP_Y,
    FEATURES_AXES,
    FEATURES_SINGLES,
    FEATURES_OF_TWO
};

/* Label features, one row for each of PIXELS: half-planes and products, steps in dimension 0 or 1 of the
 * pair (0, 1), steps in the pairs whose axes must be equally good, or steps in all four dimensions. */
bake_features bake_features_of_label(const bake_table *table, const bake_options *options,
                                     int member, int what);
/* Features of products over two members, one row for each block and two places in it; the first member's
 * place is the outer index. */
bake_features bake_features_of_two(const bake_table *table, const bake_options *options, int first,
                                   int second);

#endif
