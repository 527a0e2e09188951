/* SPDX-License-Identifier: Apache-2.0
 * What a table of the sampler blue is worth on integrands it was not made for: the error of its 64
 * x 64 pixels as a ratio to that of independent Owen-scrambled Sobol' pixels, at 1, 2, 4 ... 256
 * samples, after a Gaussian blur of 2.1 pixels (steps: along the edge only), of 1.0 and without.
 * Seconds.
 */
#include "bake_tile.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TESTS = 40, SOBOL = MEMBERS };

/* Bits of one plane: [PIXELS][4]. */
typedef uint64_t plane_bits[PIXELS][4];

enum { BLURRED, NARROW, RAW, WAYS };
typedef double measure[WAYS][LEVELS];

typedef struct {
    const bake_view *table;
    bake_key key[MEMBERS][2]; /* of a domain: other ones for each integrand */
    plane_bits first, second;
    float error[LEVELS][PIXELS], image[PIXELS];
} judge;

static void new_domain(judge *j, int integrand) {
    bake_random r = bake_random_make(20001, 9, (uint64_t)integrand);
    for (int k = 0; k < 2 * MEMBERS; ++k) j->key[k / 2][k % 2] = bake_key_make(&r);
}

/* With labels `label`, pair `pair` of a member, or of the baseline. */
static void plane_at(judge *j, const uint16_t *label, int member, int pair, const bake_plane *plane,
                     plane_bits out) {
    float x[POINTS], y[POINTS];
    for (int p = 0; p < PIXELS; ++p) {
        if (member == SOBOL) {
            bake_sobol_points(p, 5 + (uint32_t)pair, POINTS, x, y);
        } else {
            bake_key key = bake_key_of_pixel(j->key[member][pair],
                                             (uint64_t)(p * 8 + member * 2 + pair) + 1000003);
            bake_pair_points(&j->table->pair[member][pair], label[p], key, POINTS, x, y);
        }
        bake_plane_bits(plane, x, y, POINTS, out[p]);
    }
}

static void plane_of(judge *j, int member, int pair, const bake_plane *plane, plane_bits out) {
    plane_at(j, member == SOBOL ? NULL : j->table->label[member], member, pair, plane, out);
}

static void errors_of(judge *j, double mean) {
    for (int p = 0; p < PIXELS; ++p) {
        bake_prefix_errors(j->first[p], LEVELS, mean, &j->error[0][p], PIXELS);
    }
}

/* Adds the roots of the mean squares; independent pixels are blurred by the known gain. */
static void add(judge *j, measure m, int axes, int independent) {
    double gain = sqrt(bake_blur_gain(axes)), narrow = sqrt(bake_blur_gain(axes | BAKE_NARROW));
    for (int l = 0; l < LEVELS; ++l) {
        double raw = sqrt(bake_mean_square(j->error[l], PIXELS));
        bake_blur(j->error[l], j->image, SIDE, axes);
        m[RAW][l] += raw;
        m[BLURRED][l] += independent ? gain * raw : sqrt(bake_mean_square(j->image, PIXELS));
        bake_blur(j->error[l], j->image, SIDE, axes | BAKE_NARROW);
        m[NARROW][l] += independent ? narrow * raw : sqrt(bake_mean_square(j->image, PIXELS));
    }
}

/* Adds the errors of a plane. */
static void add_plane(judge *j, measure m, int member, int pair, const bake_plane *plane,
                      int axes) {
    plane_of(j, member, pair, plane, j->first);
    errors_of(j, plane->mean);
    add(j, m, axes, member == SOBOL);
}

/* Adds the errors of the product of planes over a pair of each of two members. */
static void add_product(judge *j, measure m, const int member[2], const int pair[2],
                        const bake_plane plane[2]) {
    plane_of(j, member[0], pair[0], &plane[0], j->first);
    plane_of(j, member[1], pair[1], &plane[1], j->second);
    for (int p = 0; p < PIXELS; ++p) {
        for (int w = 0; w < 4; ++w) j->first[p][w] &= j->second[p][w];
    }
    errors_of(j, plane[0].mean * plane[1].mean);
    add(j, m, 3, member[0] == SOBOL);
}

