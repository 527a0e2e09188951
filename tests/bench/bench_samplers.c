/* SPDX-License-Identifier: Apache-2.0
 * Screen-space error of samplers, as CSV on standard output.
 *
 * For an integrand with the same form in every pixel of a picture, the image of per-pixel errors at
 * n samples is blurred with a Gaussian and its RMSE taken, inside a margin that the blur does not
 * reach over. Averaged over the integrands of a family, that is one row:
 *
 *     sampler,declared,family,pair,spp,sigma,rmse,ratio
 *
 * with ratio the RMSE over that of `white` in the same run. The samplers of OpenQMC are measured
 * too in builds with -DBN_OPENQMC=DIR. --samples NAME SPP writes what a sampler draws instead, as
 * float32 [256][256][SPP][4] without a header. The protocol is that of Heitz and Belcour,
 * "Distributing Monte Carlo Errors as a Blue Noise in Screen Space by Permuting Pixel Seeds Between
 * Frames", 2019, widened. */
#include <bn/bn_draw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "bench_openqmc.h"

enum { SIZE = 256, PIXELS = SIZE * SIZE, MARGIN = 12, SIGMAS = 5, MAX_COUNTS = 32, KINDS = 5 };
static const double sigmas[SIGMAS] = {0.0, 0.5, 1.0, 2.1, 3.0};

/* ---- Integrands: a product of two factors, each on two of the four dimensions
 * ---------------------- */

enum { ONE, PLANE, DISC, BUMP, PRODUCT, STEP, WAVE };

typedef struct factor {
    int kind, i, j;
    double a, b, c;
    double sweep; /* how far the edge of a PLANE moves over the width of the picture */
} factor;

typedef struct integrand {
    factor f[2];
} integrand;

static double factor_value(const factor *f, const float *u, double t) {
    double x = u[f->i], y = u[f->j];
    switch (f->kind) {
    case PLANE:
        return f->a * x + f->b * y < f->c + f->sweep * t ? 1.0 : 0.0;
    case DISC:
        return (x - f->a) * (x - f->a) + (y - f->b) * (y - f->b) < f->c ? 1.0 : 0.0;
    case BUMP:
        return exp(-((x - f->a) * (x - f->a) + (y - f->b) * (y - f->b)) / (2.0 * f->c * f->c));
    case PRODUCT:
        return (1.0 - f->a + 2.0 * f->a * x) * (1.0 - f->b + 2.0 * f->b * y);
    case STEP:
        return x < f->a ? 1.0 : 0.0;
    case WAVE:
        return 0.5 + 0.5 * cos(6.283185307179586 * (f->a * x + f->b));
    default:
        return 1.0;
    }
}

static double clamp01(double v) {
    return v < 0.0 ? 0.0 : v > 1.0 ? 1.0 : v;
}

/* The same for `count` samples of a pixel at once; multiplies what is in `values`. */
static void factor_values(const factor *f, const float *u, uint32_t count, double t,
                          float *values) {
    const float a = (float)f->a, b = (float)f->b, c = (float)(f->c + f->sweep * t);
    const float *x = u + f->i, *y = u + f->j;
    switch (f->kind) {
    case ONE:
        break;
    case PLANE:
        for (uint32_t k = 0; k < count; ++k) {
            values[k] = a * x[4 * k] + b * y[4 * k] < c ? values[k] : 0.0f;
        }
        break;
    case DISC:
        for (uint32_t k = 0; k < count; ++k) {
            float dx = x[4 * k] - a, dy = y[4 * k] - b;
            values[k] = dx * dx + dy * dy < c ? values[k] : 0.0f;
        }
        break;
    default:
        for (uint32_t k = 0; k < count; ++k) values[k] *= (float)factor_value(f, u + 4 * k, t);
    }
}

/* The mean over the unit square: columns in closed form where there are edges, a midpoint rule
 * else. */
