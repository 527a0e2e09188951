/* SPDX-License-Identifier: Apache-2.0
 * The second stage of bn_bake_sampler: a linear scrambling of the first 16 digits of each
 * coordinate.
 *
 * Adding digits to less significant ones keeps every net (Matousek, "On the L2-discrepancy for
 * anchored boxes", 1998) and changes how the errors of pixels and samples are related. Hill
 * climbing from the best of random scramblings minimises the error of half-planes after the blur,
 * relative to independent Sobol' pixels, in a corner of the tile; errors within the pixel may not
 * exceed those of Sobol'. Some 15 ms a trial. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNER = 32, PLANES = 160, FEW_LEVELS = 7 };

/* Every eighth plane shares the random digits of a domain. */
enum { KEYS = 8 };

struct bake_planes {
    bake_plane plane[PLANES];
    bake_key key[KEYS];
    double independent[LEVELS][PLANES];
    float sobol[CORNER * CORNER][2][POINTS];
    bake_pair pair;
    float error[LEVELS][PLANES][CORNER * CORNER];
};

/* The mean error of independent Sobol' pixels. */
static void measure_independent(bake_planes *s, int planes) {
    static float error[LEVELS][CORNER * CORNER];
    for (int f = 0; f < planes; ++f) {
        for (int p = 0; p < CORNER * CORNER; ++p) {
            uint64_t bits[4];
            bake_plane_bits(&s->plane[f], s->sobol[p][0], s->sobol[p][1], POINTS, bits);
            bake_prefix_errors(bits, LEVELS, s->plane[f].mean, &error[0][p], CORNER * CORNER);
        }
        for (int l = 0; l < LEVELS; ++l) {
            s->independent[l][f] = sqrt(bake_mean_square(error[l], CORNER * CORNER));
        }
    }
}

void bake_planes_measure(bake_planes *s, const pole_vectors *v, int which, const uint16_t *label,
                         int planes, int levels, double *blurred, double *raw) {
    static float image[CORNER * CORNER];
    bake_pair_make(&s->pair, v, which);
    for (int p = 0; p < CORNER * CORNER; ++p) {
        float x[KEYS][POINTS], y[KEYS][POINTS];
        int points = levels > FEW_LEVELS ? POINTS : 64;
        for (int k = 0; k < KEYS; ++k) {
            bake_key key = bake_key_of_pixel(s->key[k], (uint64_t)(2 * p + which));
            bake_pair_points(&s->pair, label[p / CORNER * SIDE + p % CORNER], key, points, x[k],
                             y[k]);
        }
        for (int f = 0; f < planes; ++f) {
            uint64_t bits[4];
            bake_plane_bits(&s->plane[f], x[f % KEYS], y[f % KEYS], points, bits);
            bake_prefix_errors(bits, levels, s->plane[f].mean, &s->error[0][f][p],
                               PLANES * CORNER * CORNER);
        }
    }
    double gain = sqrt(bake_blur_gain(3));
    for (int l = 0; l < levels; ++l) {
        double b = 0, r = 0, independent = 0;
        for (int f = 0; f < planes; ++f) {
            bake_blur(s->error[l][f], image, CORNER, 3);
            b += sqrt(bake_mean_square(image, CORNER * CORNER));
            r += sqrt(bake_mean_square(s->error[l][f], CORNER * CORNER));
            independent += s->independent[l][f];
        }
        blurred[l] = b / (independent * gain);
        raw[l] = r / independent;
    }
}

static double judge(const double *blurred, const double *raw, int levels, int first) {
    static const double aim[LEVELS] = {.47, .54, .54, .56, .55, .56, .55, .55, .55};
    static const double weight[LEVELS] = {1.2, 1.2, 1.2, 1.2, 1.1, 1, 1, .5, .5};
    double sum = 0;
    for (int l = first; l < levels; ++l) {
        double q = blurred[l] / aim[l], over = raw[l] - 0.99;
        sum += weight[l] * q * q * q / LEVELS;
        if (over > 0) sum += 60 * over * over;
    }
    return sum;
}

bake_planes *bake_planes_make(bake_random *r, int planes) {
    bake_planes *s = bake_allocate(1, sizeof *s);
    if (planes > PLANES) planes = PLANES;
    for (int f = 0; f < planes; ++f) {
        s->plane[f] = bake_plane_make(r, (f + bake_random_double(r)) / planes);
    }
    for (int k = 0; k < KEYS; ++k) s->key[k] = bake_key_make(r);
    for (int p = 0; p < CORNER * CORNER; ++p) {
        bake_sobol_points(p, 1, POINTS, s->sobol[p][0], s->sobol[p][1]);
    }
    measure_independent(s, planes);
    return s;
}

void bake_scramble(bake_table *table, const bake_options *options, int member, int pair) {
    int trials = bake_count(options, 400, 4), restarts = trials / 10;
    int planes = bake_count(options, PLANES, 16);
    if (planes > PLANES) planes = PLANES;
    bake_random r = bake_random_make(options->seed, 2, (uint64_t)(2 * member + pair));
    bake_planes *s = bake_planes_make(&r, planes);
    pole_vectors start = table->member[member], best = start;
    double least = 1e30, blurred[LEVELS], raw[LEVELS];
    for (int trial = 0; trial < trials; ++trial) {
        pole_vectors v = trial < restarts ? start : best;
        if (trial < restarts) {
            for (int c = 2 * pair; c < 2 * pair + 2; ++c) {
                for (int i = 0; i < 15; ++i) {
                    for (int j = i + 1; j < 16; ++j) {
                        if (bake_random_below(&r, 2)) pole_add_digit(&v, c, i, j);
                    }
                }
            }
        } else {
            for (uint32_t n = 1 + bake_random_below(&r, 3); n > 0; --n) {
                int i = (int)(12 * bake_random_double(&r) * bake_random_double(&r));
                int j = i + 1 + (int)((13 - i) * bake_random_double(&r));
                pole_add_digit(&v, 2 * pair + (int)bake_random_below(&r, 2), i, j);
            }
        }
        bake_planes_measure(s, &v, pair, table->label[member], planes, FEW_LEVELS, blurred, raw);
        double e = judge(blurred, raw, FEW_LEVELS, 0);
        if (e < least) {
            /* 128 and 256 samples cost more than the rest and are seldom looked at. */
            bake_planes_measure(s, &v, pair, table->label[member], planes / 2, LEVELS, blurred,
                                raw);
            e += judge(blurred, raw, LEVELS, FEW_LEVELS);
        }
        if (e < least) {
            least = e;
            best = v;
        }
        if (trial % 4 == 0) options->progress((double)trial / trials);
    }
    table->member[member] = best;
    free(s);
}
