/* SPDX-License-Identifier: Apache-2.0
 * The tile of bn_bake_sampler: memory, test integrands, point sets and the start of the search. */
#include "bake_tile.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "bn_bake_sampler: out of memory\n");
        exit(1);
    }
    return memory;
}

double integrand_value(const integrand *f, double x, double y) {
    if (f->r > 0.0) return (x - f->a) * (x - f->a) + (y - f->b) * (y - f->b) < f->r ? 1.0 : 0.0;
    return f->a * x + f->b * y < f->c ? 1.0 : 0.0;
}

/* The length of the part of [0, 1] that a column at x has inside. */
static double integrand_column(const integrand *f, double x) {
    double low = 0.0, high = 1.0;
    if (f->r > 0.0) {
        double square = f->r - (x - f->a) * (x - f->a);
        if (square <= 0.0) return 0.0;
        low = f->b - sqrt(square);
        high = f->b + sqrt(square);
    } else if (fabs(f->b) < 1e-9) {
        return f->a * x < f->c ? 1.0 : 0.0;
    } else if (f->b > 0.0) {
        high = (f->c - f->a * x) / f->b;
    } else {
        low = (f->c - f->a * x) / f->b;
    }
    low = low < 0.0 ? 0.0 : low;
    high = high > 1.0 ? 1.0 : high;
    return high > low ? high - low : 0.0;
}

void integrand_finish(integrand *f) {
    enum { columns = 4096 };
    double sum = 0.0;
    for (int i = 0; i < columns; ++i) sum += integrand_column(f, (i + 0.5) / columns);
    f->mean = sum / columns;
}

/* Integrand number `index` of an endless, well-spread sequence: angle and point by the additive
 * recurrence of the generalised golden ratio in three dimensions. */
integrand integrand_make(uint64_t seed, uint64_t index) {
    const double tau = 6.283185307179586;
    double u[3];
    const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int i = 0; i < 3; ++i) {
        double start = (double)(mix(seed + (uint64_t)i) >> 11) * 0x1p-53;
        u[i] = start + step[i] * (double)(index + 1);
        u[i] -= floor(u[i]);
    }
    integrand f;
    if (index % 8 == 7) {
        double radius = 0.15 + 0.6 * u[0];
        f = (integrand){1.5 * u[1] - 0.25, 1.5 * u[2] - 0.25, 0.0, radius * radius, 0.0};
    } else {
        double a = cos(tau * u[0]), b = sin(tau * u[0]);
        f = (integrand){a, b, a * u[1] + b * u[2], 0.0, 0.0};
    }
    integrand_finish(&f);
    return f;
}

/* The same for edges parallel to an axis: x < c or y < c. */
integrand step_make(uint64_t index, int axis, int k) {
    double shift = 0.6180339887498949 * (double)index;
    integrand f = {axis == 0, axis == 1, (k + shift - floor(shift)) / LANES, 0.0, 0.0};
    f.mean = f.c;
    return f;
}

uint32_t entry_make(uint32_t sx, uint32_t sy, uint32_t fx, uint32_t fy) {
    return sx | sy << 8 | fx << 16 | fy << 24;
}

/* x has the digits j of a shifted index where y has those of j ^ key. */
uint32_t entry_key(uint32_t entry) {
    return (entry ^ entry >> 8) & 255u;
}

/* The point j of a set: in the middle of what the table fixes. */
void set_point(const tile *t, uint32_t j, uint32_t key, uint32_t fx, uint32_t fy, float *x,
               float *y) {
    uint32_t ux = (t->digits.x[j] ^ fx << 16) & 0xffff0000u;
    uint32_t uy = (t->digits.y[j ^ key] ^ fy << 16) & 0xffff0000u;
    *x = (float)((ux | 0x8000u) * 0x1p-32);
    *y = (float)((uy | 0x8000u) * 0x1p-32);
}

/* The start: consecutive blocks of as many points as the table is for along a scrambled Morton
 * curve. */
