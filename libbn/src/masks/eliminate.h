/* SPDX-License-Identifier: Apache-2.0
 * Orders a sparse pattern's points, for a mask's first and last ranks. */
#ifndef BN_ELIMINATE_H
#define BN_ELIMINATE_H

#include "base/threads.h"
#include <bn/bn.h>

/* The spacing of `points` points spread evenly over a torus. Axes narrower than the spacing are ignored. */
double bn_spacing(const uint32_t extent[3], size_t points);

/* The spacing at and above which bn_eliminate() orders the points. `sigma` is that of void-and-cluster's
 * Gaussian, in texels. */
double bn_eliminate_spacing(double sigma);

/* The largest number of points, out of `count` texels, that have at least that spacing. It is at least 1,
 * and at most half of the texels, rounded up. */
size_t bn_eliminate_count(const uint32_t extent[3], size_t count, double spacing);

/* A progress callback, or NULL, and the fractions `from` and `to` between which progress runs. A team stops
 * together. */
typedef struct bn_eliminate_watch {
    bn_progress progress;
    void *user;
    double from, to;
    bn_team *team;
} bn_eliminate_watch;

/* Orders `count` texels, as indices into a row-major array, by repeatedly removing the tightest
 * cluster. On return, every prefix of `points` is spread evenly. Errors: OUT_OF_MEMORY,
 * CANCELLED. */
bn_result bn_eliminate(const uint32_t extent[3], uint64_t seed, uint32_t *points, size_t count,
                       const bn_eliminate_watch *watch);

/* Reorders a mask's first and last ranks, those whose points have at least that spacing, on up to two
 * threads. Progress goes from `from` to 1. Errors leave the ranks unchanged: OUT_OF_MEMORY,
 * CANCELLED. */
bn_result bn_eliminate_ends(const uint32_t extent[3], double spacing, uint64_t seed,
                            uint32_t threads, uint32_t *ranks, size_t count, double from,
                            bn_progress progress, void *user);

#endif
