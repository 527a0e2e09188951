/* SPDX-License-Identifier: Apache-2.0
 * How blue the samplers are, against the committed limits in sampler_limits.csv.
 *
 * A row bounds the mean RMSE over 24 half-planes of the blurred per-pixel errors of a 128 x 128
 * picture, relative to white noise (in closed form), for one sampler, declared count, pair, count
 * and blur. In rows of pair `2` the half-planes are x < c, blurred along columns only, and y < c,
 * blurred along rows: edges of a picture that are parallel to its sides, with the position in the
 * pixel drawn from (0,1). Everything is seeded: the figures are the same on every machine but for
 * the rounding of the blur.
 *
 *     test_sampler_quality LIMITS.csv            check
 *     test_sampler_quality LIMITS.csv --print    print the file with limits 3 % above what is
 * measured */
#include <bn/bn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 128, PIXELS = SIZE * SIZE, PLANES = 24, RADIUS = 11 };

typedef struct row {
    char sampler[16];
    uint32_t declared, pair, spp;
    double sigma, limit;
} row;

static double fraction(double v) {
    return v - floor(v);
}

static double column(double edge, double b) {
    double height = edge / b;
    height = height < 0.0 ? 0.0 : height > 1.0 ? 1.0 : height;
    return b > 0.0 ? height : 1.0 - height;
}

/* Half-planes a x + b y < c through well-spread points, at evenly spread angles. */
static double plane(int index, double *a, double *b, double *c) {
    enum { COLUMNS = 4096 };
    double angle = 6.283185307179586 * (index + 0.41) / PLANES, mean = 0.0;
    *a = cos(angle);
    *b = sin(angle);
    *c = *a * fraction(0.5 + 0.7548776662466927 * index) +
         *b * fraction(0.5 + 0.5698402909980532 * index);
    for (int i = 0; i < COLUMNS; ++i) mean += column(*c - *a * (i + 0.5) / COLUMNS, *b);
    return mean / COLUMNS;
}

enum { ALONG_ROWS = 1, ALONG_COLUMNS = 2 };

/* Toroidal blur along rows, columns or both; `gain` is what it makes of the variance of white
 * noise. */
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
    for (int p = 0; p < PIXELS; ++p) {
        double v = 0.0;
        for (int d = -radius; d <= radius; ++d) {
            v += kernel[d + radius] * errors[p / SIZE * SIZE + ((p + d) & (SIZE - 1))];
        }
        rows[p] = directions & ALONG_ROWS ? (float)v : errors[p];
    }
    for (int p = 0; p < PIXELS; ++p) {
        double v = 0.0;
        for (int d = -radius; d <= radius; ++d) {
            v += kernel[d + radius] * rows[(p + d * SIZE) & (PIXELS - 1)];
        }
        if (!(directions & ALONG_COLUMNS)) v = rows[p];
        sum += v * v;
    }
    return sum / PIXELS;
}

static double measure(const bn_sampler *sampler, const row *r, uint32_t domain) {
    static float errors[PLANES][PIXELS];
    double a[PLANES], b[PLANES], c[PLANES], mean[PLANES], error = 0.0, white = 0.0;
    float *samples = malloc((size_t)SIZE * r->spp * 4 * sizeof *samples);
    const int edges = r->pair == 2;
    for (int k = 0; k < PLANES; ++k) {
        mean[k] = plane(k, &a[k], &b[k], &c[k]);
        if (!edges) continue;
        a[k] = k % 2 == 0;
        b[k] = k % 2 != 0;
        c[k] = mean[k] = (k / 2 + 0.5) / (PLANES / 2);
    }
    for (int y = 0; y < SIZE; ++y) {
        if (bn_sample_block(sampler, 0, y, SIZE, 1, 0, r->spp, domain, samples,
                            (size_t)SIZE * r->spp * 4) != BN_SUCCESS) {
            exit(1);
        }
        for (int x = 0; x < SIZE; ++x) {
            const float *u = samples + (size_t)x * r->spp * 4 + (edges ? 0 : 2 * r->pair);
            for (int k = 0; k < PLANES; ++k) {
                uint32_t inside = 0;
                for (uint32_t i = 0; i < r->spp; ++i) {
                    inside += a[k] * u[4 * i] + b[k] * u[4 * i + 1] < c[k];
                }
                errors[k][y * SIZE + x] = (float)((double)inside / r->spp - mean[k]);
            }
        }
    }
    for (int k = 0; k < PLANES; ++k) {
        double gain;
        int directions = !edges       ? ALONG_ROWS | ALONG_COLUMNS
                         : k % 2 == 0 ? ALONG_COLUMNS
                                      : ALONG_ROWS;
        error += sqrt(blurred_square(errors[k], r->sigma, directions, &gain));
        white += sqrt(gain * mean[k] * (1.0 - mean[k]) / r->spp);
    }
    free(samples);
    return error / white;
}

/* The mean over domains: half-planes are not alike where coordinates are exchanged. */
static double measure_domains(const bn_sampler *sampler, const row *r) {
    enum { DOMAINS = 4 };
    double sum = 0.0;
    for (uint32_t k = 0; k < DOMAINS; ++k) {
        sum += measure(sampler, r, bn_domain_child(BN_DOMAIN_ROOT, 4u * r->spp + k));
    }
    return sum / DOMAINS;
}

static bn_sampler *make(const row *r) {
    static const char *const names[] = {"blue", "sobol", "white", "zorder", "mask"};
    bn_sampler_options options = bn_sampler_options_default();
    bn_sampler *sampler = NULL;
    options.samples_per_pixel = r->declared;
    options.kind = -1;
    for (int32_t kind = 0; kind < 5; ++kind) {
        if (strcmp(r->sampler, names[kind]) == 0) options.kind = kind;
    }
    bn_sampler_create(&options, &sampler);
    return sampler;
}

int main(int argc, char **argv) {
    if (argc < 2) return 2;
    FILE *file = fopen(argv[1], "r");
    int print = argc > 2 && strcmp(argv[2], "--print") == 0, rows = 0, failed = 0;
    char line[256];
    if (file == NULL || fgets(line, sizeof line, file) == NULL) return 2;
    if (print) fputs(line, stdout);
    while (fgets(line, sizeof line, file) != NULL) {
        row r;
        if (sscanf(line, "%15[^,],%u,%u,%u,%lf,%lf", r.sampler, &r.declared, &r.pair, &r.spp,
                   &r.sigma, &r.limit) != 6 ||
            r.pair > 2 || r.spp == 0) {
            fprintf(stderr, "not a row: %s", line);
            return 2;
        }
        bn_sampler *sampler = make(&r);
        if (sampler == NULL) return 2;
        double ratio = measure_domains(sampler, &r);
        bn_sampler_destroy(sampler);
        ++rows;
        if (print) {
            printf("%s,%u,%u,%u,%.1f,%.3f\n", r.sampler, r.declared, r.pair, r.spp, r.sigma,
                   1.03 * ratio);
        } else if (!(ratio <= r.limit)) {
            ++failed;
            printf("%s declared %u pair %u, %u spp, sigma %.1f: %.4f is above %.4f\n", r.sampler,
                   r.declared, r.pair, r.spp, r.sigma, ratio, r.limit);
        }
    }
    fclose(file);
    if (!print) printf("%d limits, %d exceeded\n", rows, failed);
    return rows > 0 && failed == 0 ? 0 : 1;
}
