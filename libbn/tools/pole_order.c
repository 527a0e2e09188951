/* SPDX-License-Identifier: Apache-2.0
 * Computes pole order's vectors from power series over the two-element field. */
#include "pole_order.h"
#include <assert.h>
#include <bn/bn_draw.h>
#include <string.h>

/* Multiplies each pair of bits by w, in the four-element field. */
static uint32_t times_w(uint32_t digits) {
    const uint32_t upper = digits >> 1 & 0x55555555u, lower = digits & 0x55555555u;
    return lower << 1 | (upper ^ lower);
}

/* Maps the first pair's index to the second's by the matrix of an SZ sequence, whose entries are
 * binomial(j, i) w^(j - i) (Ahmed et al., "SZ Sequences: Binary-Based (0, 2^q)-Sequences", 2025). */
static uint32_t second_pair(uint32_t digits) {
    digits ^= (times_w(digits) << 2) & 0xccccccccu;
    digits ^= (times_w(times_w(digits)) << 4) & 0xf0f0f0f0u;
    digits ^= (times_w(digits) << 8) & 0xff00ff00u;
    return digits ^ times_w(times_w(digits)) << 16;
}

/* The product of two series, most significant bit first. */
static uint32_t series_product(uint32_t a, uint32_t b) {
    uint32_t product = 0;
    for (int i = 0; i < 32; ++i) product ^= (b >> (31 - i) & 1u) != 0 ? a >> i : 0;
    return product;
}

/* Exchanges the coordinates of a pair. */
static void exchange(pole_vectors *v, int pair) {
    for (int k = 0; k < POLE_VECTORS; ++k) {
        const uint32_t first = v->all[k][2 * pair];
        v->all[k][2 * pair] = v->all[k][2 * pair + 1];
        v->all[k][2 * pair + 1] = first;
    }
}

void pole_vectors_make(pole_vectors *v, int form) {
    for (uint32_t j = 0; j < POLE_INDEX_BITS; ++j) {
        const uint32_t digits = bn_reverse_bits(1u << j);
        uint32_t second = second_pair(digits);
        if ((form & 1) != 0) second ^= second << 1 & 0xaaaaaaaau;
        v->index[j][0] = digits;
        v->index[j][1] = bn_sobol_second(digits);
        v->index[j][2] = second;
        v->index[j][3] = bn_sobol_second(second);
    }
    /* P is the same polynomial in X and in X + 1, so 1/P = 1 + X + X^3 + X^4 + X^6 ... at both places. */
    const uint32_t inverse = 0xdb6db6dbu;
    uint32_t fraction = inverse;
    for (int level = 0; level < POLE_LABEL_BITS / 2; ++level) {
        for (int d = 0; d < 4; ++d) {
            v->label[2 * level][d] = fraction;
            v->label[2 * level + 1][d] = fraction >> 1 ^ ((d & 1) != 0 ? fraction : 0u);
        }
        fraction = series_product(fraction, inverse);
    }
    /* Dimension 2 or 3 must share its first digit with dimension 0 or 1 over 8 samples: use dimension
     * 3. */
    uint32_t first[4];
    for (int d = 0; d < 4; ++d) first[d] = pole_first_digit(v, d) & 7u;
    if (first[2] == first[0] || first[2] == first[1]) exchange(v, 1);
    if ((form & 2) != 0) exchange(v, 0);
}

void pole_sum(const uint32_t vectors[][4], uint32_t bits, uint32_t out[4]) {
    memset(out, 0, 4 * sizeof *out);
    for (int j = 0; bits != 0; bits >>= 1, ++j) {
        for (int d = 0; d < 4 && (bits & 1u) != 0; ++d) out[d] ^= vectors[j][d];
    }
}

void pole_add_digit(pole_vectors *v, int d, int from, int to) {
    assert(from < to);
    for (int k = 0; k < POLE_VECTORS; ++k) {
        v->all[k][d] ^= (v->all[k][d] >> (31 - from) & 1u) << (31 - to);
    }
}

void pole_add_index(pole_vectors *v, int from, int to) {
    assert(from < to);
    for (int d = 0; d < 4; ++d) v->index[to][d] ^= v->index[from][d];
}

void pole_mix_labels(pole_vectors *v, int pair, uint64_t random) {
    const int within = (int)(random & 1u);
    const int low = (int)((random >> 1 & 0xffffu) * (within ? POLE_LABEL_BITS / 2 : 10) >> 16);
    if (within) {
        uint32_t *a = v->label[2 * low] + 2 * pair, *b = v->label[2 * low + 1] + 2 * pair;
        for (int c = 0; c < 2; ++c) {
            const uint32_t sum = a[c] ^ b[c];
            a[c] = b[c];
            b[c] = sum;
        }
        return;
    }
    const int coarser = (low / 2 + 1) * 2;
    const int high =
        coarser + (int)((random >> 17 & 0xffffu) * (uint32_t)(POLE_LABEL_BITS - coarser) >> 16);
    for (int c = 2 * pair; c < 2 * pair + 2; ++c) v->label[high][c] ^= v->label[low][c];
}

uint32_t pole_first_digit(const pole_vectors *v, int d) {
    uint32_t sum = 0;
    for (int j = 0; j < POLE_INDEX_BITS; ++j) sum |= (v->index[j][d] >> 31) << j;
    return sum;
}
