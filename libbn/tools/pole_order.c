/* SPDX-License-Identifier: Apache-2.0
 * The vectors of pole order from power series over the field of four, and nets judged by ranks: the
 * samples of a digital sequence are a net exactly when the leading digits of its coordinates, as
 * linear functions of the index and label bits, are independent (Niederreiter, "Point sets and
 * sequences with small discrepancy", 1987). */
#include "pole_order.h"
#include <assert.h>
#include <string.h>

/* ---- The field of four; 1 is the number 2 ---- */

static int multiply(int a, int b) {
    int au = a >> 1, al = a & 1, bu = b >> 1, bl = b & 1;
    int u = (au & bu) ^ (al & bl), l = (au & bl) ^ (al & bu) ^ (al & bl);
    return u << 1 | l;
}

static int inverse(int a) {
    static const int of[4] = {0, 3, 2, 1};
    return of[a];
}

static int power(int a, int n) {
    int result = 2;
    while (n-- > 0) result = multiply(result, a);
    return result;
}

int pole_map(int map, int element) {
    static const int images[6][2] = {{2, 1}, {1, 2}, {2, 3}, {3, 1}, {1, 3}, {3, 2}};
    return ((element & 2) != 0 ? images[map][0] : 0) ^ ((element & 1) != 0 ? images[map][1] : 0);
}

/* ---- Vectors ---- */

/* The digits of a series times an element. In odd coordinates (u, l) becomes (u + l, l), which
 * makes nets to base 2 of the pairs. */
static uint32_t series_digits(const int *series, int element, int odd) {
    uint32_t v = 0;
    for (int r = 0; r < POLE_DIGITS; ++r) {
        int e = multiply(series[r], element), u = e >> 1, l = e & 1;
        v |= (uint32_t)((u ^ (l & odd)) << 1 | l) << (30 - 2 * r);
    }
    return v;
}

static void series_product(int *a, const int *b) {
    int product[POLE_DIGITS] = {0};
    for (int i = 0; i < POLE_DIGITS; ++i) {
        for (int j = 0; i + j < POLE_DIGITS; ++j) product[i + j] ^= multiply(a[i], b[j]);
    }
    memcpy(a, product, sizeof product);
}

void pole_vectors_make(pole_vectors *v, int c, int b) {
    static const int places[4] = {0, 2, 1, 3};
    for (int d = 0; d < 4; ++d) {
        int g = places[d], odd = d & 1, series[POLE_DIGITS];
        /* X^j = sum of binomial(j, r) g^(j - r) (X - g)^r; odd when r is a bitwise subset of j. */
        for (int j = 0; j < POLE_INDEX_BITS / 2; ++j) {
            for (int r = 0; r < POLE_DIGITS; ++r) {
                series[r] = r <= j && (r & j) == r ? power(g, j - r) : 0;
            }
            v->index[2 * j][d] = series_digits(series, 2, odd);
            v->index[2 * j + 1][d] = series_digits(series, 1, odd);
        }
        /* In Y = X - g: P = Y^2 + b Y + P(g), and 1/P by the recurrence of its coefficients. */
        int value = inverse(multiply(g, g) ^ multiply(b, g) ^ c), inverse_p[POLE_DIGITS];
        for (int n = 0; n < POLE_DIGITS; ++n) {
            int sum = n == 0 ? 2 : multiply(b, inverse_p[n - 1]);
            if (n >= 2) sum ^= inverse_p[n - 2];
            inverse_p[n] = multiply(sum, value);
        }
        int fraction[POLE_DIGITS]; /* 1/P^e */
        memcpy(fraction, inverse_p, sizeof fraction);
        for (int k = 0; k < POLE_LABEL_BITS / 2; ++k) {
            for (int n = 0; n < POLE_DIGITS; ++n) {
                series[n] = fraction[n];
                if ((k & 1) != 0) {
                    series[n] = multiply(g, fraction[n]) ^ (n > 0 ? fraction[n - 1] : 0);
                }
            }
            v->label[2 * k + 1][d] = series_digits(series, 2, odd);
            v->label[2 * k][d] = series_digits(series, 1, odd);
            if ((k & 1) != 0) series_product(fraction, inverse_p);
        }
    }
}

static void add_chosen(const uint32_t vectors[][4], uint32_t bits, uint32_t out[4]) {
    memset(out, 0, 4 * sizeof *out);
    for (int j = 0; bits != 0; bits >>= 1, ++j) {
        for (int d = 0; d < 4 && (bits & 1u) != 0; ++d) out[d] ^= vectors[j][d];
    }
}

void pole_label_shift(const pole_vectors *v, uint32_t label, uint32_t out[4]) {
    add_chosen(v->label, label, out);
}

void pole_index_point(const pole_vectors *v, uint32_t index, uint32_t out[4]) {
    add_chosen(v->index, index, out);
}

void pole_add_digit(pole_vectors *v, int d, int from, int to) {
    assert(from < to);
    for (int k = 0; k < POLE_VECTORS; ++k) {
        uint32_t *digits = pole_vector(v, k) + d;
        *digits ^= (*digits >> (31 - from) & 1u) << (31 - to);
    }
}

void pole_add_index(pole_vectors *v, int from, int to) {
    assert(from < to);
    for (int d = 0; d < 4; ++d) v->index[to][d] ^= v->index[from][d];
}

/* ---- Ranks ---- */

void pole_rows(const pole_vectors *v, int d, int bits, uint64_t *rows) {
    for (int i = 0; i < bits; ++i) {
        uint64_t row = 0;
        for (int j = 0; j < POLE_INDEX_BITS; ++j) {
            row |= (uint64_t)(v->index[j][d] >> (31 - i) & 1u) << j;
        }
        for (int j = 0; j < POLE_LABEL_BITS; ++j) {
            row |= (uint64_t)(v->label[j][d] >> (31 - i) & 1u) << (32 + j);
        }
        rows[i] = row;
    }
}

int pole_rank(uint64_t *rows, int n) {
    int rank = 0;
    for (int i = 0; i < n; ++i) {
        uint64_t row = rows[i];
        if (row == 0) continue;
        uint64_t lowest = row & (0 - row);
        for (int k = i + 1; k < n; ++k) rows[k] ^= (rows[k] & lowest) != 0 ? row : 0;
        ++rank;
    }
    return rank;
}

int pole_net_defects(const pole_vectors *v, int pair, int m, int b) {
    uint64_t first[32], second[32], rows[64];
    uint64_t kept = (((uint64_t)1 << m) - 1) | (((uint64_t)1 << b) - 1) << 32;
    int n = m + b, defects = 0;
    pole_rows(v, 2 * pair, n, first);
    pole_rows(v, 2 * pair + 1, n, second);
    for (int a = 0; a <= n; ++a) {
        for (int i = 0; i < n; ++i) rows[i] = (i < a ? first[i] : second[i - a]) & kept;
        defects += n - pole_rank(rows, n);
    }
    return defects;
}