static double factor_mean(const factor *f, double t) {
    enum { N = 4096, M = 512 };
    double sum = 0.0;
    if (f->kind == ONE) return 1.0;
    if (f->kind == STEP) return f->a;
    if (f->kind == PRODUCT) return 1.0;
    if (f->kind == PLANE || f->kind == DISC) {
        for (int k = 0; k < N; ++k) {
            double x = (k + 0.5) / N, low = 0.0, high = 1.0;
            if (f->kind == DISC) {
                double s = f->c - (x - f->a) * (x - f->a);
                s = s > 0.0 ? sqrt(s) : 0.0;
                low = clamp01(f->b - s);
                high = clamp01(f->b + s);
            } else {
                double edge = (f->c + f->sweep * t - f->a * x) / f->b;
                if (f->b > 0.0)
                    high = clamp01(edge);
                else
                    low = clamp01(edge);
            }
            sum += high - low;
        }
        return sum / N;
    }
    for (int k = 0; k < M * M; ++k) {
        float u[4] = {0};
        u[f->j] = ((float)(k / M) + 0.5f) / M;
        u[f->i] = ((float)(k % M) + 0.5f) / M;
        sum += factor_value(f, u, 0.0);
    }
    return sum / M / M;
}

static uint32_t random_counter;
static double random01(void) {
    return (bn_hash32(bn_hash32(++random_counter) + 12345u) >> 8) * 0x1p-24;
}

static factor plane(int i, int j, double angle, double sweep) {
    double a = cos(angle), b = sin(angle), x = random01(), y = random01();
    return (factor){PLANE, i, j, a, b, a * x + b * y - 0.5 * sweep, sweep};
}
static factor disc(int i, int j) {
    double r = 0.15 + 0.5 * random01();
    return (factor){DISC, i, j, random01(), random01(), r * r, 0.0};
}
static factor bump(int i, int j) {
    return (factor){BUMP, i, j, random01(), random01(), 0.1 + 0.4 * random01(), 0.0};
}
static factor product(int i, int j) {
    return (factor){PRODUCT, i, j, 2.0 * random01() - 1.0, 2.0 * random01() - 1.0, 0.0, 0.0};
}
static const factor one = {ONE, 0, 0, 0, 0, 0, 0};

typedef struct family {
    const char *name;
    int i, j; /* the pair of dimensions, or -1 */
    int count;
    integrand *members;
} family;

static const double tau = 6.283185307179586;

/* Sets of 40: evenly spread angles, other random points in each set. */
static family half_planes(int i, int j, uint32_t first_set, int sets) {
    enum { count = 40 };
    family f = {"half-planes", i, j, count * sets,
                calloc((size_t)count * (size_t)sets, sizeof *f.members)};
    for (int k = 0; k < f.count; ++k) {
        if (k % count == 0) random_counter = 1000000u * (first_set + (uint32_t)(k / count));
        f.members[k] = (integrand){{plane(i, j, tau * (k % count + 0.37) / count, 0.0), one}};
    }
    return f;
}

static family wide(int i, int j, uint32_t set) {
    enum { count = 28 };
    family f = {"wide", i, j, count, calloc(count, sizeof *f.members)};
    random_counter = 1000000u * set + 500000u;
    for (int k = 0; k < count; ++k) {
        factor g;
        switch (k % 7) {
        case 0:
            g = plane(i, j, tau * random01(), 0.0);
            break;
        case 1:
            g = disc(i, j);
            break;
        case 2:
            g = bump(i, j);
            break;
        case 3:
            g = product(i, j);
            break;
        case 4:
            g = (factor){STEP, k % 2 ? i : j, i, 0.1 + 0.8 * random01(), 0, 0, 0};
            break;
        case 5:
            g = (factor){WAVE, k % 2 ? i : j, i, 0.3 + 1.5 * random01(), random01(), 0, 0};
            break;
        default:
            g = plane(i, j, tau * random01(), 0.5);
            break;
        }
        f.members[k] = (integrand){{g, one}};
    }
    return f;
}

static family four_dimensional(uint32_t set) {
    enum { count = 24 };
    family f = {"4-D", -1, -1, count, calloc(count, sizeof *f.members)};
    random_counter = 1000000u * set + 700000u;
    for (int k = 0; k < count; ++k) {
        factor g, h;
        switch (k % 4) {
        case 0:
            g = plane(0, 1, tau * random01(), 0.0), h = plane(2, 3, tau * random01(), 0.0);
            break;
        case 1:
            g = bump(0, 1), h = bump(2, 3);
            break;
        case 2:
            g = plane(0, 2, tau * random01(), 0.0), h = bump(1, 3);
            break;
        default:
            g = disc(0, 3), h = product(1, 2);
            break;
        }
        f.members[k] = (integrand){{g, h}};
    }
    return f;
}

