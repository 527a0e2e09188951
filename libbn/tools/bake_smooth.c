/* SPDX-License-Identifier: Apache-2.0
 * Errors of smooth integrands in single pixels, for bn_bake_sampler.
 *
 * All pixels share one linear scrambling of each coordinate and differ by a digital shift. This does not
 * matter for a step, but it does for a smooth function: the digit after the first m digits of 2^m samples
 * is a sum of some of those m, and the choice of sum determines the error. The error falls as 1/N if the
 * sum is empty or consists of coarse digits, and as 1/N^2 if it includes the adjacent digit (Dick, "Walsh
 * spaces containing smooth functions and quasi-Monte Carlo rules of arbitrary high order", 2008). The
 * energy is the mean logarithm of errors relative to Sobol', over random shifts of waves, bumps and ramps
 * in one to four dimensions. Takes a millisecond. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    DIGITS = 12,
    CELLS = 1 << DIGITS,
    SHIFTS = 32,
    SINGLES = 8,
    MIXED = 40,
    FACTORS = SINGLES + MIXED,
    SUMS = 4 * SINGLES + 84
};
enum { GROUPS = 12, FEW_LEVELS = 7 };

/* Functions are products of one-dimensional functions, stored in tables. */
typedef struct {
    int group, dimensions, factor[4], dimension[4];
    double mean, sobol[LEVELS];
} smooth_function;

struct bake_smooth_judge {
    float factor[FACTORS][CELLS];
    double factor_mean[FACTORS];
    smooth_function f[SUMS];
    int count, factors;
    uint32_t shift[SHIFTS][4];
};

/* ---- Integrands ---- */

typedef struct {
    int kind; /* a wave, a bump, a power or an interval */
    double a, b, c;
} curve;

static double curve_at(const curve *f, double u) {
    if (f->kind == 0) return f->c + cos(TURN * (f->a * u + f->b));
    if (f->kind == 1) return exp(-(u - f->a) * (u - f->a) / (2 * f->b * f->b));
    if (f->kind == 2) return pow(u, f->a);
    return floor(u * f->a) == f->b;
}

static int add_factor(bake_smooth_judge *j, curve f) {
    double sum = 0;
    for (int i = 0; i < CELLS; ++i) {
        double v = curve_at(&f, (i + 0.5) / CELLS);
        j->factor[j->factors][i] = (float)v;
        sum += v;
    }
    j->factor_mean[j->factors] = sum / CELLS;
    return j->factors++;
}

static void add_function(bake_smooth_judge *j, int group, int dimensions, const int *factor,
                         const int *dimension) {
    smooth_function *f = &j->f[j->count++];
    f->group = group;
    f->dimensions = dimensions;
    f->mean = 1;
    for (int k = 0; k < dimensions; ++k) {
        f->factor[k] = factor[k];
        f->dimension[k] = dimension[k];
        f->mean *= j->factor_mean[factor[k]];
    }
}

/* Groups: 0 to 3 are single dimensions, 4 and 5 the pairs, 6 to 9 cross pairs, 10 a choice with dimension 0
 * followed by the point (2, 3), and 11 all four. */
static void make_functions(bake_smooth_judge *j, bake_random *r) {
    static const int cross[4][2] = {{0, 2}, {0, 3}, {1, 2}, {1, 3}};
    const curve single[SINGLES] = {{0, 1, 0, 0}, {0, 1, 0.25, 0}, {0, 2, 0, 0}, {2, 1, 0, 0},
                                   {2, 2, 0, 0}, {3, 3, 1, 0},    {3, 7, 2, 0}, {3, 17, 5, 0}};
    int one[SINGLES], more[MIXED];
    for (int i = 0; i < SINGLES; ++i) one[i] = add_factor(j, single[i]);
    for (int i = 0; i < MIXED; ++i) {
        double kind = bake_random_double(r), a = bake_random_double(r), b = bake_random_double(r);
        const curve bump = {1, a, 0.15 + 0.35 * b, 0}, wave = {0, b < 0.6 ? 1 : 2, a, 1.2},
                    ramp = {2, 1 + 2 * a, 0, 0};
        more[i] = add_factor(j, kind < 0.5 ? bump : kind < 0.8 ? wave : ramp);
    }
    for (int d = 0; d < 4; ++d) {
        for (int i = 0; i < SINGLES; ++i) add_function(j, d, 1, &one[i], &d);
    }
    for (int pair = 0; pair < 2; ++pair) {
        const int of[2] = {2 * pair, 2 * pair + 1};
        for (int i = 0; i < MIXED; i += 2) add_function(j, 4 + pair, 2, &more[i], of);
    }
    for (int k = 0; k < 4; ++k) {
        for (int i = 0; i < 4; ++i) {
            const int factor[2] = {more[5 * i + k], more[5 * i + k + 7]};
            add_function(j, 6 + k, 2, factor, cross[k]);
        }
    }
    for (int i = 0; i < 12; ++i) {
        const int triple[3] = {0, 2, 3}, all[4] = {0, 1, 2, 3};
        const int factor[4] = {more[i], more[i + 9], more[i + 17], more[i + 27]};
        add_function(j, 10, 3, factor, triple);
        add_function(j, 11, 4, factor, all);
    }
}

