/* SPDX-License-Identifier: Apache-2.0
 * How blue the samplers are, against the committed limits in sampler_limits.csv.
 *
 * A row bounds one figure of one sampler at one count and blur: the mean RMSE of the blurred
 * per-pixel errors of 64 x 64 pixels over 24 integrands and 4 domains, relative to white noise
 * (in closed form). Figures:
 *
 *     half-planes-01, half-planes-23   half-planes in a pair of dimensions
 *     products                         half-planes in both pairs of a domain, multiplied
 *     siblings                         half-planes in two domains of a family, multiplied
 *     steps                            x < c, blurred along columns only, and y < c, blurred along
 *                                      rows, in (0,1) of domains with keys 4 k: edges of a picture
 *                                      that are parallel to its sides
 *     leaning                          edges that lean away from a row or a column by slopes of .03
 *                                      to .1, in every pair in turn: linear scramblings suit some
 *                                      slopes and not others
 *     singles                          x < c, of the numbers that pairs 2 and 3 draw
 *     axes                             how unlike the low-frequency error of such steps in all other
 *                                      pairs is along the two axes: the ratio of the powers
 *
 * Steps are at irrational places: at multiples of 1/16 nets are exact, and a figure that is zero by
 * construction would hide everything; so every figure must also be above 0.02. Everything is seeded:
 * the figures are the same on every machine but for the rounding of the blur.
 *
 *     test_sampler_quality LIMITS.csv            check
 *     test_sampler_quality LIMITS.csv --print    print the file with limits 3 % above what is
 *                                                measured */
#include "../c/samplers.h"
#include "half_planes.h"
#include <bn/bn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Pictures have a margin as wide as the blur. */
enum { PLANES = 24, RADIUS = 8, DOMAINS = 4, MEMBERS = 4 };
enum { INNER = 64, SIZE = INNER + 2 * RADIUS, PIXELS = SIZE * SIZE };

static const uint32_t counts[] = {1, 2, 3, 4, 8, 16, 32, 64, 100, 256};
enum { COUNTS = sizeof counts / sizeof *counts, MOST = 256 };

typedef enum figure {
    HALF_PLANES_01,
    HALF_PLANES_23,
    PRODUCTS,
    SIBLINGS,
    STEPS,
    LEANING,
    AXES,
    SINGLES,
    FIGURES
} figure;
static const char *const figure_names[FIGURES] = {"half-planes-01", "half-planes-23", "products",
                                                  "siblings",       "steps",          "leaning",
                                                  "axes",           "singles"};

typedef struct row {
    char sampler[16], figure[16];
    uint32_t declared, spp;
    double sigma, limit;
} row;

static half_plane plane_through(int point, double a, double b) {
    return half_plane_through(a, b, fraction(0.5 + 0.7548776662466927 * point),
                              fraction(0.5 + 0.5698402909980532 * point));
}

/* Through well-spread points, at evenly spread angles; a second set at other ones. */
static half_plane plane(int index, int set) {
    int turned = (index * (set == 0 ? 1 : 7) + 11 * set) % PLANES;
    double angle = 6.283185307179586 * (turned + 0.41) / PLANES;
    return plane_through(index + 100 * set, cos(angle), sin(angle));
}

static half_plane leaning(int index) {
    double slope = 0.03 * pow(0.1 / 0.03, (index + 0.5) / PLANES);
    if (index & 2) slope = -slope;
    return plane_through(index, index & 1 ? 1.0 : slope, index & 1 ? slope : 1.0);
}

/* A step in x for even k, in y for odd k, at an irrational place. */
static half_plane step(int k) {
    double c = fraction(0.2 + 0.6180339887498949 * (k / 2));
    half_plane h = {k % 2 == 0, k % 2 != 0, c, c};
    return h;
}

enum { ALONG_ROWS = 1, ALONG_COLUMNS = 2 };

/* Blur along rows, columns or both, without the margin; `gain` is what it makes of the variance of
 * white noise. */
static double blurred_square(const float *errors, double sigma, int directions, double *gain) {
    static float rows[PIXELS];
    double kernel[2 * RADIUS + 1], total = 0.0, squares = 0.0, sum = 0.0;
    int radius = sigma > 0.0 ? RADIUS : 0;
    for (int d = -radius; d <= radius; ++d) {
        kernel[d + radius] = sigma > 0.0 ? exp(-d * d / (2.0 * sigma * sigma)) : 1.0;
        total += kernel[d + radius];
    }
    for (int d = 0; d <= 2 * radius; ++d) {
        kernel[d] /= total;
        squares += kernel[d] * kernel[d];
    }
    *gain = directions == (ALONG_ROWS | ALONG_COLUMNS) ? squares * squares : squares;
    for (int p = RADIUS; p < PIXELS - RADIUS; ++p) {
        double v = 0.0;
        for (int d = -radius; d <= radius; ++d) v += kernel[d + radius] * errors[p + d];
        rows[p] = directions & ALONG_ROWS ? (float)v : errors[p];
    }
    for (int i = 0; i < INNER * INNER; ++i) {
        const int p = (RADIUS + i / INNER) * SIZE + RADIUS + i % INNER;
        double v = 0.0;
        for (int d = -radius; d <= radius; ++d) v += kernel[d + radius] * rows[p + d * SIZE];
        if (!(directions & ALONG_COLUMNS)) v = rows[p];
        sum += v * v;
    }
    return sum / (INNER * INNER);
}