/* ---- Sources of samples
 * --------------------------------------------------------------------------- */

typedef struct source {
    const char *name;
    int32_t kind;
    const bench_peer *peer; /* or null: libbn's sampler of this kind */
} source;

static bn_sampler *open_sampler(const source *s, uint32_t declared) {
    bn_sampler *sampler = NULL;
    bn_sampler_options o = bn_sampler_options_default();
    o.kind = s->kind;
    o.samples_per_pixel = declared;
    if (s->peer == NULL && bn_sampler_create(&o, &sampler) != BN_SUCCESS) exit(1);
    return sampler;
}

/* One row of the picture: [SIZE][count][4]. */
static void read_row(const source *s, const bn_sampler *sampler, int row, uint32_t count,
                     float *out) {
    if (s->peer != NULL) {
        s->peer->read_row(row, SIZE, count, out);
    } else if (bn_sample_block(sampler, 0, row, SIZE, 1, 0, count, bn_domain_child(0, 1), out,
                               (size_t)SIZE * count * 4) != BN_SUCCESS) {
        exit(1);
    }
}

/* Whether `name` is one of the names in `list`, which have commas between them. */
static int is_listed(const char *list, const char *name) {
    size_t length = strlen(name);
    for (const char *at = list; at != NULL; at = strchr(at, ',')) {
        at += *at == ',';
        if (strncmp(at, name, length) == 0 && (at[length] == ',' || at[length] == '\0')) return 1;
    }
    return 0;
}

static int write_samples(const source *s, uint32_t count) {
    bn_sampler *sampler = open_sampler(s, 0);
    size_t size = (size_t)SIZE * count * 4;
    float *samples = malloc(size * sizeof *samples);
    int ok = samples != NULL;
    for (int row = 0; row < SIZE && ok; ++row) {
        read_row(s, sampler, row, count, samples);
        ok = fwrite(samples, sizeof *samples, size, stdout) == size;
    }
    free(samples);
    bn_sampler_destroy(sampler);
    return ok && fflush(stdout) == 0 ? 0 : 1;
}

/* ---- Errors
 * --------------------------------------------------------------------------------------- */

static double blurred_rmse(const float *errors, double sigma, float *scratch) {
    float kernel[MARGIN + 1], row[SIZE];
    double total = 0.0, square = 0.0;
    int radius = sigma > 0.0 ? MARGIN : 0;
    for (int d = 0; d <= radius; ++d) {
        kernel[d] = sigma > 0.0 ? (float)exp(-d * d / (2.0 * sigma * sigma)) : 1.0f;
        total += d == 0 ? kernel[d] : 2.0 * kernel[d];
    }
    for (int y = 0; y < SIZE; ++y) {
        const float *in = errors + y * SIZE;
        float *out = scratch + y * SIZE;
        for (int x = 0; x < SIZE; ++x) out[x] = kernel[0] * in[x];
        for (int d = 1; d <= radius; ++d) {
            for (int x = MARGIN; x < SIZE - MARGIN; ++x)
                out[x] += kernel[d] * (in[x - d] + in[x + d]);
        }
    }
    for (int y = MARGIN; y < SIZE - MARGIN; ++y) {
        const float *in = scratch + y * SIZE;
        for (int x = 0; x < SIZE; ++x) row[x] = kernel[0] * in[x];
        for (int d = 1; d <= radius; ++d) {
            for (int x = 0; x < SIZE; ++x)
                row[x] += kernel[d] * (in[x - d * SIZE] + in[x + d * SIZE]);
        }
        for (int x = MARGIN; x < SIZE - MARGIN; ++x) square += (double)row[x] * row[x];
    }
    return sqrt(square / ((SIZE - 2 * MARGIN) * (SIZE - 2 * MARGIN))) / (total * total);
}

