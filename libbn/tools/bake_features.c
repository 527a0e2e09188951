/* SPDX-License-Identifier: Apache-2.0
 * Features of labels for bn_bake_sampler: vectors whose inner products are those of the errors that
 * labels make for many integrands, at all counts of samples.
 *
 * Thousands of errors a label are projected to their principal components, found by subspace
 * iteration from a random start (Halko, Martinsson and Tropp, "Finding Structure with Randomness",
 * 2011). An error counts by its size relative to the mean square of its integrands at its count,
 * times a weight. Seconds a member. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 16, ITERATIONS = 4 };

/* ---- Principal components ---- */

/* out (count x width) = rows (count x inner) times right (inner x width); `width` is a multiple of
 * LANES. */
static void multiply(const float *rows, const float *right, float *out, int count, int inner,
                     int width) {
    memset(out, 0, (size_t)count * width * sizeof *out);
    for (int from = 0; from < inner; from += 128) { /* of `right`, as much as a cache holds */
        int to = from + 128 < inner ? from + 128 : inner;
        for (int i = 0; i < count; ++i) {
            const float *row = rows + (size_t)i * inner;
            float *sum = out + (size_t)i * width;
            int j = from;
            for (; j + 4 <= to; j += 4) {
                const float *r = right + (size_t)j * width;
                float a = row[j], b = row[j + 1], c = row[j + 2], d = row[j + 3];
                for (int k = 0; k < width; ++k) {
                    sum[k] +=
                        a * r[k] + b * r[width + k] + c * r[2 * width + k] + d * r[3 * width + k];
                }
            }
            for (; j < to; ++j) {
                const float *r = right + (size_t)j * width;
                for (int k = 0; k < width; ++k) sum[k] += row[j] * r[k];
            }
        }
    }
}

/* out (inner x width) += the transpose of rows (count x inner) times left (count x width). */
static void multiply_transposed(const float *rows, const float *left, float *out, int count,
                                int inner, int width) {
    memset(out, 0, (size_t)inner * width * sizeof *out);
    for (int i = 0; i + 4 <= count; i += 4) {
        const float *row = rows + (size_t)i * inner, *l = left + (size_t)i * width;
        for (int j = 0; j < inner; ++j) {
            float a = row[j], b = row[inner + j], c = row[2 * (size_t)inner + j],
                  d = row[3 * (size_t)inner + j];
            float *sum = out + (size_t)j * width;
            for (int k = 0; k < width; ++k) {
                sum[k] += a * l[k] + b * l[width + k] + c * l[2 * width + k] + d * l[3 * width + k];
            }
        }
    }
}

/* Gram-Schmidt on the columns, twice for precision; on a transposed copy. */
static void orthonormalise(float *z, int count, int width) {
    int padded = (count + LANES - 1) / LANES * LANES;
    float *t = bake_allocate((size_t)padded * width, sizeof *t);
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < width; ++k) t[(size_t)k * padded + i] = z[(size_t)i * width + k];
    }
    for (int k = 0; k < width; ++k) {
        float *a = t + (size_t)k * padded;
        for (int turn = 0; turn < 2 * k; ++turn) {
            const float *b = t + (size_t)(turn % k) * padded;
            const float sum = bake_inner_product(a, b, padded);
            for (int i = 0; i < padded; ++i) a[i] -= sum * b[i];
        }
        float scale = (float)(1 / sqrt(bake_mean_square(a, padded) * padded + 1e-30));
        for (int i = 0; i < padded; ++i) a[i] *= scale;
    }
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < width; ++k) z[(size_t)i * width + k] = t[(size_t)k * padded + i];
    }
    free(t);
}

/* Projects `count` rows of `inner` numbers to `width`, in directions that come from every `step`-th
 * row. */
static void project(const float *rows, int count, int step, int inner, int width, float *out) {
    int judged = count / step / 4 * 4;
    float *some = bake_allocate((size_t)judged * inner, sizeof *some);
    for (int i = 0; i < judged; ++i) {
        memcpy(some + (size_t)i * inner, rows + (size_t)i * step * inner,
               (size_t)inner * sizeof *some);
    }
    float *z = bake_allocate((size_t)inner * width, sizeof *z);
    bake_random r = bake_random_make(5, 4, 0);
    for (int i = 0; i < inner * width; ++i) z[i] = (float)(bake_random_double(&r) - 0.5);
    orthonormalise(z, inner, width);
    for (int i = 0; i < ITERATIONS; ++i) {
        multiply(some, z, out, judged, inner, width);
        multiply_transposed(some, out, z, judged, inner, width);
        orthonormalise(z, inner, width);
    }
    multiply(rows, z, out, count, inner, width);
    free(z);
    free(some);
}

