/* SPDX-License-Identifier: Apache-2.0
 * Label features for bn_bake_sampler: vectors whose inner products equal those of the labels' errors for many
 * integrands, at all sample counts.
 *
 * Thousands of errors per label are projected to their principal components, found by subspace iteration from
 * a random start (Halko, Martinsson and Tropp, "Finding Structure with Randomness", 2011). Each error is
 * scaled by the mean square of its integrands at its sample count, times a weight. Takes seconds per
 * member. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LANES = 16, ITERATIONS = 4 };

/* ---- Principal components ---- */

/* out (count x width) = rows (count x inner) times right (inner x width); `inner` is a multiple of 4, and `width`
 * of LANES. */
static void multiply(const float *rows, const float *right, float *out, int count, int inner,
                     int width) {
    memset(out, 0, (size_t)count * width * sizeof *out);
    for (int from = 0; from < inner; from += 128) { /* as much of `right` as a cache holds */
        int to = from + 128 < inner ? from + 128 : inner;
        for (int i = 0; i < count; ++i) {
            const float *row = rows + (size_t)i * inner;
            float *sum = out + (size_t)i * width;
            for (int j = from; j < to; j += 4) {
                const float *r = right + (size_t)j * width;
                float a = row[j], b = row[j + 1], c = row[j + 2], d = row[j + 3];
                for (int k = 0; k < width; ++k) {
                    sum[k] +=
                        a * r[k] + b * r[width + k] + c * r[2 * width + k] + d * r[3 * width + k];
                }
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

/* Applies Gram-Schmidt to the columns, twice for precision, in a transposed copy. */
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
        float scale = (float)(1 / sqrt(bake_add_squares(0, a, padded) / padded * padded + 1e-30));
        for (int i = 0; i < padded; ++i) a[i] *= scale;
    }
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < width; ++k) z[(size_t)i * width + k] = t[(size_t)k * padded + i];
    }
    free(t);
}

/* Projects `count` rows from `inner` to `width` numbers. Uses every `step`-th row to find the
 * directions. */
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

/* ---- Samples ---- */

/* Random digits, which belong to a domain in a copy of the tile and, from the seventeenth on, to a pixel. */
static void key_make(uint32_t key[4], bake_random *r) {
    for (int d = 0; d < 4; d += 2) {
        const uint64_t bits = bake_random_bits(r);
        key[d] = (uint32_t)bits;
        key[d + 1] = (uint32_t)(bits >> 32);
    }
}

/* The four coordinates of a label's first samples. */
static void label_samples(const bake_sums *s, uint32_t label, const uint32_t key[4], int count,
                          float u[4][POINTS]) {
    for (int d = 0; d < 4; ++d) {
        const uint32_t shift = (s->label[label][d] & 0xffff0000u) ^ key[d];
        for (int i = 0; i < count; ++i) {
            u[d][i] = (float)(int32_t)((s->point[i][d] ^ shift) >> 8) * (1.0f / 16777216.0f);
        }
    }
}

/* Sample counts between powers of two. A domain's sample order determines which samples they include. It is
 * stored as a mask of the first 64 samples for each count. */
enum { PARTIALS = 9 };
static const int partial_count[PARTIALS] = {3, 5, 6, 7, 9, 10, 12, 14, 24};

typedef struct {
    uint64_t mask[PARTIALS];
} sample_order;

/* The sample order of bn_draw_blue_digits(), which shuffles the index differently in every domain. */
static sample_order order_make(bake_random *r) {
    sample_order order = {{0}};
    uint32_t shuffle = (uint32_t)bake_random_bits(r);
    for (uint32_t i = 0; i < 64; ++i) {
        uint32_t digits = bn_draw_blue_digits(shuffle, bn_reverse_bits(i), bn_draw_flip(i));
        uint64_t sample = (uint64_t)1 << bn_reverse_bits(digits);
        for (int c = 0; c < PARTIALS; ++c) {
            if ((int)i < partial_count[c]) order.mask[c] |= sample;
        }
    }
    return order;
}

/* ---- Integrands ---- */

/* 1 where a x + b y < c; its mean is its area in the unit square. */
typedef struct {
    float a, b, c;
    double mean;
} half_plane;

