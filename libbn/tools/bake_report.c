/* SPDX-License-Identifier: Apache-2.0
 * What a table of the sampler blue is worth on integrands it was not made for: the error of its 64
 * x 64 pixels as a ratio to that of independent Owen-scrambled Sobol' pixels, at 1, 2, 4 ... 256
 * samples, after a Gaussian blur of 2.1 pixels (steps: along the edge only), of 1.0 and without.
 * Seconds.
 */
#include "bake_tile.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TESTS = 40, SOBOL = MEMBERS };

/* Bits of one plane: [PIXELS][4]. */
typedef uint64_t plane_bits[PIXELS][4];

typedef struct {
    double blurred[LEVELS], narrow[LEVELS], raw[LEVELS];
} measure;

typedef struct {
    bake_pair pair[MEMBERS][2];
    const bake_table *table;
    bake_key key[MEMBERS][2]; /* of a domain: other ones for each integrand */
    plane_bits first, second;
    float error[LEVELS][PIXELS], image[PIXELS];
} judge;

static void new_domain(judge *j, int integrand) {
    bake_random r = bake_random_make(20001, 9, (uint64_t)integrand);
    for (int k = 0; k < 2 * MEMBERS; ++k) j->key[k / 2][k % 2] = bake_key_make(&r);
}

/* Pair `pair` of a member, or of the baseline. */
static void plane_of(judge *j, int member, int pair, const bake_plane *plane, plane_bits out) {
    float x[POINTS], y[POINTS];
    for (int p = 0; p < PIXELS; ++p) {
        if (member == SOBOL) {
            bake_sobol_points(p, 5 + (uint32_t)pair, POINTS, x, y);
        } else {
            bake_key key = bake_key_of_pixel(j->key[member][pair],
                                             (uint64_t)(p * 8 + member * 2 + pair) + 1000003);
            bake_pair_points(&j->pair[member][pair], j->table->label[member][p], key, POINTS, x, y);
        }
        bake_plane_bits(plane, x, y, POINTS, out[p]);
    }
}

static void errors_of(judge *j, double mean) {
    for (int p = 0; p < PIXELS; ++p) {
        int counts[LEVELS];
        bake_prefix_counts(j->first[p], LEVELS, counts);
        for (int l = 0; l < LEVELS; ++l) {
            j->error[l][p] = (float)(counts[l] / (double)(1 << l) - mean);
        }
    }
}

/* Adds the roots of the mean squares; independent pixels are blurred by the known gain. */
static void add(judge *j, measure *m, int axes, int independent) {
    double gain = sqrt(bake_blur_gain(axes)), narrow = sqrt(bake_blur_gain(axes | BAKE_NARROW));
    for (int l = 0; l < LEVELS; ++l) {
        double raw = sqrt(bake_mean_square(j->error[l], PIXELS));
        bake_blur(j->error[l], j->image, SIDE, axes);
        m->raw[l] += raw;
        m->blurred[l] += independent ? gain * raw : sqrt(bake_mean_square(j->image, PIXELS));
        bake_blur(j->error[l], j->image, SIDE, axes | BAKE_NARROW);
        m->narrow[l] += independent ? narrow * raw : sqrt(bake_mean_square(j->image, PIXELS));
    }
}

static void intersect(judge *j) {
    for (int p = 0; p < PIXELS; ++p) {
        for (int w = 0; w < 4; ++w) j->first[p][w] &= j->second[p][w];
    }
}

static void print_row(const char *name, const double *over, const double *under) {
    printf("| %-28s |", name);
    for (int l = 0; l < LEVELS; ++l)
        printf(" %.3f |", under != NULL ? over[l] / under[l] : over[l]);
    printf("\n");
    fflush(stdout);
}

/* ---- Tables ---- */

