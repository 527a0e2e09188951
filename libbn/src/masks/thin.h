/* SPDX-License-Identifier: Apache-2.0
 * The order in which to take points away from a sparse pattern. */
#ifndef BN_THIN_H
#define BN_THIN_H

#include <stddef.h>
#include <stdint.h>

/* The distance of `points` points spread evenly over a torus, axes too narrow for it left out. */
double bn_spacing(const uint32_t extent[3], size_t points);

/* Points from this distance on belong to bn_thin. `sigma` in texels, as in void-and-cluster. */
double bn_thin_spacing(double sigma);

/* The most texels out of `count` that are `spacing` apart: at least 1, at most half of them,
 * rounded up. */
size_t bn_thin_count(const uint32_t extent[3], size_t count, double spacing);

/* Orders `count` texels, given as linear indices of a row-major array: on return every prefix of
 * `points` is spread as evenly as taking away one at a time from the whole allows. Returns 0 when
 * memory is short. */
int bn_thin(const uint32_t extent[3], uint64_t seed, uint32_t *points, size_t count);

/* Orders the first and the last ranks of a mask anew, as many as stand `spacing` apart. Returns 0,
 * and leaves the ranks, when memory is short. */
int bn_thin_ends(const uint32_t extent[3], double spacing, uint64_t seed, uint32_t *ranks,
                 size_t count);

#endif