/* Adds one of `count` to a mean. */
static void add_share(measure mean, measure each, int count) {
    for (int way = 0; way < WAYS; ++way) {
        for (int l = 0; l < LEVELS; ++l) mean[way][l] += each[way][l] / count;
    }
}

/* The name is as for printf(). */
static void print_row(const double *over, const double *under, const char *name, ...) {
    char text[40];
    va_list numbers;
    va_start(numbers, name);
    vsnprintf(text, sizeof text, name, numbers);
    va_end(numbers);
    printf("| %-28s |", text);
    for (int l = 0; l < LEVELS; ++l) {
        const double ratio = under != NULL ? over[l] / under[l] : over[l];
        if (isnan(ratio)) {
            printf("       |"); /* not measured */
        } else {
            printf(" %.3f |", ratio);
        }
    }
    printf("\n");
    fflush(stdout);
}

/* ---- Tables ---- */

static void planes_and_products(judge *j) {
    static measure plane[MEMBERS + 1][2], product[MEMBERS + 1], mean_plane, mean_product;
    double(*const sobol)[LEVELS] = plane[SOBOL][0];
    double(*const sobol_product)[LEVELS] = product[SOBOL];
    bake_random r = bake_random_make(20001, 0, 0);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane two[2];
        two[0] = bake_plane_make(&r, (f + 0.5) / TESTS);
        two[1] = bake_plane_make(&r, bake_random_double(&r));
        for (int a = 0; a <= MEMBERS; ++a) {
            for (int pair = 0; pair < (a == SOBOL ? 1 : 2); ++pair) {
                add_plane(j, plane[a][pair], a, pair, &two[0], 3);
            }
            add_product(j, product[a], (int[]){a, a}, (int[]){0, 1}, two);
        }
    }
    for (int a = 0; a < MEMBERS; ++a) {
        add_share(mean_product, product[a], MEMBERS);
        for (int pair = 0; pair < 2; ++pair) {
            add_share(mean_plane, plane[a][pair], 2 * MEMBERS);
            print_row(plane[a][pair][BLURRED], sobol[BLURRED], "member %d, pair %d", a, pair);
        }
    }
    print_row(mean_plane[BLURRED], sobol[BLURRED], "half-planes, mean");
    for (int a = 0; a < MEMBERS; ++a) {
        print_row(product[a][BLURRED], sobol_product[BLURRED], "both pairs of member %d", a);
    }
    print_row(mean_product[BLURRED], sobol_product[BLURRED], "products of pairs, mean");
    print_row(mean_plane[NARROW], sobol[NARROW], "half-planes, sigma 1.0");
    print_row(mean_product[NARROW], sobol_product[NARROW], "products of pairs, sigma 1.0");
    for (int k = 0; k < 2 * MEMBERS; ++k) {
        print_row(plane[k / 2][k % 2][RAW], sobol[RAW], "member %d, pair %d, unblurred", k / 2,
                  k % 2);
    }
    print_row(mean_plane[RAW], sobol[RAW], "half-planes, unblurred");
    print_row(mean_product[RAW], sobol_product[RAW], "products, unblurred");
}

/* Edges that lean away from a row or a column by slopes of .03 to .1: a linear scrambling suits some
 * slopes and not others, which half-planes at all angles do not show. */
static void leaning_edges(judge *j) {
    static measure sum[2 * MEMBERS + 1], mean;
    double(*const sobol)[LEVELS] = sum[2 * MEMBERS];
    double worst[LEVELS] = {0};
    bake_random r = bake_random_make(20001, 3, 0);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        double slope = 0.03 * pow(0.1 / 0.03, (f + 0.5) / TESTS);
        double turns = atan((f & 2) != 0 ? slope : -slope) / 6.283185307179586;
        bake_plane plane = bake_plane_make(&r, turns + 0.25 * (f & 1));
        for (int k = 0; k <= 2 * MEMBERS; ++k) {
            add_plane(j, sum[k], k / 2, k % 2, &plane, 3);
        }
    }
    for (int k = 0; k < 2 * MEMBERS; ++k) {
        add_share(mean, sum[k], 2 * MEMBERS);
        for (int l = 0; l < LEVELS; ++l) worst[l] = fmax(worst[l], sum[k][RAW][l]);
    }
    print_row(mean[BLURRED], sobol[BLURRED], "leaning edges");
    print_row(mean[RAW], sobol[RAW], "the same, unblurred");
    print_row(worst, sobol[RAW], "the worst pair, unblurred");
}