/* ---- Errors ---- */

/* The errors of one kind of integrand: columns of a matrix with `stride` numbers in a row. */
typedef struct {
    float *rows;
    int stride, used;
} error_matrix;

/* At powers of two, then at `partials` counts between them. */
static void put_errors(float *out, const uint64_t *bits, int levels, int partials,
                       const bake_sample_order *order, double mean) {
    bake_prefix_errors(bits, levels, mean, out, 1);
    for (int c = 0; c < partials; ++c) {
        int inside = __builtin_popcountll(bits[0] & order->mask[c]);
        out[levels + c] = (float)(inside / (double)bake_partial_count[c] - mean);
    }
}

/* Scales columns first to used - 1, levels innermost, so that the squares of each level have the
 * mean weight[level] over labels, summed over integrands. */
static void weigh(error_matrix *m, int count, int first, int levels, const double *weight) {
    double square[LEVELS + PARTIALS] = {0};
    for (int i = 0; i < count; ++i) {
        const float *row = m->rows + (size_t)i * m->stride;
        for (int j = first; j < m->used; ++j) square[(j - first) % levels] += row[j] * row[j];
    }
    for (int l = 0; l < levels; ++l) square[l] = sqrt(weight[l] * count / square[l]);
    for (int i = 0; i < count; ++i) {
        float *row = m->rows + (size_t)i * m->stride;
        for (int j = first; j < m->used; ++j) row[j] *= (float)square[(j - first) % levels];
    }
}

/* Planes for pair 0 and 1, and which of both an integrand is the product of. With a width, a Gaussian
 * bump of this width at a place instead, in one or two dimensions. */
typedef struct {
    bake_plane plane[2];
    int uses; /* 1, 2 or 3 for both */
    float width, along_x, along_y, x, y;
} label_integrand;

/* The errors of a bump at all counts. Its mean is that of its samples over all labels. */
static void put_bump(float *out, const label_integrand *f, const float *x, const float *y,
                     int partials, const bake_sample_order *order) {
    float value[POINTS], sum = 0, partial[PARTIALS] = {0};
    for (int i = 0; i < POINTS; ++i) {
        float dx = x[i] - f->x, dy = y[i] - f->y;
        value[i] = expf(-(f->along_x * dx * dx + f->along_y * dy * dy) / (2 * f->width * f->width));
    }
    for (int i = 0, l = 0; i < POINTS; ++i) {
        sum += value[i];
        if ((i & (i + 1)) == 0) out[l++] = sum / (float)(i + 1);
    }
    for (int i = 0; i < 64; ++i) {
        for (int c = 0; c < partials; ++c) {
            if (order->mask[c] >> i & 1u) partial[c] += value[i];
        }
    }
    for (int c = 0; c < partials; ++c) out[LEVELS + c] = partial[c] / (float)bake_partial_count[c];
}

/* Subtracts the mean of every column. */
static void centre(error_matrix *m, int first) {
    for (int j = first; j < m->used; ++j) {
        double mean = 0;
        for (int i = 0; i < PIXELS; ++i) mean += m->rows[(size_t)i * m->stride + j];
        for (int i = 0; i < PIXELS; ++i)
            m->rows[(size_t)i * m->stride + j] -= (float)(mean / PIXELS);
    }
}

/* Two integrands share a domain: the random digits of its coordinates, and its order. */
static void add_integrands(error_matrix *m, const bake_pair pairs[2], const label_integrand *list,
                           int n, int partials, const double *weight, bake_random *r) {
    enum { GROUP = 2 };
    float x[2][POINTS], y[2][POINTS];
    int first = m->used, columns = LEVELS + partials;
    m->used += n * columns;
    for (int from = 0; from < n; from += GROUP) {
        int to = from + GROUP < n ? from + GROUP : n;
        bake_key key[2] = {bake_key_make(r), bake_key_make(r)};
        bake_sample_order order = bake_sample_order_make(r);
        for (int label = 0; label < PIXELS; ++label) {
            float *row = m->rows + (size_t)label * m->stride + first;
            for (int k = 0; k < 2; ++k) {
                bake_pair_points(&pairs[k], (uint32_t)label, key[k], POINTS, x[k], y[k]);
            }
            for (int f = from; f < to; ++f) {
                uint64_t bits[4] = {~(uint64_t)0, ~(uint64_t)0, ~(uint64_t)0, ~(uint64_t)0};
                double mean = 1;
                if (list[f].width > 0) {
                    int k = list[f].uses - 1;
                    put_bump(row + f * columns, &list[f], x[k], y[k], partials, &order);
                    continue;
                }
                for (int k = 0; k < 2; ++k) {
                    uint64_t one[4];
                    if ((list[f].uses >> k & 1) == 0) continue;
                    bake_plane_bits(&list[f].plane[k], x[k], y[k], POINTS, one);
                    for (int w = 0; w < 4; ++w) bits[w] &= one[w];
                    mean *= list[f].plane[k].mean;
                }
                put_errors(row + f * columns, bits, LEVELS, partials, &order, mean);
            }
        }
    }
    if (list[0].width > 0) centre(m, first);
    weigh(m, PIXELS, first, columns, weight);
}