/* The area of a x + b y < c in the unit square, found by clipping the square. */
static double plane_mean(double a, double b, double c) {
    static const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    double x[8], y[8], area = 0;
    int n = 0;
    for (int i = 0; i < 4; ++i) {
        const double *p = corner[i], *q = corner[(i + 1) % 4];
        double dp = a * p[0] + b * p[1] - c, dq = a * q[0] + b * q[1] - c;
        if (dp < 0) {
            x[n] = p[0];
            y[n++] = p[1];
        }
        if ((dp < 0) != (dq < 0)) {
            double t = dp / (dp - dq);
            x[n] = p[0] + t * (q[0] - p[0]);
            y[n++] = p[1] + t * (q[1] - p[1]);
        }
    }
    for (int i = 0; i < n; ++i) area += x[i] * y[(i + 1) % n] - x[(i + 1) % n] * y[i];
    return area / 2;
}

/* A half-plane through a random point, at an angle in turns. */
static half_plane plane_make(bake_random *r, double turns) {
    double a = cos(TURN * turns), b = sin(TURN * turns);
    double x = bake_random_double(r), y = bake_random_double(r);
    double c = a * x + b * y;
    const half_plane made = {(float)a, (float)b, (float)c, plane_mean(a, b, c)};
    return made;
}

/* 1 where x or y is below a limit. */
static half_plane plane_step(int dimension, double place) {
    const half_plane made = {dimension == 0, dimension == 1, (float)place, place};
    return made;
}

/* A mask of the points (64 or 256) that lie inside. */
static void plane_bits(const half_plane *p, const float *x, const float *y, int count,
                       uint64_t *bits) {
    for (int word = 0; word < count / 64; ++word, x += 64, y += 64) {
        bits[word] = 0;
        for (int i = 0; i < 64; ++i) {
            bits[word] |= (uint64_t)(p->a * x[i] + p->b * y[i] < p->c) << i;
        }
    }
}

/* ---- Errors ---- */

/* The errors of one type of integrand: columns of a matrix with `stride` numbers per row, a multiple of 4. */
typedef struct {
    float *rows;
    int stride, used;
} error_matrix;

/* Writes the share of set bits minus `mean`, at powers of two and then at `partials` counts between them. */
static void put_errors(float *out, const uint64_t *bits, int levels, int partials,
                       const sample_order *order, double mean) {
    for (int l = 0; l < levels; ++l) {
        const uint64_t mask = l < 6 ? ((uint64_t)1 << (1 << l)) - 1 : ~(uint64_t)0;
        int inside = 0;
        for (int word = 0; word < (l < 7 ? 1 : 1 << (l - 6)); ++word) {
            inside += __builtin_popcountll(bits[word] & mask);
        }
        out[l] = (float)(inside / (double)(1 << l) - mean);
    }
    for (int c = 0; c < partials; ++c) {
        int inside = __builtin_popcountll(bits[0] & order->mask[c]);
        out[levels + c] = (float)(inside / (double)partial_count[c] - mean);
    }
}

/* Scales columns `first` to used - 1, whose innermost index is the level, so that each level's
 * squares, summed over integrands, have the mean weight[level] over labels. */
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

/* Half-planes for pairs 0 and 1; an integrand is one of them or their product. If `width` is set, it is a
 * Gaussian bump of this width instead. */
typedef struct {
    half_plane plane[2];
    int uses; /* 1, 2 or 3 for both */
    float width, x, y;
} label_integrand;