/* Products over two members, of their pairs in turn. */
static void products_of_members(judge *j, int a, int b, measure m) {
    bake_random r = bake_random_make(20001, 1, 0);
    memset(m, 0, sizeof(measure));
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane two[2];
        two[0] = bake_plane_make(&r, (f + 0.5) / TESTS);
        two[1] = bake_plane_make(&r, bake_random_double(&r));
        const int pair[2] = {a == SOBOL ? 0 : f & 1, b == SOBOL ? 1 : f >> 1 & 1};
        add_product(j, m, (int[]){a, b}, pair, two);
    }
}

static void members(judge *j) {
    measure mean = {{0}}, each, sobol;
    products_of_members(j, SOBOL, SOBOL, sobol);
    for (int a = 0; a < MEMBERS; ++a) {
        for (int b = a + 1; b < MEMBERS; ++b) {
            products_of_members(j, a, b, each);
            add_share(mean, each, MEMBERS * (MEMBERS - 1) / 2);
            print_row(each[BLURRED], sobol[BLURRED], "members %d and %d", a, b);
        }
    }
    print_row(mean[BLURRED], sobol[BLURRED], "products of members, mean");
    print_row(mean[NARROW], sobol[NARROW], "the same, sigma 1.0");
    print_row(mean[RAW], sobol[RAW], "the same, unblurred");
}

/* Steps at irrational places, blurred along the edge; in the other pairs, what is left along rows
 * over what is left along columns. */
static void steps(judge *j) {
    measure table = {{0}}, sobol = {{0}};
    bake_random r = bake_random_make(20001, 2, 0);
    for (int f = 0; f < TESTS; ++f) {
        new_domain(j, f);
        bake_plane plane = bake_plane_step(f & 1, (f + bake_random_double(&r)) / TESTS);
        for (int member = 0; member <= SOBOL; member += SOBOL) {
            add_plane(j, member == SOBOL ? sobol : table, member, 0, &plane, (f & 1) != 0 ? 1 : 2);
        }
    }
    print_row(table[BLURRED], sobol[BLURRED], "steps of member 0, pair 0");
    for (int k = 1; k < 2 * MEMBERS; ++k) {
        double across[LEVELS] = {0}, along[LEVELS] = {0};
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
        print_row(across, along, "axes of member %d, pair %d", k / 2, k % 2);
    }
}

/* Steps in one dimension of member 0, arranged as a single number. */
static void single_numbers(judge *j) {
    measure table = {{0}}, sobol = {{0}};
    bake_random r = bake_random_make(20001, 4, 0);
    for (int f = 0; f < TESTS; ++f) {
        const int d = f % 4;
        new_domain(j, f);
        bake_plane plane = bake_plane_step(d & 1, (f + bake_random_double(&r)) / TESTS);
        add_plane(j, sobol, SOBOL, 0, &plane, 3);
        plane_at(j, j->table->single[d], 0, d / 2, &plane, j->first);
        errors_of(j, plane.mean);
        add(j, table, 3, 0);
    }
    print_row(table[BLURRED], sobol[BLURRED], "steps in single numbers");
    print_row(table[NARROW], sobol[NARROW], "the same, sigma 1.0");
}

/* Waves, bumps, ramps and their products, in single pixels. */
static void smooth(const bake_view *table) {
    static const char *const kinds[BAKE_SMOOTH_KINDS] = {
        "smooth, one dimension", "smooth, a pair", "smooth, across pairs", "smooth, (0) with (2,3)",
        "smooth, four dimensions"};
    static double mean[MEMBERS][BAKE_SMOOTH_KINDS][LEVELS], worst[MEMBERS][LEVELS];
    for (int a = 0; a < MEMBERS; ++a) bake_smooth_ratios(table->point[a], mean[a], worst[a]);
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
        print_row(row, NULL, "%s", k < BAKE_SMOOTH_KINDS ? kinds[k] : "one dimension, the worst");
    }
}

void bake_report(const bake_view *table) {
    judge *j = bake_allocate(1, sizeof *j);
    j->table = table;
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