static void planes_and_products(judge *j) {
    static measure plane[MEMBERS + 1][2], product[MEMBERS + 1], mean_plane, mean_product;
    bake_random r = bake_random_make(20001, 0, 0);
    char name[40];
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane one = bake_plane_make(&r, (f + 0.5) / TESTS);
        bake_plane two = bake_plane_make(&r, bake_random_double(&r));
        for (int a = 0; a <= MEMBERS; ++a) {
            for (int pair = 0; pair < (a == SOBOL ? 1 : 2); ++pair) {
                plane_of(j, a, pair, &one, j->first);
                errors_of(j, one.mean);
                add(j, &plane[a][pair], 3, a == SOBOL);
            }
            plane_of(j, a, 0, &one, j->first);
            plane_of(j, a, 1, &two, j->second);
            intersect(j);
            errors_of(j, one.mean * two.mean);
            add(j, &product[a], 3, a == SOBOL);
        }
    }
    for (int a = 0; a < MEMBERS; ++a) {
        for (int l = 0; l < LEVELS; ++l) {
            mean_product.blurred[l] += product[a].blurred[l] / MEMBERS;
            mean_product.narrow[l] += product[a].narrow[l] / MEMBERS;
            mean_product.raw[l] += product[a].raw[l] / MEMBERS;
            for (int pair = 0; pair < 2; ++pair) {
                mean_plane.blurred[l] += plane[a][pair].blurred[l] / (2 * MEMBERS);
                mean_plane.narrow[l] += plane[a][pair].narrow[l] / (2 * MEMBERS);
                mean_plane.raw[l] += plane[a][pair].raw[l] / (2 * MEMBERS);
            }
        }
        for (int pair = 0; pair < 2; ++pair) {
            snprintf(name, sizeof name, "member %d, pair %d", a, pair);
            print_row(name, plane[a][pair].blurred, plane[SOBOL][0].blurred);
        }
    }
    print_row("half-planes, mean", mean_plane.blurred, plane[SOBOL][0].blurred);
    for (int a = 0; a < MEMBERS; ++a) {
        snprintf(name, sizeof name, "both pairs of member %d", a);
        print_row(name, product[a].blurred, product[SOBOL].blurred);
    }
    print_row("products of pairs, mean", mean_product.blurred, product[SOBOL].blurred);
    print_row("half-planes, sigma 1.0", mean_plane.narrow, plane[SOBOL][0].narrow);
    print_row("products of pairs, sigma 1.0", mean_product.narrow, product[SOBOL].narrow);
    for (int a = 0; a < MEMBERS; ++a) {
        for (int pair = 0; pair < 2; ++pair) {
            snprintf(name, sizeof name, "member %d, pair %d, unblurred", a, pair);
            print_row(name, plane[a][pair].raw, plane[SOBOL][0].raw);
        }
    }
    print_row("half-planes, unblurred", mean_plane.raw, plane[SOBOL][0].raw);
    print_row("products, unblurred", mean_product.raw, product[SOBOL].raw);
}

/* Edges that lean away from a row or a column by slopes of .03 to .1: a linear scrambling suits some
 * slopes and not others, which half-planes at all angles do not show. */
static void leaning_edges(judge *j) {
    static measure sum[2 * MEMBERS + 1];
    double mean[LEVELS] = {0}, raw[LEVELS] = {0}, worst[LEVELS] = {0};
    bake_random r = bake_random_make(20001, 3, 0);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        double slope = 0.03 * pow(0.1 / 0.03, (f + 0.5) / TESTS);
        double turns = atan((f & 2) != 0 ? slope : -slope) / 6.283185307179586;
        bake_plane plane = bake_plane_make(&r, turns + 0.25 * (f & 1));
        for (int k = 0; k <= 2 * MEMBERS; ++k) {
            plane_of(j, k / 2, k % 2, &plane, j->first);
            errors_of(j, plane.mean);
            add(j, &sum[k], 3, k / 2 == SOBOL);
        }
    }
    const measure *sobol = &sum[2 * MEMBERS];
    for (int k = 0; k < 2 * MEMBERS; ++k) {
        for (int l = 0; l < LEVELS; ++l) {
            mean[l] += sum[k].blurred[l] / (2 * MEMBERS);
            raw[l] += sum[k].raw[l] / (2 * MEMBERS);
            if (sum[k].raw[l] > worst[l]) worst[l] = sum[k].raw[l];
        }
    }
    print_row("leaning edges", mean, sobol->blurred);
    print_row("the same, unblurred", raw, sobol->raw);
    print_row("the worst pair, unblurred", worst, sobol->raw);
}

/* Products over two members, of their pairs in turn. */
static void products_of_members(judge *j, int a, int b, measure *m) {
    bake_random r = bake_random_make(20001, 1, 0);
    memset(m, 0, sizeof *m);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane one = bake_plane_make(&r, (f + 0.5) / TESTS);
        bake_plane two = bake_plane_make(&r, bake_random_double(&r));
        plane_of(j, a, a == SOBOL ? 0 : f & 1, &one, j->first);
        plane_of(j, b, b == SOBOL ? 1 : f >> 1 & 1, &two, j->second);
        intersect(j);
        errors_of(j, one.mean * two.mean);
        add(j, m, 3, a == SOBOL);
    }
}

static void members(judge *j) {
    measure mean = {{0}, {0}, {0}}, each, sobol;
    products_of_members(j, SOBOL, SOBOL, &sobol);
    for (int a = 0; a < MEMBERS; ++a) {
        for (int b = a + 1; b < MEMBERS; ++b) {
            char name[40];
            products_of_members(j, a, b, &each);
            for (int l = 0; l < LEVELS; ++l) {
                mean.blurred[l] += each.blurred[l] / 6;
                mean.narrow[l] += each.narrow[l] / 6;
                mean.raw[l] += each.raw[l] / 6;
            }
            snprintf(name, sizeof name, "members %d and %d", a, b);
            print_row(name, each.blurred, sobol.blurred);
        }
    }
    print_row("products of members, mean", mean.blurred, sobol.blurred);
    print_row("the same, sigma 1.0", mean.narrow, sobol.narrow);
    print_row("the same, unblurred", mean.raw, sobol.raw);
}

/* Steps at irrational places, blurred along the edge; in the other pairs, what is left along rows
 * over what is left along columns. */