static label_integrand bump_make(bake_random *r, int pair, int along_x, int along_y) {
    label_integrand bump = {.uses = 1 << pair,
                            .width = (float)(0.12 + 0.3 * bake_random_double(r)),
                            .along_x = (float)along_x,
                            .along_y = (float)along_y};
    bump.x = (float)bake_random_double(r);
    bump.y = (float)bake_random_double(r);
    return bump;
}

/* A share of the full number for a small effort, never more. */
static int fewer(const bake_options *options, int full, int least) {
    double effort = options->effort < 1 ? options->effort : 1;
    int n = (int)(full * effort);
    return n > least ? n : least;
}

/* Projects `count` rows, which are freed. */
static void make_features(bake_features *f, error_matrix *m, int count, int step, int width) {
    f->width = width;
    f->rows = bake_allocate((size_t)count * width, sizeof *f->rows);
    project(m->rows, count, step, m->stride, width, f->rows);
    free(m->rows);
}

void bake_features_of_label(bake_features *f, const bake_table *table, const bake_options *options,
                            int member, int what) {
    /* At 1, 2, 4 ... 256 samples, then at the counts between. */
    static const double plane_weight[] = {1.9, 1.5, 1.4, 1.5, 1.3, 1.3, 1.3, .6, .5,
                                          .8,  .7,  .7,  .5,  .6,  .5,  .6,  .4, .5};
    static const double product_weight[] = {1.1, 1.1, 1.1, 1.2, 1,  1,  1,  .5, .4,
                                            .5,  .4,  .4,  .3,  .4, .3, .4, .3, .3};
    static const double bump_weight[] = {.5, .4, .4, .3, .3, .2, .2, .1, .1,
                                         .3, .3, .3, .2, .2, .2, .2, .1, .1};
    static const double step_weight[] = {3, 1.5, 1.8, 1.2, 1.4, 1, 1, .4, .3};
    static const double axes_weight[] = {1, 1, 1, 1, 1, .7, .7, .4, .4};
    static const double single_weight[] = {1.5, 1.5, 1.5, 1.5, 1.4, 1.2, 1.2, .5, .4};
    enum { MOST = 160 };
    static label_integrand list[MOST];
    static bake_pair pairs[2];
    int planes = fewer(options, 112, 8), both = fewer(options, 160, 8);
    int bumps = fewer(options, 32, 8), steps = fewer(options, 48, 8), axes = fewer(options, 20, 4);
    int own = (2 * planes + both + 2 * bumps) * (LEVELS + PARTIALS);
    error_matrix m = {NULL,
                      what == FEATURES_OWN       ? own
                      : what == FEATURES_AXES    ? (member == 0 ? 2 : 4) * axes * LEVELS
                      : what == FEATURES_SINGLES ? 4 * steps * LEVELS
                                                 : steps * LEVELS,
                      0};
    m.rows = bake_allocate((size_t)PIXELS * m.stride, sizeof *m.rows);
    for (int k = 0; k < 2; ++k) bake_pair_make(&pairs[k], &table->member[member], k);
    bake_random r = bake_random_make(options->seed, 5, (uint64_t)(member * 16 + what));
    memset(list, 0, sizeof list);
    if (what == FEATURES_OWN) {
        for (int kind = 1; kind <= 3; ++kind) {
            int n = kind < 3 ? planes : both;
            for (int i = 0; i < n; ++i) {
                double turns = (i + bake_random_double(&r)) / n;
                list[i].uses = kind;
                list[i].plane[0] = bake_plane_make(&r, kind == 2 ? bake_random_double(&r) : turns);
                list[i].plane[1] = bake_plane_make(&r, kind == 2 ? turns : bake_random_double(&r));
            }
            add_integrands(&m, pairs, list, n, PARTIALS, kind < 3 ? plane_weight : product_weight,
                           &r);
        }
        for (int pair = 0; pair < 2; ++pair) {
            for (int i = 0; i < bumps; ++i) list[i] = bump_make(&r, pair, 1, 1);
            add_integrands(&m, pairs, list, bumps, PARTIALS, bump_weight, &r);
        }
    } else {
        int n = what == FEATURES_AXES ? axes : steps;
        for (int pair = 0; pair < 2; ++pair) {
            for (int d = 0; d < 2; ++d) {
                if (what == FEATURES_AXES
                        ? member == 0 && pair == 0
                        : what != FEATURES_SINGLES && (pair != 0 || d != what - FEATURES_STEP_X)) {
                    continue;
                }
                for (int i = 0; i < n; ++i) {
                    list[i].uses = 1 << pair;
                    list[i].plane[pair] = bake_plane_step(d, (i + bake_random_double(&r)) / n);
                }
                add_integrands(&m, pairs, list, n, 0,
                               what == FEATURES_AXES      ? axes_weight
                               : what == FEATURES_SINGLES ? single_weight
                                                          : step_weight,
                               &r);
            }
        }
    }
    const int most = what == FEATURES_OWN ? 336 : 80;
    make_features(f, &m, PIXELS, 1, fewer(options, most, 32) / LANES * LANES);
}

