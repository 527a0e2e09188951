/* SPDX-License-Identifier: Apache-2.0
 * Shared by the stages of bn_bake_sampler: the table under construction, random numbers, sums of products,
 * and the stages themselves. Each stage depends only on the previous table, the seed and the effort. */
#ifndef BN_BAKE_TILE_H
#define BN_BAKE_TILE_H

#include "pole_order.h"
#include <bn/bn_draw.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SIDE = 64,            /* tile side, in pixels */
    PIXELS = SIDE * SIDE, /* also the number of labels */
    BLOCKS = PIXELS / 16, /* blocks of 4 x 4 pixels, whose labels share their upper bits */
    MEMBERS = 4,
    POINTS = 256,
    LEVELS = 9 /* 1, 2, 4 ... 256 samples */
};

static const double TURN = 6.283185307179586;
static const double SIGMA = 2.1; /* sigma of the blur through which an image is judged, in pixels */

typedef struct {
    pole_vectors member[MEMBERS];
    uint16_t label[MEMBERS][PIXELS]; /* label >> 4 is the same for all members */
} bake_table;

typedef struct {
    uint64_t seed;
    double effort;
} bake_options;

/* ---- Memory and random numbers ---- */

/* Allocates zeroed memory; ends the program if memory runs out. */
void *bake_allocate(size_t count, size_t size);

typedef struct {
    uint64_t key, counter;
} bake_random;

uint64_t bake_mix(uint64_t v);
bake_random bake_random_make(uint64_t seed, uint64_t what, uint64_t which);
uint64_t bake_random_bits(bake_random *r);
double bake_random_double(bake_random *r);                  /* in [0, 1) */
uint32_t bake_random_below(bake_random *r, uint32_t limit); /* limit < 2^16 */

/* effort * count, at least `least`. */
int bake_count(const bake_options *options, double count, int least);

/* Pixel `place` of a block, counted row by row. */
int bake_pixel_of(int block, int place);

/* ---- Images ---- */

/* Adds the squares of `count` numbers, a multiple of 16, to `sum`. In the header so that callers can
 * vectorise it. */
static inline double bake_add_squares(double sum, const float *v, int count) {
    float lane[16] = {0};
    for (int i = 0; i < count; i += 16) {
        for (int k = 0; k < 16; ++k) lane[k] += v[i + k] * v[i + k];
    }
    for (int k = 0; k < 16; ++k) sum += lane[k];
    return sum;
}
float bake_inner_product(const float *a, const float *b, int count);

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
/* Finds the quadtree down to blocks of 4 x 4 pixels, for all members. */
void bake_blocks(bake_table *table, const bake_options *options);
/* Finds a member's quadtree inside these blocks. */
void bake_labels(bake_table *table, const bake_options *options, int member);

/* Errors of smooth functions in single pixels: the mean logarithm of the ratios to Sobol', plus a penalty
 * for ratios above 1. */
typedef struct bake_smooth_judge bake_smooth_judge;
bake_smooth_judge *bake_smooth_begin(bake_random *r);
double bake_smooth_energy(const bake_smooth_judge *j, const pole_vectors *v);

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
void bake_features_of_label(bake_features *f, const bake_table *table, const bake_options *options,
                            int member, int what);
/* Features of products over two members, one row for each block and two places in it; the first member's
 * place is the outer index. */
void bake_features_of_two(bake_features *f, const bake_table *table, const bake_options *options,
                          int first, int second);

#endif
