/* SPDX-License-Identifier: Apache-2.0
 * The third stage of bn_bake_sampler: the order of the samples of each member of a family against
 * those of the members before it, so that products over two members are stratified together.
 *
 * An order adds vectors of lower index bits to those of higher ones, which sends every power-of-two
 * prefix to itself. Annealing first minimises how far samples of two members are from nets in their
 * four dimensions, by ranks, and forbids that first digits of two dimensions agree for the first 32
 * samples; then hill climbing measures products of half-planes, after the blur and in the pixel. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNER = 32, PIXEL_COUNT = CORNER * CORNER, PLANES = 16, FEW_LEVELS = 7, MAX_DIGITS = 12 };

/* ---- Ranks ---- */

typedef struct {
    uint64_t row[4][MAX_DIGITS];
} digit_rows;

static void rows_make(digit_rows *rows, const pole_vectors *v) {
    for (int d = 0; d < 4; ++d) pole_rows(v, d, MAX_DIGITS, rows->row[d]);
}

/* Adds a row to a basis in echelon form; whether it was independent of it. */
static int basis_add(uint64_t *basis, int *count, uint64_t row) {
    for (int i = 0; i < *count; ++i) {
        uint64_t lowest = basis[i] & (0 - basis[i]);
        if ((row & lowest) != 0) row ^= basis[i];
    }
    if (row == 0) return 0;
    basis[(*count)++] = row;
    return 1;
}

/* How far 2^m samples of 2^b pixels are from a net in a pair of one member and a pair of the other:
 * the mean over all shapes of intervals of 2^defect - 1, those in many dimensions weighing less. */
static double pair_defect(const digit_rows *first, int p, const digit_rows *second, int q, int m,
                          int b) {
    uint64_t kept = (((uint64_t)1 << m) - 1) | (((uint64_t)1 << b) - 1) << 32;
    int n = m + b, shapes = 0;
    double sum = 0;
    const uint64_t *row[4] = {first->row[2 * p], first->row[2 * p + 1], second->row[2 * q],
                              second->row[2 * q + 1]};
    uint64_t basis[3][2 * MAX_DIGITS];
    int count0 = 0;
    for (int i = 0; i <= n; ++i) {
        if (i > 0) basis_add(basis[0], &count0, row[0][i - 1] & kept);
        int count1 = count0;
        memcpy(basis[1], basis[0], sizeof basis[0]);
        for (int j = 0; i + j <= n; ++j) {
            if (j > 0) basis_add(basis[1], &count1, row[1][j - 1] & kept);
            if (i + j == 0 || i + j == n) continue;
            int count2 = count1;
            memcpy(basis[2], basis[1], sizeof basis[1]);
            for (int k = 0; i + j + k <= n; ++k) {
                if (k > 0) basis_add(basis[2], &count2, row[2][k - 1] & kept);
                uint64_t last[2 * MAX_DIGITS];
                int total = count2, rest = n - i - j - k;
                memcpy(last, basis[2], (size_t)count2 * sizeof *last);
                for (int l = 0; l < rest; ++l) basis_add(last, &total, row[3][l] & kept);
                int many = 1 + (i > 0 && j > 0) + (k > 0 && rest > 0);
                sum += (double)((1 << (n - total)) - 1) / many;
                ++shapes;
            }
        }
    }
    return shapes > 0 ? sum / shapes : 0;
}

static double defect(const digit_rows *first, const digit_rows *second) {
    double sum = 0;
    for (int pairs = 0; pairs < 4; ++pairs) {
        double weight = pairs == 0 ? 0.4 : 0.2;
        for (int m = 2; m <= 7; ++m) {
            sum += weight * pair_defect(first, pairs & 1, second, pairs >> 1, m, 0);
        }
        for (int m = 1; m <= 4; ++m) {
            sum += 0.7 * weight * pair_defect(first, pairs & 1, second, pairs >> 1, m, 4);
        }
    }
    return sum;
}

/* Dimensions of two members whose first digits agree over the first 2^m samples: at 32, these never
 * meet all four quarters. */