/* ---- Errors ---- */

static int levels_of(const smooth_function *f) {
    return f->dimensions == 1 ? LEVELS : FEW_LEVELS;
}

/* Adds squared errors of a function at 1, 2, 4 ... shifted points. */
static void add_errors(const bake_smooth_judge *j, const smooth_function *f,
                       const uint32_t (*point)[4], const uint32_t *shift, double *square) {
    float sum = 0;
    for (int i = 0, l = 0; l < levels_of(f); ++i) {
        float v = 1;
        for (int k = 0; k < f->dimensions; ++k) {
            int d = f->dimension[k];
            v *= j->factor[f->factor[k]][(point[i][d] ^ shift[d]) >> (32 - DIGITS)];
        }
        sum += v;
        if ((i & (i + 1)) == 0) {
            double error = (double)sum / (i + 1) - f->mean;
            square[l++] += error * error;
        }
    }
}

/* The root-mean-square errors of Owen-scrambled Sobol' pixels. */
static void measure_sobol(bake_smooth_judge *j) {
    enum { RUNS = 512 };
    static uint32_t point[POINTS][4];
    static const uint32_t none[4] = {0};
    double square[SUMS][LEVELS] = {{0}};
    bn_sampler sampler;
    bn_sampler_init(&sampler, BN_SAMPLER_SOBOL, 0);
    for (int run = 0; run < RUNS; ++run) {
        for (uint32_t i = 0; i < POINTS; ++i) {
            for (uint32_t pair = 0; pair < 2; ++pair) {
                uint32_t u[4];
                bn_sample_4d_u32(&sampler, run % SIDE, run / SIDE, i, 11 + pair, u);
                memcpy(point[i] + 2 * pair, u, 2 * sizeof *u);
            }
        }
        for (int f = 0; f < j->count; ++f) {
            add_errors(j, &j->f[f], point, none, square[f]);
        }
    }
    for (int f = 0; f < j->count; ++f) {
        for (int l = 0; l < LEVELS; ++l) j->f[f].sobol[l] = sqrt(square[f][l] / RUNS) + 1e-7;
    }
}

bake_smooth_judge *bake_smooth_begin(bake_random *r) {
    bake_smooth_judge *j = bake_allocate(1, sizeof *j);
    make_functions(j, r);
    for (int s = 0; s < SHIFTS; ++s) {
        for (int d = 0; d < 4; ++d) j->shift[s][d] = (uint32_t)bake_random_bits(r);
    }
    measure_sobol(j);
    return j;
}

double bake_smooth_energy(const bake_smooth_judge *j, const uint32_t point[POINTS][4]) {
    static const double weight[LEVELS] = {0, .3, .7, 1, 1, 1, 1, .4, .3};
    static const double group_weight[GROUPS] = {.3, .3, .3, .3, 1.8, 1.8, .3, .3, .3, .3, 1, 1.5};
    double logs[GROUPS][LEVELS] = {{0}}, energy = 0;
    int members[GROUPS] = {0};
    for (const smooth_function *f = j->f; f < j->f + j->count; ++f) {
        const int single = f->dimensions == 1;
        double square[LEVELS] = {0};
        ++members[f->group];
        for (int s = 0; s < SHIFTS; ++s) {
            add_errors(j, f, point, j->shift[s], square);
        }
        for (int l = 1; l < levels_of(f); ++l) {
            const double ratio = sqrt(square[l] / SHIFTS) / f->sobol[l];
            /* Single dimensions soon become good enough. */
            logs[f->group][l] += log(fmax(ratio, single ? 0.4 : 0.05));
            if (single && l > 1 && ratio > 1.05) energy += 3 * (ratio - 1.05);
        }
    }
    for (int g = 0; g < GROUPS; ++g) {
        for (int l = 1; l < LEVELS; ++l) {
            double mean = logs[g][l] / members[g];
            energy += weight[l] * group_weight[g] * mean;
            if (g >= 4 && l > 1 && mean > -0.03) energy += 8 * group_weight[g] * (mean + 0.03);
        }
    }
    return energy / 48; /* about the sum of weights */
}
