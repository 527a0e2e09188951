/* SPDX-License-Identifier: Apache-2.0
 * The first stage of bn_bake_sampler: vectors and labels to begin with.
 *
 * The pair (0, 1) of member 0 is the position in the pixel, whose edges lie along rows and columns.
 * Annealing chooses linear maps of its digits and of its labels' bits, nested so that aligned
 * blocks keep their labels, for which the samples of 2, 4, 8 pixels one below the other are
 * stratified in dimension 0, and those of pixels side by side in dimension 1, while both pairs stay
 * nets to base 2. Seconds. */
#include "bake_tile.h"
#include <math.h>
#include <string.h>

enum { SEARCHED = 7, LABEL_DIGITS = POLE_LABEL_BITS / 2 };

/* Which of the six maps each digit goes through, and what label bits are added to higher ones. */
typedef struct {
    int index[POLE_DIGITS], label[LABEL_DIGITS], coordinate[4][POLE_DIGITS];
    uint32_t below[POLE_LABEL_BITS];
} digit_choice;

static void map_bits(uint32_t (*vectors)[4], int digits, const int *maps) {
    for (int j = 0; j < digits; ++j) {
        for (int d = 0; d < 4; ++d) {
            uint32_t low = vectors[2 * j][d], high = vectors[2 * j + 1][d];
            for (int k = 0; k < 2; ++k) {
                int e = pole_map(maps[j], 2 - k);
                vectors[2 * j + 1 - k][d] = ((e & 2) != 0 ? high : 0) ^ ((e & 1) != 0 ? low : 0);
            }
        }
    }
}

static uint32_t map_coordinate(uint32_t v, const int *maps) {
    uint32_t out = 0;
    for (int r = 0; r < POLE_DIGITS; ++r) {
        out |= (uint32_t)pole_map(maps[r], (int)(v >> (30 - 2 * r) & 3u)) << (30 - 2 * r);
    }
    return out;
}

static void apply_choice(pole_vectors *v, const digit_choice *choice) {
    for (int d = 0; d < 4; ++d) {
        for (int k = 0; k < POLE_VECTORS; ++k) {
            uint32_t *digits = pole_vector(v, k) + d;
            *digits = map_coordinate(*digits, choice->coordinate[d]);
        }
    }
    map_bits(v->index, POLE_DIGITS, choice->index);
    map_bits(v->label, LABEL_DIGITS, choice->label);
    for (int j = POLE_LABEL_BITS - 1; j > 0; --j) {
        for (int i = 0; i < j; ++i) {
            for (int d = 0; d < 4 && (choice->below[j] >> i & 1u) != 0; ++d) {
                v->label[j][d] ^= v->label[i][d];
            }
        }
    }
}

/* By how much 2^m samples of 2^t pixels in a line fail to be stratified in dimension d. */
static int step_defects(const uint64_t rows[16], int d, int m, int t) {
    uint64_t kept = ((uint64_t)1 << m) - 1, chosen[16];
    for (int j = 0; j < t; ++j) kept |= (uint64_t)1 << (32 + 2 * j + (d == 0));
    for (int i = 0; i < m + t; ++i) chosen[i] = rows[i] & kept;
    return m + t - pole_rank(chosen, m + t);
}

static double cost(const pole_vectors *v, double unless_below) {
    static const double weight[5] = {0, 1, 0.8, 0.6, 0.3};
    double sum = 0;
    for (int d = 0; d < 2; ++d) {
        uint64_t rows[16];
        pole_rows(v, d, 16, rows);
        for (int t = 1; t <= 4; ++t) {
            for (int m = 0; m <= 8; ++m) sum += weight[t] * step_defects(rows, d, m, t);
        }
    }
    for (int pair = 0; pair < 2 && sum < unless_below; ++pair) {
        for (int m = 1; m <= 8; ++m) sum += 1000.0 * pole_net_defects(v, pair, m, 0);
        for (int b = 2; b <= 4 && sum < unless_below; b += 2) {
            for (int m = 0; m <= 6; ++m) sum += 0.02 * pole_net_defects(v, pair, m, b);
        }
    }
    return sum;
}

static void change(digit_choice *choice, bake_random *r) {
    for (uint32_t n = 1 + bake_random_below(r, 3); n > 0; --n) {
        uint32_t kind = bake_random_below(r, 100);
        int map = (int)bake_random_below(r, 6);
        if (kind < 15) {
            choice->index[bake_random_below(r, 5)] = map;
        } else if (kind < 30) {
            choice->label[bake_random_below(r, 4)] = map;
        } else if (kind < 60) {
            uint32_t d = bake_random_below(r, 2);
            choice->coordinate[d][bake_random_below(r, SEARCHED)] = map;
        } else {
            uint32_t j = 1 + bake_random_below(r, 7);
            choice->below[j] ^= 1u << bake_random_below(r, j);
        }
    }
}

/* Digits from the fifth on, one after the other, so that all 2^m samples are nets. */
static int complete(digit_choice *choice, const pole_vectors *base, pole_vectors *out) {
    for (int r = 4; r < POLE_DIGITS; ++r) {
        digit_choice from = *choice;
        int good = 0;
        for (int k = 0; k < 6 * 6 * 6 * 6 * 6 && !good; ++k) {
            int rest = k / 6;
            choice->index[r] = (from.index[r] + k % 6) % 6;
            for (int d = 0; d < 4; ++d, rest /= 6) {
                choice->coordinate[d][r] = (from.coordinate[d][r] + rest % 6) % 6;
            }
            *out = *base;
            apply_choice(out, choice);
            good = 1;
            for (int pair = 0; pair < 2 && good; ++pair) {
                for (int m = 2 * r + 1; m <= 2 * r + 2 && good; ++m) {
                    good = pole_net_defects(out, pair, m, 0) == 0;
                }
            }
        }
        if (!good) return 0;
    }
    return 1;
}

static void film_digits(pole_vectors *v, const bake_options *options) {
    pole_vectors base = *v;
    for (uint64_t attempt = 0;; ++attempt) {
        bake_random r = bake_random_make(options->seed, 1, attempt);
        digit_choice now, best;
        memset(&now, 0, sizeof now);
        best = now;
        double energy = cost(&base, 1e30), least = energy;
        int steps = bake_count(options, 40000, 200);
        for (int i = 0; i < steps; ++i) {
            digit_choice next = now;
            pole_vectors made = base;
            double temperature = 2 * pow(0.01, (double)i / steps);
            double limit = energy - temperature * log(1 - bake_random_double(&r));
            change(&next, &r);
            apply_choice(&made, &next);
            double e = cost(&made, limit);
            if (e > limit) continue;
            now = next;
            energy = e;
            if (e < least) {
                least = e;
                best = next;
            }
            if (i % 256 == 0) options->progress((double)i / steps);
        }
        if (complete(&best, &base, v)) {
            return;
        }
    }
}

void bake_start(bake_table *table, const bake_options *options, int member, int number) {
    (void)member, (void)number;
    /* c and b of X^2 + b X + c: (w + 1, w + 1), (1, w + 1), (1, w), (w, w). */
    static const int quadratic[MEMBERS][2] = {{3, 3}, {2, 3}, {2, 1}, {1, 1}};
    for (int a = 0; a < MEMBERS; ++a) {
        pole_vectors_make(&table->member[a], quadratic[a][0], quadratic[a][1]);
        bake_tree_labels(table->label[a], options->seed, a != 0);
    }
    film_digits(&table->member[0], options);
}