static double clash(const digit_rows *first, const digit_rows *second) {
    static const double weight[6] = {0, 0, 0, 0.02, 0.15, 3};
    double sum = 0;
    for (int d = 0; d < 16; ++d) {
        for (int m = 3; m <= 5; ++m) {
            uint64_t kept = ((uint64_t)1 << m) - 1;
            if (((first->row[d & 3][0] ^ second->row[d >> 2][0]) & kept) == 0) sum += weight[m];
        }
    }
    return sum;
}

static void change(pole_vectors *v, bake_random *r) {
    for (uint32_t n = 1 + bake_random_below(r, 3); n > 0; --n) {
        int to = 1 + (int)bake_random_below(r, 7);
        pole_add_index(v, (int)bake_random_below(r, (uint32_t)to), to);
    }
}

/* Against all members before; adds to `defects` unless it is NULL. */
static double clashes(const bake_table *table, int member, const pole_vectors *v, double *defects) {
    digit_rows mine, other;
    double sum = 0;
    rows_make(&mine, v);
    for (int a = 0; a < member; ++a) {
        rows_make(&other, &table->member[a]);
        sum += clash(&other, &mine);
        if (defects != NULL) *defects += defect(&other, &mine);
    }
    return sum;
}

/* ---- Measured products ---- */

typedef struct {
    bake_plane plane[2][4][PLANES]; /* of the earlier member and of this one, by pairing */
    uint64_t earlier[MEMBERS][4][PLANES][PIXEL_COUNT];
    double independent[4][PLANES][FEW_LEVELS];
    bake_pair pair[2];
    bake_key key[MEMBERS][2];
} products;

static void errors_of(const uint64_t *a, const uint64_t *b, double mean,
                      float error[FEW_LEVELS][PIXEL_COUNT]) {
    for (int p = 0; p < PIXEL_COUNT; ++p) {
        uint64_t both = a[p] & b[p];
        bake_prefix_errors(&both, FEW_LEVELS, mean, &error[0][p], PIXEL_COUNT);
    }
}

static void products_of_member(products *s, const pole_vectors *v, const uint16_t *label,
                               int member, int side, int planes,
                               uint64_t out[4][PLANES][PIXEL_COUNT]) {
    for (int k = 0; k < 2; ++k) bake_pair_make(&s->pair[k], v, k);
    for (int p = 0; p < PIXEL_COUNT; ++p) {
        for (int k = 0; k < 2; ++k) {
            float x[64], y[64];
            bake_key key =
                bake_key_of_pixel(s->key[member][k], (uint64_t)((p * MEMBERS + member) * 2 + k));
            bake_pair_points(&s->pair[k], label[p / CORNER * SIDE + p % CORNER], key, 64, x, y);
            for (int pairing = 0; pairing < 4; ++pairing) {
                if ((side == 0 ? pairing & 1 : pairing >> 1) != k) continue;
                for (int f = 0; f < planes; ++f) {
                    bake_plane_bits(&s->plane[side][pairing][f], x, y, 64, &out[pairing][f][p]);
                }
            }
        }
    }
}

static double product_mean(const products *s, int pairing, int f) {
    return s->plane[0][pairing][f].mean * s->plane[1][pairing][f].mean;
}

static void products_begin(products *s, const bake_table *table, int member, bake_random *r,
                           int planes) {
    static float error[FEW_LEVELS][PIXEL_COUNT], x[2][PIXEL_COUNT][64], y[2][PIXEL_COUNT][64];
    static uint64_t bits[2][PIXEL_COUNT];
    for (int p = 0; p < PIXEL_COUNT; ++p) {
        for (int k = 0; k < 2; ++k) bake_sobol_points(p, 1 + (uint32_t)k, 64, x[k][p], y[k][p]);
    }
    for (int pairing = 0; pairing < 4; ++pairing) {
        for (int f = 0; f < planes; ++f) {
            for (int k = 0; k < 2; ++k) {
                s->plane[k][pairing][f] = bake_plane_make(r, bake_random_double(r));
                for (int p = 0; p < PIXEL_COUNT; ++p) {
                    bake_plane_bits(&s->plane[k][pairing][f], x[k][p], y[k][p], 64, &bits[k][p]);
                }
            }
            errors_of(bits[0], bits[1], product_mean(s, pairing, f), error);
            for (int l = 0; l < FEW_LEVELS; ++l) {
                s->independent[pairing][f][l] = sqrt(bake_mean_square(error[l], PIXEL_COUNT));
            }
        }
    }
    for (int a = 0; a < 2 * MEMBERS; ++a) s->key[a / 2][a % 2] = bake_key_make(r);
    for (int a = 0; a < member; ++a) {
        products_of_member(s, &table->member[a], table->label[a], a, 0, planes, s->earlier[a]);
    }
}