static void tile_start(tile *t) {
    uint32_t n = t->opt.size, bits = 0;
    while ((1u << bits) < n) ++bits;
    for (uint32_t y = 0; y < n; ++y) {
        for (uint32_t x = 0; x < n; ++x) {
            uint32_t m = 0, path = 1;
            /* The quadrants of each node of the quadtree in a random order. */
            for (uint32_t level = bits; level-- > 0;) {
                uint32_t quadrant = (y >> level & 1u) << 1 | (x >> level & 1u);
                uint32_t order[4] = {0, 1, 2, 3};
                random_state random = {mix(t->opt.seed) ^ path, 0};
                for (uint32_t i = 3; i > 0; --i) {
                    uint32_t j = (uint32_t)(random_u64(&random) % (i + 1));
                    uint32_t swap = order[i];
                    order[i] = order[j];
                    order[j] = swap;
                }
                m = m << 2 | order[quadrant];
                path = path << 2 | quadrant;
            }
            uint32_t digits = bn_reverse_bits(m * t->opt.declared);
            uint32_t second = bn_sobol_second(digits);
            /* The first eight digits of y, taken back to digits of the index: the map is its own
             * inverse. */
            uint32_t key = bn_sobol_second(second & 0xff000000u) >> 24;
            t->entries[y * n + x] =
                entry_make(digits >> 24, key, digits >> 16 & 255u, second >> 16 & 255u);
        }
    }
}

static int make_neighbours(const options *opt, neighbour *out) {
    int n = 0, reach = (int)opt->size / BLOCKS < 12 ? (int)opt->size / BLOCKS : 12;
    for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
            /* Twice-blurred: the autocorrelation of a Gaussian has twice its variance. */
            double d2 = dx * dx + dy * dy;
            double w = (1.0 - opt->wide) * exp(-d2 / (4.0 * opt->sigma[0] * opt->sigma[0])) +
                       opt->wide * exp(-d2 / (4.0 * opt->sigma[1] * opt->sigma[1]));
            if ((dx == 0 && dy == 0) || w < 0.002) continue;
            if (out != NULL) out[n] = (neighbour){dx, dy, (float)w};
            ++n;
        }
    }
    return n;
}

/* Along rows and columns: for edges that are parallel to them, all of whose pixels have the same
 * integrand while those beside them have none. */
static int make_line(const options *opt, neighbour *out) {
    int n = 0, reach = (int)opt->size / BLOCKS < 7 ? (int)opt->size / BLOCKS : 7;
    for (int d = -reach; d <= reach; ++d) {
        if (d == 0) continue;
        float w = (float)(0.5 * (exp(-d * d / (4.0 * opt->sigma[0] * opt->sigma[0])) +
                                 exp(-d * d / (4.0 * opt->sigma[1] * opt->sigma[1]))));
        if (out != NULL) {
            out[n] = (neighbour){d, 0, w};
            out[n + 1] = (neighbour){0, d, w};
        }
        n += 2;
    }
    return n;
}

void tile_create(tile *t, const options *opt) {
    memset(t, 0, sizeof *t);
    t->opt = *opt;
    size_t pixels = (size_t)opt->size * opt->size, count = opt->integrands;
    t->entries = allocate(pixels, sizeof *t->entries);
    t->errors = allocate(pixels * LEVELS * count, sizeof *t->errors);
    t->a = allocate(5 * count, sizeof *t->a);
    t->b = t->a + count;
    t->c = t->b + count;
    t->r = t->c + count;
    t->mean = t->r + count;
    t->neighbour_count = make_neighbours(opt, NULL);
    t->neighbours = allocate((size_t)t->neighbour_count, sizeof *t->neighbours);
    make_neighbours(opt, t->neighbours);
    t->line_count = make_line(opt, NULL);
    t->line = allocate((size_t)t->line_count, sizeof *t->line);
    make_line(opt, t->line);
    t->occupied = allocate(PARTITIONS, sizeof *t->occupied);
    t->changes = allocate(BLOCKS * BLOCKS / 4, sizeof *t->changes);
    bn_digit_tables_fill(&t->digits);
    make_partitions(t);
    tile_start(t);
    count_cells(t);
}

void tile_destroy(tile *t) {
    free(t->entries);
    free(t->errors);
    free(t->a);
    free(t->neighbours);
    free(t->line);
    free(t->occupied);
    free(t->changes);
}