/* Mean RMSE of a family at every count: rmse[count][sigma]. */
static void measure(const source *s, uint32_t declared, const family *f, const uint32_t *counts,
                    int n, double rmse[][SIGMAS]) {
    enum { GROUP = 8 };
    bn_sampler *sampler = open_sampler(s, declared);
    uint32_t last = counts[n - 1];
    float *samples = malloc((size_t)SIZE * last * 4 * sizeof *samples);
    float *images = malloc((size_t)GROUP * n * PIXELS * sizeof *images);
    float *scratch = malloc(PIXELS * sizeof *scratch), *values = malloc(last * sizeof *values);
    memset(rmse, 0, (size_t)n * sizeof *rmse);
    for (int first = 0; first < f->count; first += GROUP) {
        int group = f->count - first < GROUP ? f->count - first : GROUP;
        double means[GROUP][SIZE];
        for (int g = 0; g < group; ++g) {
            const integrand *v = &f->members[first + g];
            for (int x = 0; x < SIZE; ++x) {
                means[g][x] =
                    x > 0 && v->f[0].sweep == 0.0
                        ? means[g][0]
                        : factor_mean(&v->f[0], (double)x / SIZE) * factor_mean(&v->f[1], 0.0);
            }
        }
        for (int y = 0; y < SIZE; ++y) {
            read_row(s, sampler, y, last, samples);
            for (int g = 0; g < group; ++g) {
                const integrand *v = &f->members[first + g];
                for (int x = 0; x < SIZE; ++x) {
                    const float *u = samples + (size_t)x * last * 4;
                    double sum = 0.0, t = (double)x / SIZE;
                    uint32_t i = 0;
                    for (uint32_t k = 0; k < last; ++k) values[k] = 1.0f;
                    factor_values(&v->f[0], u, last, t, values);
                    factor_values(&v->f[1], u, last, t, values);
                    for (int next = 0; next < n; ++next) {
                        for (; i < counts[next]; ++i) sum += values[i];
                        images[((size_t)g * n + next) * PIXELS + y * SIZE + x] =
                            (float)(sum / i - means[g][x]);
                    }
                }
            }
        }
        for (int g = 0; g < group; ++g) {
            for (int c = 0; c < n; ++c) {
                for (int k = 0; k < SIGMAS; ++k) {
                    rmse[c][k] +=
                        blurred_rmse(images + ((size_t)g * n + c) * PIXELS, sigmas[k], scratch) /
                        f->count;
                }
            }
        }
    }
    free(samples);
    free(images);
    free(scratch);
    free(values);
    bn_sampler_destroy(sampler);
}

static const char usage[] =
    "usage: bench_samplers [--max-spp N] [--samplers NAME,...] [--pairs 01,23,02,03,12,13]\n"
    "                      [--set N] [--sets N] [--families half-planes,wide,4-D] [--declared]\n"
    "       bench_samplers --samples NAME SPP\n";