/* ---- One figure of one sampler at all counts */

typedef struct integrand {
    half_plane first, second;
    uint32_t at[2]; /* where the pairs of the two begin in the samples [member][4] */
    int product;
    int directions; /* of the blur */
    double mean;
} integrand;

static integrand integrand_make(figure what, uint32_t member, int k) {
    static const uint32_t siblings[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    const uint32_t own = 4u * member;
    integrand f = {plane(k, 0), plane(k, 1), {own, own + 2u}, 0, ALONG_ROWS | ALONG_COLUMNS, 0.0};
    if (what == STEPS || what == AXES) {
        f.first = step(k);
        f.directions = k % 2 == 0 ? ALONG_COLUMNS : ALONG_ROWS;
        f.at[0] = what == STEPS ? 0u : member == 0 || k / 2 % 2 == 0 ? own + 2u : own;
    } else if (what == LEANING) {
        f.first = leaning(k);
        f.at[0] = own + (uint32_t)(k & 4) / 2u;
    } else if (what == SINGLES) {
        f.first = step(k);
        f.at[0] = 2u * (uint32_t)(k / 2 % 2);
    } else if (what == HALF_PLANES_23) {
        f.at[0] = own + 2u;
    } else if (what == PRODUCTS || what == SIBLINGS) {
        f.product = 1;
        if (what == SIBLINGS) {
            f.at[0] = 4u * siblings[k % 6][0];
            f.at[1] = 4u * siblings[k % 6][1];
        }
    }
    f.mean = f.first.mean * (f.product ? f.second.mean : 1.0);
    return f;
}

static const double sigmas[] = {0.0, 1.0, 2.1}; /* 0: none */
enum { SIGMAS = sizeof sigmas / sizeof *sigmas };
typedef double figures[SIGMAS][COUNTS];

/* The cells of `figures` that have a limit; only these are measured. */
typedef int cells[SIGMAS][COUNTS];

static float errors[PLANES][COUNTS][PIXELS];

static void make_errors(const bn_sampler *sampler, uint32_t parent, int singles, const integrand *f,
                        uint32_t most) {
    static float samples[MEMBERS][MOST][4];
    for (int p = 0; p < PIXELS; ++p) {
        for (uint32_t member = 0; member < MEMBERS; ++member) {
            if (bn_sample_block(sampler, p % SIZE, p / SIZE, 1, 1, 0, most,
                                bn_domain_child(parent, member), samples[member][0],
                                4 * (size_t)most) != BN_SUCCESS) {
                exit(1);
            }
        }
        for (uint32_t i = 0; singles && i < most; ++i) {
            const uint32_t domain = bn_domain_child(parent, 0);
            bn_sample_pair(sampler, p % SIZE, p / SIZE, i, domain, 2, samples[0][i]);
            bn_sample_pair(sampler, p % SIZE, p / SIZE, i, domain, 3, samples[0][i] + 2);
        }
        for (int k = 0; k < PLANES; ++k) {
            const float *u = samples[f[k].at[0] / 4u][0] + f[k].at[0] % 4u;
            const float *v = samples[f[k].at[1] / 4u][0] + f[k].at[1] % 4u;
            uint32_t sum = 0, i = 0;
            for (int c = 0; c < COUNTS && counts[c] <= most; ++c) {
                for (; i < counts[c]; ++i) {
                    sum += is_inside(&f[k].first, u + 4 * (size_t)i) &&
                           (!f[k].product || is_inside(&f[k].second, v + 4 * (size_t)i));
                }
                errors[k][c][p] = (float)((double)sum / counts[c] - f[k].mean);
            }
        }
    }
}

/* The logarithm of the ratio of the powers along columns and along rows, of steps in x. */
static double axes_ratio(int k, int c, double sigma) {
    double gain, columns = blurred_square(errors[k][c], sigma, ALONG_COLUMNS, &gain);
    double rows = blurred_square(errors[k][c], sigma, ALONG_ROWS, &gain);
    return (k % 2 == 0 ? 1.0 : -1.0) * log(columns / rows);
}

static void measure(const bn_sampler *sampler, figure what, cells wanted, figures result) {
    static figures error, white;
    uint32_t most = 1;
    memset(error, 0, sizeof error);
    memset(white, 0, sizeof white);
    for (int s = 0; s < SIGMAS; ++s) {
        for (int c = 0; c < COUNTS; ++c) {
            if (wanted[s][c] && counts[c] > most) most = counts[c];
        }
    }
    for (uint32_t domain = 0; domain < DOMAINS; ++domain) {
        integrand f[PLANES];
        for (int k = 0; k < PLANES; ++k) f[k] = integrand_make(what, domain % MEMBERS, k);
        make_errors(sampler, bn_domain_child(BN_DOMAIN_ROOT, 4u * domain + 400u), what == SINGLES,
                    f, most);
        for (int s = 0; s < SIGMAS; ++s) {
            for (int c = 0; c < COUNTS; ++c) {
                for (int k = 0; wanted[s][c] && k < PLANES; ++k) {
                    double gain, variance = f[k].mean * (1.0 - f[k].mean) / counts[c];
                    if (what == AXES) {
                        error[s][c] += axes_ratio(k, c, sigmas[s]);
                        white[s][c] += 1.0;
                    } else {
                        error[s][c] +=
                            sqrt(blurred_square(errors[k][c], sigmas[s], f[k].directions, &gain));
                        white[s][c] += sqrt(gain * variance);
                    }
                }
            }
        }
    }
    for (int s = 0; s < SIGMAS; ++s) {
        for (int c = 0; c < COUNTS; ++c) {
            double ratio = error[s][c] / white[s][c];
            result[s][c] = what == AXES ? exp(fabs(ratio)) : ratio;
        }
    }
}

/* ---- The limits */

static int position_of_sigma(double sigma) {
    for (int s = 0; s < SIGMAS; ++s) {
        if (sigmas[s] == sigma) return s;
    }
    return -1;
}

static int position_of_count(uint32_t spp) {
    for (int c = 0; c < COUNTS; ++c) {
        if (counts[c] == spp) return c;
    }
    return -1;
}

static int read_row(const char *line, row *r) {
    if (sscanf(line, "%15[^,],%u,%15[^,],%u,%lf,%lf", r->sampler, &r->declared, r->figure, &r->spp,
               &r->sigma, &r->limit) != 6) {
        return 0;
    }
    return position_of_count(r->spp) >= 0 && position_of_sigma(r->sigma) >= 0;
}

static bn_sampler make(const row *r) {
    static const char *const names[] = {"blue", "sobol", "white", "zorder", "mask"};
    bn_sampler_options options = bn_sampler_options_default();
    options.samples_per_pixel = r->declared;
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        if (strcmp(r->sampler, names[kind]) == 0) options.kind = kind;
    }
    return sampler_of(&options);
}