enum { PLACES = BLOCKS * 16 * 16 };

void bake_features_of_two(bake_features *f, const bake_table *table, const bake_options *options,
                          int first, int second) {
    /* Of the counts between powers of two, the first few. */
    enum { FEW_LEVELS = 7, FEW_PARTIALS = 7, MOST = 40 };
    enum { COLUMNS = FEW_LEVELS + FEW_PARTIALS };
    static const double weight[COLUMNS] = {1.1, 1.2, 1.2, 1.1, 1, 1, 1, .5, .4, .4, .3, .3, .3, .3};
    static bake_plane plane[2][MOST];
    static bake_pair pairs[2];
    int n = fewer(options, MOST, 5) / 5 * 5;
    uint64_t *bits[2];
    bake_random r = bake_random_make(options->seed, 6, (uint64_t)(first * MEMBERS + second));
    for (int side = 0; side < 2; ++side) {
        const pole_vectors *v = &table->member[side == 0 ? first : second];
        float x[2][64], y[2][64];
        bits[side] = bake_allocate((size_t)PIXELS * MOST, sizeof *bits[side]);
        for (int k = 0; k < 2; ++k) bake_pair_make(&pairs[k], v, k);
        for (int i = 0; i < n; ++i) plane[side][i] = bake_plane_make(&r, bake_random_double(&r));
        /* Two in five are of both first pairs. Every five are in a domain of their own. */
        for (int from = 0; from < n; from += 5) {
            bake_key key[2] = {bake_key_make(&r), bake_key_make(&r)};
            for (int label = 0; label < PIXELS; ++label) {
                for (int k = 0; k < 2; ++k) {
                    bake_pair_points(&pairs[k], (uint32_t)label, key[k], 64, x[k], y[k]);
                }
                for (int i = from; i < from + 5; ++i) {
                    int pairing = i % 5 % 4, k = side == 0 ? pairing & 1 : pairing >> 1;
                    bake_plane_bits(&plane[side][i], x[k], y[k], 64, &bits[side][label * MOST + i]);
                }
            }
        }
    }
    bake_sample_order order[MOST / 5];
    for (int i = 0; i < n / 5; ++i) order[i] = bake_sample_order_make(&r);
    error_matrix m = {NULL, n * COLUMNS, n * COLUMNS};
    m.rows = bake_allocate((size_t)PLACES * m.stride, sizeof *m.rows);
    for (int c = 0; c < PLACES; ++c) {
        int block = c >> 8;
        const uint64_t *a = bits[0] + (block << 4 | (c >> 4 & 15)) * MOST;
        const uint64_t *b = bits[1] + (block << 4 | (c & 15)) * MOST;
        for (int i = 0; i < n; ++i) {
            uint64_t both = a[i] & b[i];
            put_errors(m.rows + (size_t)c * m.stride + i * COLUMNS, &both, FEW_LEVELS, FEW_PARTIALS,
                       &order[i / 5], plane[0][i].mean * plane[1][i].mean);
        }
    }
    weigh(&m, PLACES, 0, COLUMNS, weight);
    make_features(f, &m, PLACES, 5, fewer(options, 112, 32) / LANES * LANES);
    free(bits[0]);
    free(bits[1]);
}
