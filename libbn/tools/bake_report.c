/* SPDX-License-Identifier: Apache-2.0
 * What a tile is worth on integrands it was not made for. */
#include "bake_tile.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void blur(const float *in, float *out, float *scratch, uint32_t n, double sigma) {
    double kernel[65];
    int radius = (int)ceil(5.0 * sigma);
    double total = 0.0;
    for (int d = -radius; d <= radius; ++d) total += exp(-d * d / (2.0 * sigma * sigma));
    for (int d = 0; d <= radius; ++d) kernel[d] = exp(-d * d / (2.0 * sigma * sigma)) / total;
    for (int pass = 0; pass < 2; ++pass) {
        const float *source = pass == 0 ? in : scratch;
        float *target = pass == 0 ? scratch : out;
        for (uint32_t y = 0; y < n; ++y) {
            for (uint32_t x = 0; x < n; ++x) {
                double sum = 0.0;
                for (int d = -radius; d <= radius; ++d) {
                    uint32_t qx = pass == 0 ? (x + (uint32_t)d) & (n - 1) : x;
                    uint32_t qy = pass == 1 ? (y + (uint32_t)d) & (n - 1) : y;
                    sum += kernel[abs(d)] * source[qy * n + qx];
                }
                target[y * n + x] = (float)sum;
            }
        }
    }
}

/* RMSE along axis-aligned edges: of steps in each coordinate, blurred with sigma 2.1 along rows and
 * along columns only, as a ratio to white noise, for every prefix. */
static void print_edges(const tile *t) {
    enum { RADIUS = 8, TESTS = 15 };
    uint32_t n = t->opt.size, pixels = n * n;
    double kernel[2 * RADIUS + 1], total = 0.0, gain = 0.0;
    for (int d = -RADIUS; d <= RADIUS; ++d)
        total += kernel[d + RADIUS] = exp(-d * d / (2.0 * 2.1 * 2.1));
    for (int d = 0; d <= 2 * RADIUS; ++d) gain += kernel[d] * kernel[d] / (total * total);
    float *errors = allocate((size_t)LEVELS * pixels, sizeof *errors);
    double error[LEVELS] = {0}, white[LEVELS] = {0};
    for (int test = 0; test < 2 * TESTS; ++test) {
        double c = (test % TESTS + 1.0) / (TESTS + 1.0);
        for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
            uint32_t entry = t->entries[pixel], start = bn_reverse_bits(entry & 255u) >> 24;
            uint32_t inside = 0;
            for (uint32_t i = 0; i < POINTS; ++i) {
                float x, y;
                set_point(t, bn_reverse_bits(i ^ start) >> 24, entry_key(entry), entry >> 16 & 255u,
                          entry >> 24, &x, &y);
                inside += (test < TESTS ? x : y) < c;
                for (int level = 0; level < LEVELS; ++level) {
                    if (i + 1 == 1u << level) {
                        errors[(size_t)level * pixels + pixel] =
                            (float)((double)inside / (i + 1) - c);
                    }
                }
            }
        }
        for (int level = 0; level < LEVELS; ++level) {
            const float *e = errors + (size_t)level * pixels;
            for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
                uint32_t x = pixel % n, y = pixel / n;
                double row = 0.0, column = 0.0;
                for (int d = -RADIUS; d <= RADIUS; ++d) {
                    row += kernel[d + RADIUS] * e[y * n + ((x + (uint32_t)d) & (n - 1))];
                    column += kernel[d + RADIUS] * e[((y + (uint32_t)d) & (n - 1)) * n + x];
                }
                double along = test < TESTS ? column : row;
                error[level] += along * along / (total * total);
            }
            white[level] += pixels * gain * c * (1.0 - c) / (1 << level);
        }
    }
    printf("  edges:    ");
    for (int level = 0; level < LEVELS; ++level) printf(" %.4f", sqrt(error[level] / white[level]));
    printf("\n");
    free(errors);
}

/* Mean RMSE over 40 half-planes after both blurs, as a ratio to white noise, for every prefix. */
void report(const tile *t) {
    enum { tests = 40 };
    uint32_t n = t->opt.size, pixels = n * n;
    float *image = allocate((size_t)pixels * LEVELS, sizeof *image);
    float *blurred = allocate(pixels, sizeof *blurred),
          *scratch = allocate(pixels, sizeof *scratch);
    double error[3][LEVELS] = {{0}}, white[3][LEVELS] = {{0}};
    const double sigma[3] = {0.0, 1.0, 2.1};
    for (int f = 0; f < tests; ++f) {
        random_state random = {mix(4711), (uint64_t)f * 8};
        double angle = 6.283185307179586 * (f + 0.5) / tests;
        double a = cos(angle), b = sin(angle);
        double u = random_double(&random), v = random_double(&random);
        integrand g = {a, b, a * u + b * v, 0.0, 0.0};
        integrand_finish(&g);
        for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
            uint32_t entry = t->entries[pixel], start = bn_reverse_bits(entry & 255u) >> 24;
            double sum = 0.0;
            for (uint32_t i = 0; i < POINTS; ++i) {
                float x, y;
                set_point(t, bn_reverse_bits(i ^ start) >> 24, entry_key(entry), entry >> 16 & 255u,
                          entry >> 24, &x, &y);
                sum += integrand_value(&g, x, y) - g.mean;
                for (int level = 0; level < LEVELS; ++level) {
                    if (i + 1 == 1u << level) {
                        image[(size_t)level * pixels + pixel] = (float)(sum / (i + 1));
                    }
                }
            }
        }
        for (int level = 0; level < LEVELS; ++level) {
            for (int s = 0; s < 3; ++s) {
                const float *errors = image + (size_t)level * pixels;
                double gain = 1.0, square = 0.0;
                if (s > 0) {
                    blur(errors, blurred, scratch, n, sigma[s]);
                    errors = blurred;
                    double one = 0.0, two = 0.0;
                    for (int d = -32; d <= 32; ++d) {
                        double k = exp(-d * d / (2.0 * sigma[s] * sigma[s]));
                        one += k;
                        two += k * k;
                    }
                    gain = two / (one * one);
                }
                for (uint32_t i = 0; i < pixels; ++i) square += (double)errors[i] * errors[i];
                error[s][level] += sqrt(square / pixels);
                white[s][level] += gain * sqrt(g.mean * (1.0 - g.mean) / (1 << level));
            }
        }
    }
    print_edges(t);
    printf("  crowding, worst shape: %.3f of random\n", worst_crowding(t));
    for (int s = 0; s < 3; ++s) {
        printf("  sigma %.1f:", sigma[s]);
        for (int level = 0; level < LEVELS; ++level) {
            printf(" %.4f", error[s][level] / white[s][level]);
        }
        printf("\n");
    }
    fflush(stdout);
    free(image);
    free(blurred);
    free(scratch);
}