enum { MOST_ROWS = 1024 };

static int same_run(const row *a, const row *b) {
    return strcmp(a->sampler, b->sampler) == 0 && strcmp(a->figure, b->figure) == 0 &&
           a->declared == b->declared;
}

/* The figures of a row and of all later rows of the same run, measured anew where a run begins. */
static const figures *figures_of(const row *rows, int count, int at) {
    static figures result;
    const row *r = &rows[at];
    if (at == 0 || !same_run(r, &rows[at - 1])) {
        const bn_sampler sampler = make(r);
        cells wanted = {{0}};
        int what = 0;
        while (what < FIGURES && strcmp(r->figure, figure_names[what]) != 0) ++what;
        if (what == FIGURES) return NULL;
        for (int i = at; i < count && same_run(r, &rows[i]); ++i) {
            wanted[position_of_sigma(rows[i].sigma)][position_of_count(rows[i].spp)] = 1;
        }
        measure(&sampler, (figure)what, wanted, result);
    }
    return (const figures *)&result;
}

int main(int argc, char **argv) {
    static row rows[MOST_ROWS];
    if (argc < 2) return 2;
    FILE *file = fopen(argv[1], "r");
    int print = argc > 2 && strcmp(argv[2], "--print") == 0, count = 0, failed = 0;
    char line[256];
    if (file == NULL || fgets(line, sizeof line, file) == NULL) return 2;
    if (print) fputs(line, stdout);
    while (fgets(line, sizeof line, file) != NULL) {
        if (count == MOST_ROWS || !read_row(line, &rows[count])) {
            fprintf(stderr, "not a row, or one too many: %s", line);
            return 2;
        }
        ++count;
    }
    fclose(file);
    for (int i = 0; i < count; ++i) {
        const row r = rows[i];
        const figures *all = figures_of(rows, count, i);
        if (all == NULL) {
            fprintf(stderr, "no such sampler or figure: %s, %s\n", r.sampler, r.figure);
            return 2;
        }
        double ratio = (*all)[position_of_sigma(r.sigma)][position_of_count(r.spp)];
        if (print) {
            printf("%s,%u,%s,%u,%.1f,%.3f\n", r.sampler, r.declared, r.figure, r.spp, r.sigma,
                   1.03 * ratio);
        }
        if (!(ratio > 0.02)) {
            ++failed;
            printf("%s, %s: %.4f says nothing\n", r.sampler, r.figure, ratio);
        } else if (!print && !(ratio <= r.limit)) {
            ++failed;
            printf("%s declared %u, %s, %u spp, sigma %.1f: %.4f is above %.4f\n", r.sampler,
                   r.declared, r.figure, r.spp, r.sigma, ratio, r.limit);
        }
    }
    if (!print) printf("%d limits, %d exceeded\n", count, failed);
    return count > 0 && failed == 0 ? 0 : 1;
}
