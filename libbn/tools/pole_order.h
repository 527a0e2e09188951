/* SPDX-License-Identifier: Apache-2.0
 * Pole order: digital sequences whose samples and pixels are stratified together.
 *
 * Over the field of four elements, the digits of a sample's index are the coefficients of the
 * powers of X, the digits of a pixel's label those of 1/P, X/P, 1/P^2, X/P^2 ... with an
 * irreducible quadratic P. Coordinate d of the sample is the expansion of the sum at place d of 0,
 * 1, w, w + 1. A difference of two such functions has too few zeros for two samples to share an
 * elementary interval. (Function fields as the source of nets: Niederreiter and Xing,
 * "Low-discrepancy sequences and global function fields with many rational places", 1996.)
 * Microseconds. */
#ifndef BN_POLE_ORDER_H
#define BN_POLE_ORDER_H

#include <stdint.h>

enum { POLE_INDEX_BITS = 32, POLE_LABEL_BITS = 12, POLE_DIGITS = 16, POLE_VECTORS = 44 };

/* What each bit adds to the four coordinates, the lowest bit first. */
typedef struct {
    uint32_t index[POLE_INDEX_BITS][4];
    uint32_t label[POLE_LABEL_BITS][4];
} pole_vectors;

/* Those of the index, then those of the label: k is 0 to POLE_VECTORS - 1. */
static inline uint32_t *pole_vector(pole_vectors *v, int k) {
    return k < POLE_INDEX_BITS ? v->index[k] : v->label[k - POLE_INDEX_BITS];
}

/* A linear map of the field onto itself as a space of bits: one of six. */
int pole_map(int map, int element);

/* P = X^2 + b X + c. Elements are numbers u << 1 | l for u + l w. */
void pole_vectors_make(pole_vectors *v, int c, int b);

void pole_label_shift(const pole_vectors *v, uint32_t label, uint32_t out[4]);
void pole_index_point(const pole_vectors *v, uint32_t index, uint32_t out[4]);

/* The upper `bits` digits of coordinate d as a sum of index bits (from bit 0) and label bits (from
 * bit 32), one row for each digit. */
void pole_rows(const pole_vectors *v, int d, int bits, uint64_t *rows);

/* The rank of n rows, which are overwritten. */
int pole_rank(uint64_t *rows, int n);

/* By how much the first 2^m samples over 2^b pixels of a block fail to be a net to base 2 in the
 * pair (0, 1) or (2, 3); 0 for a net. */
int pole_net_defects(const pole_vectors *v, int pair, int m, int b);

/* Adds digit `from` of coordinate d to digit `to`, a less significant one: keeps every net. */
void pole_add_digit(pole_vectors *v, int d, int from, int to);

/* Changes the order of the samples: the vector of bit `from` is added to that of `to`, a higher
 * one, so that every power-of-two prefix stays the same set. */
void pole_add_index(pole_vectors *v, int from, int to);

#endif