/* The errors of a bump at all counts, relative to the mean of its samples over all labels. */
static void put_bump(float *out, const label_integrand *f, const float *x, const float *y,
                     int partials, const sample_order *order) {
    float value[POINTS], sum = 0, partial[PARTIALS] = {0};
    for (int i = 0; i < POINTS; ++i) {
        float dx = x[i] - f->x, dy = y[i] - f->y;
        value[i] = expf(-(dx * dx + dy * dy) / (2 * f->width * f->width));
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
    for (int c = 0; c < partials; ++c) out[LEVELS + c] = partial[c] / (float)partial_count[c];
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

/* Every two integrands share a domain's random digits and sample order. */
static void add_integrands(error_matrix *m, const bake_sums *sums, const label_integrand *list,
                           int n, int partials, const double *weight, bake_random *r) {
    enum { GROUP = 2 };
    float u[4][POINTS];
    int first = m->used, columns = LEVELS + partials;
    m->used += n * columns;
    for (int from = 0; from < n; from += GROUP) {
        uint32_t key[4];
        key_make(key, r);
        const sample_order order = order_make(r);
        for (int label = 0; label < PIXELS; ++label) {
            float *row = m->rows + (size_t)label * m->stride + first;
            label_samples(sums, (uint32_t)label, key, POINTS, u);
            for (int f = from; f < from + GROUP; ++f) {
                uint64_t bits[4] = {~(uint64_t)0, ~(uint64_t)0, ~(uint64_t)0, ~(uint64_t)0};
                double mean = 1;
                if (list[f].width > 0) {
                    const int d = 2 * (list[f].uses - 1);
                    put_bump(row + f * columns, &list[f], u[d], u[d + 1], partials, &order);
                    continue;
                }
                for (int k = 0; k < 2; ++k) {
                    uint64_t one[4];
                    if ((list[f].uses >> k & 1) == 0) continue;
                    plane_bits(&list[f].plane[k], u[2 * k], u[2 * k + 1], POINTS, one);
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

static label_integrand bump_make(bake_random *r, int pair) {
    label_integrand bump = {.uses = 1 << pair,
                            .width = (float)(0.12 + 0.3 * bake_random_double(r))};
    bump.x = (float)bake_random_double(r);
    bump.y = (float)bake_random_double(r);
    return bump;
}

/* A multiple of `unit`: the full number, or a fraction of it at low effort. */
static int fewer(const bake_options *options, int full, int unit) {
    const double effort = options->effort < 1 ? options->effort : 1;
    const int n = (int)(full * effort) / unit * unit;
    return n > unit ? n : unit;
}

/* Projects `count` rows, and frees them. */
static bake_features make_features(error_matrix *m, int count, int step, int width) {
    bake_features f = {width, bake_allocate((size_t)count * width, sizeof *f.rows)};
    project(m->rows, count, step, m->stride, width, f.rows);
    free(m->rows);
    return f;
}

bake_features bake_features_of_label(const bake_table *table, const bake_options *options,
                                     int member, int what) {
    /* At 1, 2, 4 ... 256 samples, then at the counts in between. */
    static const double plane_weight[] = {1.9, 1.5, 1.4, 1.5, 1.3, 1.3, 1.3, .6, .5,
                                          .8,  .7,  .7,  .5,  .6,  .5,  .6,  .4, .5};
    static const double product_weight[] = {1.1, 1.1, 1.1, 1.2, 1,  1,  1,  .5, .4,
                                            .5,  .4,  .4,  .3,  .4, .3, .4, .3, .3};
    static const double bump_weight[] = {.5, .4, .4, .3, .3, .2, .2, .1, .1,
                                         .3, .3, .3, .2, .2, .2, .2, .1, .1};
    static const double step_weight[] = {3, 1.5, 1.8, 1.2, 1.4, 1, 1, .4, .3};
    static const double axes_weight[] = {1, 1, 1, 1, 1, .7, .7, .4, .4};
    static const double single_weight[] = {1.5, 1.5, 1.5, 1.5, 1.4, 1.2, 1.2, .5, .4};
    /* `dimensions` is a bit set; `full` is the number of steps in each of them. */
    static const struct {
        int dimensions, full;
        const double *weight;
    } kinds[] = {[FEATURES_STEP_X] = {1, 48, step_weight},
                 [FEATURES_STEP_Y] = {2, 48, step_weight},
                 [FEATURES_AXES] = {15, 20, axes_weight},
                 [FEATURES_SINGLES] = {15, 48, single_weight}};
    enum { MOST = 160 };
    static label_integrand list[MOST];
    static bake_sums sums;
    error_matrix m = {NULL, 0, 0};
    bake_sums_make(&sums, &table->member[member]);
    bake_random r = bake_random_make(options->seed, 5, (uint64_t)(member * 16 + what));
    memset(list, 0, sizeof list);
    if (what == FEATURES_OWN) {
        const int planes = fewer(options, 112, 4), both = fewer(options, 160, 4);
        const int bumps = fewer(options, 32, 4);
        m.stride = (2 * planes + both + 2 * bumps) * (LEVELS + PARTIALS);
        m.rows = bake_allocate((size_t)PIXELS * m.stride, sizeof *m.rows);
        for (int kind = 1; kind <= 3; ++kind) {
            int n = kind < 3 ? planes : both;
            for (int i = 0; i < n; ++i) {
                double turns = (i + bake_random_double(&r)) / n;
                list[i].uses = kind;
                list[i].plane[0] = plane_make(&r, kind == 2 ? bake_random_double(&r) : turns);
                list[i].plane[1] = plane_make(&r, kind == 2 ? turns : bake_random_double(&r));
            }
            add_integrands(&m, &sums, list, n, PARTIALS, kind < 3 ? plane_weight : product_weight,
                           &r);
        }
        for (int pair = 0; pair < 2; ++pair) {
            for (int i = 0; i < bumps; ++i) list[i] = bump_make(&r, pair);
            add_integrands(&m, &sums, list, bumps, PARTIALS, bump_weight, &r);
        }
    } else {
        const int n = fewer(options, kinds[what].full, 4);
        const int dimensions = what == FEATURES_AXES && member == 0 ? 12 : kinds[what].dimensions;
        m.stride = __builtin_popcount((unsigned)dimensions) * n * LEVELS;
        m.rows = bake_allocate((size_t)PIXELS * m.stride, sizeof *m.rows);
        for (int d = 0; d < 4; ++d) {
            if ((dimensions >> d & 1) == 0) continue;
            for (int i = 0; i < n; ++i) {
                list[i].uses = 1 << d / 2;
                list[i].plane[d / 2] = plane_step(d & 1, (i + bake_random_double(&r)) / n);
            }
            add_integrands(&m, &sums, list, n, 0, kinds[what].weight, &r);
        }
    }
    const int most = what == FEATURES_OWN ? 336 : 80;
    return make_features(&m, PIXELS, 1, fewer(options, most, LANES));
}

enum { PLACES = BLOCKS * 16 * 16 };

bake_features bake_features_of_two(const bake_table *table, const bake_options *options, int first,
                                   int second) {
    /* Uses only the first few counts between powers of two. */
    enum { FEW_LEVELS = 7, FEW_PARTIALS = 7, MOST = 40 };
    enum { COLUMNS = FEW_LEVELS + FEW_PARTIALS };
    static const double weight[COLUMNS] = {1.1, 1.2, 1.2, 1.1, 1, 1, 1, .5, .4, .4, .3, .3, .3, .3};
    static half_plane plane[2][MOST];
    static bake_sums sums;
    int n = fewer(options, MOST, 10);
    uint64_t *bits[2];
    bake_random r = bake_random_make(options->seed, 6, (uint64_t)(first * MEMBERS + second));
    for (int side = 0; side < 2; ++side) {
        float u[4][POINTS];
        bits[side] = bake_allocate((size_t)PIXELS * MOST, sizeof *bits[side]);
        bake_sums_make(&sums, &table->member[side == 0 ? first : second]);
        for (int i = 0; i < n; ++i) plane[side][i] = plane_make(&r, bake_random_double(&r));
        /* Two in five integrands use both first pairs. Every five integrands share a domain. */
        for (int from = 0; from < n; from += 5) {
            uint32_t key[4];
            key_make(key, &r);
            for (int label = 0; label < PIXELS; ++label) {
                label_samples(&sums, (uint32_t)label, key, 64, u);
                for (int i = from; i < from + 5; ++i) {
                    const int pairing = i % 5 % 4, d = side == 0 ? (pairing & 1) * 2 : pairing & 2;
                    plane_bits(&plane[side][i], u[d], u[d + 1], 64, &bits[side][label * MOST + i]);
                }
            }
        }
    }
    sample_order order[MOST / 5];
    for (int i = 0; i < n / 5; ++i) order[i] = order_make(&r);
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
    free(bits[0]);
    free(bits[1]);
    return make_features(&m, PLACES, 5, fewer(options, 112, LANES));
}
