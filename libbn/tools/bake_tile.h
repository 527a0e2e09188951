/* SPDX-License-Identifier: Apache-2.0
 * What the stages of bn_bake_sampler share: the table that is being made, test integrands, random
 * numbers, blurs, and the stages themselves, each a function of the table before it, the seed and the
 * effort alone. */
#ifndef BN_BAKE_TILE_H
#define BN_BAKE_TILE_H

#include "pole_order.h"
#include <bn/bn_draw.h>
#include <stddef.h>
#include <stdint.h>

enum {
    SIDE = 64,            /* of the tile, in pixels */
    PIXELS = SIDE * SIDE, /* as many labels */
    BLOCKS = PIXELS / 16, /* of 4 x 4 pixels, whose labels share their upper bits */
    MEMBERS = 4,
    POINTS = 256,
    LEVELS = 9 /* 1, 2, 4 ... 256 samples */
};

static const double SIGMA = 2.1; /* of the blur through which an image is judged, in pixels */

typedef struct {
    pole_vectors member[MEMBERS];
    uint16_t label[MEMBERS][PIXELS]; /* label >> 4 is the same for all members */
} bake_table;

typedef struct {
    uint64_t seed;
    double effort;
    /* Called now and then with what share of the part is done. */
    void (*progress)(double share);
} bake_options;

/* ---- Memory and random numbers ---- */

/* Zeroed; ends the program when there is none. */
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

/* ---- The table ---- */

/* Pixel `place`, row by row, of a block. */
int bake_pixel_of(int block, int place);

/* Labels by random permutations of the four children of every node of the quadtree, from `seed` down
 * to blocks of 4 x 4 pixels and from `within` inside them; any permutations there if `linear`, else
 * those that keep columns and rows apart. */
void bake_tree_labels(uint16_t label[PIXELS], uint64_t seed, uint64_t within, int linear);

/* The words of bn_tables(). */
void bake_table_pack(const bake_table *table, uint32_t words[BN_WORD_COUNT]);
/* The vectors of such words, in some basis of each level of the quadtree. */
void bake_table_unpack_vectors(bake_table *table, const uint32_t words[BN_WORD_COUNT]);

/* Coordinates of the first `count` samples of a label in one pair, XORed with a key: random digits
 * of a domain in a copy of the tile, and of a pixel from the seventeenth on. */
typedef struct {
    uint32_t point[POINTS][2], shift[PIXELS][2];
} bake_pair;

void bake_pair_make(bake_pair *pair, const pole_vectors *v, int which);

typedef struct {
    uint32_t x, y;
} bake_key;

bake_key bake_key_make(bake_random *r);
void bake_pair_points(const bake_pair *pair, uint32_t label, bake_key key, int count, float *x,
                      float *y);

/* Counts of samples between powers of two. Which samples these are depends on the order of a
 * domain: a mask of the first 64 for each count. */
enum { PARTIALS = 9 };
extern const int bake_partial_count[PARTIALS];
typedef struct {
    uint64_t mask[PARTIALS];
} bake_sample_order;

bake_sample_order bake_sample_order_make(bake_random *r);

/* The same of pixel p in a domain of independent Owen-scrambled Sobol' pixels, the baseline. */
void bake_sobol_points(int p, uint32_t domain, int count, float *x, float *y);

/* ---- Integrands ---- */

/* 1 where a x + b y < c; its mean is its area in the unit square. */
typedef struct {
    float a, b, c;
    double mean;
} bake_plane;

/* Through a random point, at an angle in turns. */
bake_plane bake_plane_make(bake_random *r, double turns);
/* 1 where x or y is below a place. */
bake_plane bake_plane_step(int dimension, double place);

/* Which of `count` points (64 or 256) are inside. */
void bake_plane_bits(const bake_plane *plane, const float *x, const float *y, int count,
                     uint64_t *bits);

/* By how much the share of set bits among the first 2^l differs from `mean`, `stride` numbers apart, for
 * l = 0 ... 6 with one word, 8 with four. */
void bake_prefix_errors(const uint64_t *bits, int levels, double mean, float *out, int stride);

/* ---- Images ---- */

/* Of `count` numbers, a multiple of 16. */
double bake_mean_square(const float *image, int count);
float bake_inner_product(const float *a, const float *b, int count);

/* What errors of two pixels add to the energy, by their distance: the autocorrelation of the blur
 * along rows (1), columns (2) or both (3), scaled to 1 for the same pixel, with a share of a narrow
 * one of one pixel. */
enum { BAKE_REACH = 11, BAKE_TAPS = 2 * BAKE_REACH + 1 };
static const double BAKE_LEAST_TAP = 0.003; /* what is smaller is left out */

typedef struct {
    float tap[BAKE_TAPS][BAKE_TAPS];
} bake_kernel;

void bake_kernel_add(bake_kernel *kernel, int axes, double narrow, double weight);

/* ---- The stages ---- */

/* What a stage does for a member; `number` is for bake_vectors(). */
typedef void bake_stage(bake_table *table, const bake_options *options, int member, int number);

bake_stage bake_start;   /* vectors and labels to begin with */
bake_stage bake_vectors; /* the vectors of a member; number 1: once more, beside all others */
bake_stage bake_blocks;  /* the quadtree down to blocks of 4 x 4 pixels, for all members */
bake_stage bake_labels;  /* the quadtree inside these blocks */
bake_stage bake_finish;  /* lower digits, which no search looks at */

/* Errors of smooth functions in single pixels: the mean of logarithms of ratios to Sobol', and a
 * penalty on those above it. */
typedef struct bake_smooth_judge bake_smooth_judge;
bake_smooth_judge *bake_smooth_begin(bake_random *r);
double bake_smooth_energy(const bake_smooth_judge *j, const pole_vectors *v);

/* ---- Features: what labels are compared by ---- */

/* Rows of `width` numbers, a multiple of 16: errors, projected. */
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

/* Of a label, a row for each of PIXELS: half-planes and products, steps of dimension 0 or 1 of the
 * pair (0, 1), steps in the pairs whose axes must be alike, or steps in all four dimensions. */
void bake_features_of_label(bake_features *f, const bake_table *table, const bake_options *options,
                            int member, int what);
/* Of products over two members, a row for each block and two places in it, the first member's place
 * outside. */
void bake_features_of_two(bake_features *f, const bake_table *table, const bake_options *options,
                          int first, int second);

#endif
