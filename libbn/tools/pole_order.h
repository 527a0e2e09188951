/* SPDX-License-Identifier: Apache-2.0
 * Pole order: digital sequences whose samples and pixels are stratified together.
 *
 * All arithmetic is over the two-element field. For each pair of coordinates, the bits of a sample's index
 * are the coefficients of the powers of X, and the bits of a pixel's label are the coefficients of 1/P,
 * X/P, 1/P^2, X/P^2 ... with P = X^2 + X + 1: two bits per level of a quadtree. The coordinates are the
 * expansions of the sum at 0 and at 1. P has no zeros there, so the difference of two such functions has
 * too few zeros for two samples to share an elementary interval. (Niederreiter and Xing construct nets from
 * function fields in "Low-discrepancy sequences and global function fields with many rational places",
 * 1996.) The second pair uses an SZ sequence's index, so that a pixel's four coordinates form nets in base
 * 4, and a linear map of the first pair's label. Takes microseconds. */
#ifndef BN_POLE_ORDER_H
#define BN_POLE_ORDER_H

#include <stdint.h>

enum {
    POLE_INDEX_BITS = 32,
    POLE_LABEL_BITS = 12,
    POLE_VECTORS = POLE_INDEX_BITS + POLE_LABEL_BITS
};

/* The vectors that the bits of an index and of a label add to the four coordinates, lowest bit first. */
typedef union {
    struct {
        uint32_t index[POLE_INDEX_BITS][4], label[POLE_LABEL_BITS][4];
    };
    uint32_t all[POLE_VECTORS][4];
} pole_vectors;

/* `form` is 0 to 3: bit 0 renames the second pair's base-4 digits, bit 1 exchanges the first pair's
 * coordinates. */
void pole_vectors_make(pole_vectors *v, int form);

/* The sum of the vectors of the bits that are set: of v->label for a label, of v->index for an index. */
void pole_sum(const uint32_t vectors[][4], uint32_t bits, uint32_t out[4]);

/* The first digit of coordinate d as a sum of index bits. */
uint32_t pole_first_digit(const pole_vectors *v, int d);

/* Adds digit `from` of coordinate d to the less significant digit `to`. Preserves every net. */
void pole_add_digit(pole_vectors *v, int d, int from, int to);

/* Changes the order of the samples: adds the vector of bit `from` to the vector of the higher bit `to`, so
 * that every power-of-two prefix stays the same set. */
void pole_add_index(pole_vectors *v, int from, int to);

/* Uses random bits to map a pair's label within one level, or to add a finer level's vector to a
 * coarser level's. Preserves every net. */
void pole_mix_labels(pole_vectors *v, int pair, uint64_t random);

#endif
