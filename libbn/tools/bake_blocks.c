/* SPDX-License-Identifier: Apache-2.0
 * The second stage of bn_bake_sampler: assigns the upper bits of the labels, one value per block. All members
 * of a family share the assignment.
 *
 * Annealing exchanges children of the quadtree's nodes, which preserves every net. The energy is the same
 * as in bake_places.c, but uses a block's mean features, which do not depend on the arrangement inside it:
 * half-planes and products in all members, products over two members, and steps in the pixel pair. Takes
 * half a minute, most of which is spent on features. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDE = SIDE / 4, NEAR = 3, SPAN = 2 * NEAR + 1, KERNELS = 3 };

typedef struct {
    float gram[KERNELS][BLOCKS][BLOCKS];
    float kernel[KERNELS][SPAN][SPAN]; /* between blocks */
    int upper[BLOCKS];
} block_tile;

/* Sums a kernel over all pairs of pixels from two blocks. */
static void make_kernel(block_tile *t, int which) {
    bake_kernel k;
    memset(&k, 0, sizeof k);
    bake_kernel_add(&k, 3 - which, 0, 1);
    for (int by = -NEAR; by <= NEAR; ++by) {
        for (int bx = -NEAR; bx <= NEAR; ++bx) {
            double sum = 0;
            for (int p = 0; p < 256; ++p) {
                int dx = 4 * bx + p % 4 - p / 4 % 4, dy = 4 * by + p / 16 % 4 - p / 64;
                if (abs(dx) <= BAKE_REACH && abs(dy) <= BAKE_REACH) {
                    sum += k.tap[dy + BAKE_REACH][dx + BAKE_REACH];
                }
            }
            t->kernel[which][by + NEAR][bx + NEAR] = (float)sum;
        }
    }
}

/* Adds the products of the means over every `rows` rows, and frees the features. */
static void add_products(block_tile *t, int which, bake_features f, int rows, double weight) {
    float *mean = bake_allocate((size_t)BLOCKS * f.width, sizeof *mean);
    for (int b = 0; b < BLOCKS; ++b) {
        float *m = mean + (size_t)b * f.width;
        for (int i = 0; i < rows; ++i) {
            const float *row = f.rows + ((size_t)b * rows + i) * f.width;
            for (int k = 0; k < f.width; ++k) m[k] += row[k];
        }
        for (int k = 0; k < f.width; ++k) m[k] /= (float)rows;
    }
    for (int a = 0; a < BLOCKS; ++a) {
        for (int b = 0; b < BLOCKS; ++b) {
            double sum = 0;
            for (int k = 0; k < f.width; ++k) sum += mean[a * f.width + k] * mean[b * f.width + k];
            t->gram[which][a][b] += (float)(weight * sum);
        }
    }
    free(mean);
    free(f.rows);
}

/* The energy that block b would add with labels `upper`. */
static float energy_at(const block_tile *t, int b, int upper) {
    int x0 = b % WIDE, y0 = b / WIDE;
    float sum = 0;
    for (int dy = -NEAR; dy <= NEAR; ++dy) {
        for (int dx = -NEAR; dx <= NEAR; ++dx) {
            if (dx == 0 && dy == 0) continue;
            int other = t->upper[((y0 + dy) & (WIDE - 1)) * WIDE + ((x0 + dx) & (WIDE - 1))];
            sum += t->kernel[0][dy + NEAR][dx + NEAR] * t->gram[0][upper][other];
        }
    }
    for (int d = -NEAR; d <= NEAR; ++d) {
        if (d == 0) continue;
        int below = t->upper[((y0 + d) & (WIDE - 1)) * WIDE + x0];
        int beside = t->upper[y0 * WIDE + ((x0 + d) & (WIDE - 1))];
        sum += t->kernel[1][d + NEAR][NEAR] * t->gram[1][upper][below];
        sum += t->kernel[2][NEAR][d + NEAR] * t->gram[2][upper][beside];
    }
    return sum;
}

/* Exchanges two of a node's four children, each of which has `side` x `side` blocks. */
static void exchange(block_tile *t, int node, int side, int p, int q) {
    const int across = WIDE / (2 * side), x0 = node % across * 2 * side,
              y0 = node / across * 2 * side;
    for (int i = 0; i < side * side; ++i) {
        const int x = i % side, y = i / side;
        const int a = (y0 + p / 2 * side + y) * WIDE + x0 + p % 2 * side + x;
        const int b = (y0 + q / 2 * side + y) * WIDE + x0 + q % 2 * side + x;
        const int upper = t->upper[a];
        t->upper[a] = t->upper[b];
        t->upper[b] = upper;
    }
}

static double energy_of(const block_tile *t) {
    double sum = 0;
    for (int b = 0; b < BLOCKS; ++b) sum += energy_at(t, b, t->upper[b]);
    return sum;
}

static void anneal(block_tile *t, const bake_options *options, double hot) {
    bake_random r = bake_random_make(options->seed, 8, 0);
    int steps = bake_count(options, 60000, 1);
    double energy = energy_of(t);
    for (int i = 0; i < steps; ++i) {
        const double temperature = hot * pow(0.01, (double)i / steps);
        const uint64_t bits = bake_random_bits(&r);
        /* Chooses each level in proportion to its number of nodes, except for the largest nodes. */
        const int level = (bits & 15u) < 9 ? 0 : (bits & 15u) < 13 ? 1 : (bits & 15u) < 15 ? 2 : 3;
        const int side = 1 << level, across = WIDE / (2 * side);
        const int node = (int)((bits >> 4 & 0xffffu) * (uint32_t)(across * across) >> 16);
        const int p = (int)(bits >> 20 & 3u);
        const int q = (p + 1 + (int)((bits >> 22 & 0xffu) * 3 >> 8)) & 3;
        exchange(t, node, side, p, q);
        const double now = energy_of(t), cost = now - energy;
        if (cost > 0 && bake_random_double(&r) >= exp(-cost / temperature)) {
            exchange(t, node, side, p, q);
        } else {
            energy = now;
        }
    }
}

void bake_blocks(bake_table *table, const bake_options *options) {
    block_tile *t = bake_allocate(1, sizeof *t);
    for (int which = 0; which < KERNELS; ++which) make_kernel(t, which);
    for (int a = 0; a < MEMBERS; ++a) {
        add_products(t, 0, bake_features_of_label(table, options, a, FEATURES_OWN), 16,
                     a == 0 ? 1.5 : 1);
        for (int b = 0; b < a; ++b) {
            add_products(t, 0, bake_features_of_two(table, options, b, a), 256, 1);
        }
    }
    for (int axis = 0; axis < 2; ++axis) {
        add_products(t, 1 + axis, bake_features_of_label(table, options, 0, FEATURES_STEP_X + axis),
                     16, 2);
    }
    for (int b = 0; b < BLOCKS; ++b) {
        t->upper[b] = table->label[0][bake_pixel_of(b, 0)] >> 4;
    }
    double scale = 0;
    for (int b = 0; b < BLOCKS; ++b) scale += t->gram[0][b][b] * t->kernel[0][NEAR][NEAR] / BLOCKS;
    anneal(t, options, 0.3 * scale);
    for (int a = 0; a < MEMBERS; ++a) {
        for (int p = 0; p < PIXELS; ++p) {
            int b = p / (4 * SIDE) * WIDE + p % SIDE / 4;
            table->label[a][p] = (uint16_t)(t->upper[b] << 4 | (table->label[a][p] & 15));
        }
    }
    free(t);
}