static double products_judge(products *s, const bake_table *table, int member,
                             const pole_vectors *v, int planes) {
    static const double aim[FEW_LEVELS] = {.62, .68, .65, .62, .55, .53, .50};
    static const double aim_raw[FEW_LEVELS] = {1, 1, 1, .86, .80, .72, .66};
    static uint64_t mine[4][PLANES][PIXEL_COUNT];
    static float error[FEW_LEVELS][PIXEL_COUNT], image[PIXEL_COUNT];
    double gain = sqrt(bake_blur_gain(3)), sum = 0;
    products_of_member(s, v, table->label[member], member, 1, planes, mine);
    for (int a = 0; a < member; ++a) {
        double blurred[FEW_LEVELS] = {0}, raw[FEW_LEVELS] = {0}, worst = 0;
        for (int pairing = 0; pairing < 4; ++pairing) {
            double weight = pairing == 0 ? 0.4 : 0.2, b[FEW_LEVELS] = {0}, r[FEW_LEVELS] = {0},
                   independent[FEW_LEVELS] = {0};
            for (int f = 0; f < planes; ++f) {
                errors_of(s->earlier[a][pairing][f], mine[pairing][f], product_mean(s, pairing, f),
                          error);
                for (int l = 0; l < FEW_LEVELS; ++l) {
                    bake_blur(error[l], image, CORNER, 3);
                    b[l] += sqrt(bake_mean_square(image, PIXEL_COUNT));
                    r[l] += sqrt(bake_mean_square(error[l], PIXEL_COUNT));
                    independent[l] += s->independent[pairing][f][l];
                }
            }
            for (int l = 0; l < FEW_LEVELS; ++l) {
                blurred[l] += weight * b[l] / (independent[l] * gain);
                raw[l] += weight * r[l] / independent[l];
            }
        }
        for (int l = 0; l < FEW_LEVELS; ++l) {
            double q = blurred[l] / aim[l], u = raw[l] / aim_raw[l];
            worst += (q * q * q + 0.5 * u * u * u) / FEW_LEVELS;
        }
        sum += worst * worst;
    }
    return sum;
}

/* ---- The stage ---- */

void bake_order(bake_table *table, const bake_options *options, int member, int number) {
    (void)number;
    bake_random r = bake_random_make(options->seed, 3, (uint64_t)member);
    pole_vectors now = table->member[member], best = now;
    double energy = 1e30, least = 1e30;
    int steps = bake_count(options, 8000, 20);
    for (int i = 0; i < steps; ++i) {
        pole_vectors v = now;
        double defects = 0, temperature = 0.5 * pow(0.02, (double)i / steps);
        if (i > 0) change(&v, &r);
        double e = clashes(table, member, &v, &defects) + defects;
        if (e > energy - temperature * log(1 - bake_random_double(&r))) continue;
        now = v;
        energy = e;
        if (e < least) {
            least = e;
            best = v;
        }
        if (i % 16 == 0) options->progress(0.3 * i / steps);
    }

    products *s = bake_allocate(1, sizeof *s);
    int trials = bake_count(options, 1500, 2), planes = bake_count(options, PLANES, 4);
    if (planes > PLANES) planes = PLANES;
    products_begin(s, table, member, &r, planes);
    double limit = clashes(table, member, &best, NULL);
    if (limit < 2.9) limit = 2.9; /* no two first digits agree at 32 */
    least = 1e30;
    for (int trial = 0; trial < trials; ++trial) {
        pole_vectors v = best;
        double c = 0;
        if (trial > 0) {
            do {
                v = best;
                change(&v, &r);
                c = clashes(table, member, &v, NULL);
            } while (c > limit);
        }
        double e = c + products_judge(s, table, member, &v, planes);
        if (e < least) {
            least = e;
            best = v;
        }
        if (trial % 4 == 0) options->progress(0.3 + 0.7 * trial / trials);
    }
    table->member[member] = best;
    free(s);
}