static void steps(judge *j) {
    measure table = {{0}, {0}, {0}}, sobol = {{0}, {0}, {0}};
    bake_random r = bake_random_make(20001, 2, 0);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane plane = bake_plane_step(f & 1, (f + bake_random_double(&r)) / TESTS);
        for (int member = 0; member <= SOBOL; member += SOBOL) {
            plane_of(j, member, 0, &plane, j->first);
            errors_of(j, plane.mean);
            add(j, member == SOBOL ? &sobol : &table, (f & 1) != 0 ? 1 : 2, member == SOBOL);
        }
    }
    print_row("steps of member 0, pair 0", table.blurred, sobol.blurred);
    for (int k = 1; k < 2 * MEMBERS; ++k) {
        double across[LEVELS] = {0}, along[LEVELS] = {0}, ratio[LEVELS];
        char name[40];
        for (int f = 0; f < TESTS; ++f) {
            new_domain(j, f);
            bake_plane plane = bake_plane_step(f & 1, (f + bake_random_double(&r)) / TESTS);
            plane_of(j, k / 2, k % 2, &plane, j->first);
            errors_of(j, plane.mean);
            for (int l = 0; l < LEVELS; ++l) {
                bake_blur(j->error[l], j->image, SIDE, (f & 1) != 0 ? 2 : 1);
                across[l] += bake_mean_square(j->image, PIXELS);
                bake_blur(j->error[l], j->image, SIDE, (f & 1) != 0 ? 1 : 2);
                along[l] += bake_mean_square(j->image, PIXELS);
            }
        }
        for (int l = 0; l < LEVELS; ++l) ratio[l] = across[l] / along[l];
        snprintf(name, sizeof name, "axes of member %d, pair %d", k / 2, k % 2);
        print_row(name, ratio, NULL);
    }
}

/* Steps in one dimension of member 0, arranged as a single number. */
static void single_numbers(judge *j) {
    measure table = {{0}, {0}, {0}}, sobol = {{0}, {0}, {0}};
    bake_random r = bake_random_make(20001, 4, 0);
    for (int f = 0; f < TESTS; ++f) {
        const int d = f % 4;
        new_domain(j, f);
        bake_plane plane = bake_plane_step(d & 1, (f + bake_random_double(&r)) / TESTS);
        plane_of(j, SOBOL, 0, &plane, j->first);
        errors_of(j, plane.mean);
        add(j, &sobol, 3, 1);
        for (int p = 0; p < PIXELS; ++p) {
            float x[POINTS], y[POINTS];
            bake_key key = bake_key_of_pixel(j->key[0][d / 2], (uint64_t)(p * 8 + d / 2) + 1000003);
            bake_pair_points(&j->pair[0][d / 2], j->table->single[d][p], key, POINTS, x, y);
            bake_plane_bits(&plane, x, y, POINTS, j->first[p]);
        }
        errors_of(j, plane.mean);
        add(j, &table, 3, 0);
    }
    print_row("steps in single numbers", table.blurred, sobol.blurred);
    print_row("the same, sigma 1.0", table.narrow, sobol.narrow);
}

/* Waves, bumps, ramps and their products, in single pixels. */
static void smooth(const bake_table *table) {
    static const char *const kinds[BAKE_SMOOTH_KINDS] = {
        "smooth, one dimension", "smooth, a pair", "smooth, across pairs", "smooth, (0) with (2,3)",
        "smooth, four dimensions"};
    static double mean[MEMBERS][BAKE_SMOOTH_KINDS][LEVELS], worst[MEMBERS][LEVELS];
    for (int a = 0; a < MEMBERS; ++a) bake_smooth_ratios(&table->member[a], mean[a], worst[a]);
    for (int k = 0; k <= BAKE_SMOOTH_KINDS; ++k) {
        double row[LEVELS] = {0};
        for (int a = 0; a < MEMBERS; ++a) {
            for (int l = 0; l < LEVELS; ++l) {
                if (k == BAKE_SMOOTH_KINDS) {
                    row[l] = fmax(row[l], worst[a][l]);
                } else {
                    row[l] += log(mean[a][k][l]) / MEMBERS;
                }
            }
        }
        for (int l = 0; l < LEVELS && k < BAKE_SMOOTH_KINDS; ++l) row[l] = exp(row[l]);
        print_row(k < BAKE_SMOOTH_KINDS ? kinds[k] : "one dimension, the worst", row, NULL);
    }
}

void bake_report(const bake_table *table) {
    judge *j = bake_allocate(1, sizeof *j);
    j->table = table;
    for (int a = 0; a < MEMBERS; ++a) {
        for (int pair = 0; pair < 2; ++pair) {
            bake_pair_make(&j->pair[a][pair], &table->member[a], pair);
        }
    }
    printf("| %-28s |     1 |     2 |     4 |     8 |    16 |    32 |    64 |   128 |   256 |\n",
           "");
    printf("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    planes_and_products(j);
    leaning_edges(j);
    members(j);
    steps(j);
    single_numbers(j);
    smooth(table);
    free(j);
}