int main(int argc, char **argv) {
    /* White first: the others are related to it. */
    static const source libbn[KINDS] = {{"white", BN_SAMPLER_WHITE, NULL},
                                        {"blue", BN_SAMPLER_BLUE, NULL},
                                        {"sobol", BN_SAMPLER_SOBOL, NULL},
                                        {"zorder", BN_SAMPLER_ZORDER, NULL},
                                        {"mask", BN_SAMPLER_MASK, NULL}};
    source known[KINDS + BENCH_PEERS], sources[KINDS + BENCH_PEERS];
    int known_count = 0, source_count = 0, declared_too = 0, sets = 1;
    uint32_t max_spp = 256, set = 1;
    const char *samplers = NULL /* all */, *pairs = "01,23", *families = "half-planes,wide,4-D";
    while (known_count < KINDS) known[known_count] = libbn[known_count], ++known_count;
    for (int i = 0; i < bench_peer_count; ++i)
        known[known_count++] = (source){bench_peers[i].name, 0, &bench_peers[i]};
    if (argc == 4 && strcmp(argv[1], "--samples") == 0) {
        char *end;
        unsigned long count = strtoul(argv[3], &end, 10);
        for (int i = 0; i < known_count && *end == '\0' && count > 0 && count <= 4096; ++i)
            if (strcmp(argv[2], known[i].name) == 0)
                return write_samples(&known[i], (uint32_t)count);
        fputs(usage, stderr);
        return 2;
    }
    for (int a = 1; a < argc; ++a) {
        if (strcmp(argv[a], "--declared") == 0) {
            declared_too = 1;
            continue;
        }
        const char *value = a + 1 < argc ? argv[a + 1] : NULL;
        if (value == NULL) {
            fputs(usage, stderr);
            return 2;
        }
        if (strcmp(argv[a], "--max-spp") == 0)
            max_spp = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(argv[a], "--set") == 0)
            set = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(argv[a], "--sets") == 0)
            sets = (int)strtoul(value, NULL, 10);
        else if (strcmp(argv[a], "--samplers") == 0)
            samplers = value;
        else if (strcmp(argv[a], "--pairs") == 0)
            pairs = value;
        else if (strcmp(argv[a], "--families") == 0)
            families = value;
        else {
            fputs(usage, stderr);
            return 2;
        }
        ++a;
    }
    for (int i = 0; i < known_count; ++i)
        if (i == 0 || samplers == NULL || is_listed(samplers, known[i].name))
            sources[source_count++] = known[i];
    static const uint32_t all_counts[] = {1,   2,   3,   4,   5,    6,    7,   8,   11,
                                          12,  16,  24,  32,  48,   64,   96,  128, 192,
                                          256, 384, 512, 768, 1000, 1024, 4096};
    uint32_t counts[MAX_COUNTS];
    int n = 0;
    for (size_t i = 0; i < sizeof all_counts / sizeof *all_counts; ++i) {
        if (all_counts[i] <= max_spp) counts[n++] = all_counts[i];
    }
    if (n == 0 || sets < 1 || sets > 100) return 2;
    family list[16];
    int family_count = 0;
    for (const char *p = pairs; p[0] != '\0' && p[1] != '\0'; p += p[2] == ',' ? 3 : 2) {
        int i = p[0] - '0', j = p[1] - '0';
        if (i < 0 || i > 3 || j < 0 || j > 3 || family_count > 12) return 2;
        if (strstr(families, "half-planes")) list[family_count++] = half_planes(i, j, set, sets);
        if (strstr(families, "wide")) list[family_count++] = wide(i, j, set);
    }
    if (strstr(families, "4-D")) list[family_count++] = four_dimensional(set);

    double white[16][MAX_COUNTS][SIGMAS];
    printf("sampler,declared,family,pair,spp,sigma,rmse,ratio\n");
    for (int s = 0; s < source_count; ++s) {
        for (int f = 0; f < family_count; ++f) {
            char pair[8] = "all";
            if (list[f].i >= 0) snprintf(pair, sizeof pair, "%d%d", list[f].i & 3, list[f].j & 3);
            if (isatty(2))
                fprintf(stderr, "\r%-17s %-12s %s   ", sources[s].name, list[f].name, pair);
            double rmse[MAX_COUNTS][SIGMAS];
            measure(&sources[s], 0, &list[f], counts, n, rmse);
            if (s == 0) memcpy(white[f], rmse, sizeof rmse);
            for (int c = 0; c < n; ++c) {
                for (int k = 0; k < SIGMAS; ++k) {
                    printf("%s,0,%s,%s,%u,%.1f,%.6g,%.4f\n", sources[s].name, list[f].name, pair,
                           counts[c], sigmas[k], rmse[c][k], rmse[c][k] / white[f][c][k]);
                }
            }
            /* The others take no notice of it. */
            int declares =
                declared_too && sources[s].peer == NULL &&
                (sources[s].kind == BN_SAMPLER_BLUE || sources[s].kind == BN_SAMPLER_ZORDER);
            for (int c = 0; declares && c < n; ++c) {
                double at[1][SIGMAS];
                if ((counts[c] & (counts[c] - 1)) != 0) continue;
                measure(&sources[s], counts[c], &list[f], &counts[c], 1, at);
                for (int k = 0; k < SIGMAS; ++k) {
                    printf("%s,%u,%s,%s,%u,%.1f,%.6g,%.4f\n", sources[s].name, counts[c],
                           list[f].name, pair, counts[c], sigmas[k], at[0][k],
                           at[0][k] / white[f][c][k]);
                }
            }
            fflush(stdout);
        }
    }
    for (int f = 0; f < family_count; ++f) free(list[f].members);
    return 0;
}
