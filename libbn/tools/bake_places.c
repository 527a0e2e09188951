/* SPDX-License-Identifier: Apache-2.0
 * The third stage of bn_bake_sampler: assigns the 16 places of each block to its pixels, for one member.
 *
 * Annealing permutes the four pixels of a quarter of a block, or the quarters, which also preserves the
 * nets of 2 x 2 pixels. It minimises the sum over pairs of pixels of the inner product of their features
 * times a kernel, which is the square of the blurred error (Georgiev and Fajardo, "Blue-noise Dithered
 * Sampling", 2016). Each pixel stores the field of all others. A visit to a block computes the products of
 * its fields with all its places once, proposes many swaps at one table lookup each, and then adds the
 * changes to the fields. A visit with 120 proposals takes about 100 us. */
#include "bake_tile.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { REACH = BAKE_REACH, TAPS = BAKE_TAPS, MOST_GROUPS = 5, PROPOSALS = 120 };

/* Features of one type, for labels or, if `other` is set, for two members' labels. */
typedef struct {
    bake_features f;
    const uint16_t *other;
    float *field; /* [PIXELS][f.width]: the kernel's sum over all pixels */
} feature_set;

/* Features that share a blur kernel. */
typedef struct {
    int sets;
    feature_set set[MEMBERS];
    bake_kernel kernel;
    /* Products of features, [BLOCKS][rows][rows]. A row is a place or, if `pixels` is 16, a pixel of the block
     * and a place; otherwise `pixels` is 0. */
    float *gram;
    int rows, pixels;
} feature_group;

typedef struct {
    int groups;
    feature_group group[MOST_GROUPS];
    uint16_t label[PIXELS];
} arrangement;

/* ---- Kernels and products ---- */

void bake_kernel_add(bake_kernel *kernel, int axes, double narrow, double weight) {
    for (int dy = -REACH; dy <= REACH; ++dy) {
        for (int dx = -REACH; dx <= REACH; ++dx) {
            double d = dx * dx + dy * dy;
            if ((axes == 1 && dy != 0) || (axes == 2 && dx != 0)) continue;
            double k = (1 - narrow) * exp(-d / (4 * SIGMA * SIGMA)) + narrow * exp(-d / 4);
            if (k < 0.003) continue;
            kernel->tap[dy + REACH][dx + REACH] += (float)(weight * k);
        }
    }
}

static const float *features_at(const feature_set *s, int pixel, uint32_t label) {
    size_t row = label;
    if (s->other != NULL)
        row = (row & ~(size_t)15) << 4 | (s->other[pixel] & 15u) << 4 | (row & 15u);
    return s->f.rows + row * s->f.width;
}

static void gram_of_block(feature_group *g, const arrangement *t, int block) {
    uint32_t upper = t->label[bake_pixel_of(block, 0)] & ~15u, rows = (uint32_t)g->rows;
    float own[16][16], *gram = g->gram + (size_t)block * rows * rows;
    const feature_set *first = &g->set[0];
    for (uint32_t i = 0; i < 16; ++i) {
        for (uint32_t j = 0; j <= i; ++j) {
            own[i][j] = own[j][i] = bake_inner_product(
                features_at(first, 0, upper | i), features_at(first, 0, upper | j), first->f.width);
        }
    }
    for (uint32_t i = 0; i < rows; ++i) {
        for (uint32_t j = 0; j <= i; ++j) {
            float sum = own[i & 15][j & 15];
            for (int s = 1; s < g->sets; ++s) {
                const feature_set *set = &g->set[s];
                sum += bake_inner_product(
                    features_at(set, bake_pixel_of(block, (int)i >> 4), upper | (i & 15)),
                    features_at(set, bake_pixel_of(block, (int)j >> 4), upper | (j & 15)),
                    set->f.width);
            }
            gram[i * rows + j] = gram[j * rows + i] = sum;
        }
    }
}

/* ---- Fields ---- */

/* Adds a pixel's features under `label` to the fields around it, and subtracts its features under the
 * label `instead`, unless both labels are the same. */
static void spread(feature_group *g, int pixel, uint32_t label, uint32_t instead) {
    int x0 = pixel % SIDE, y0 = pixel / SIDE;
    for (int s = 0; s < g->sets; ++s) {
        feature_set *set = &g->set[s];
        int width = set->f.width;
        float change[512];
        const float *to = features_at(set, pixel, label);
        memcpy(change, to, (size_t)width * sizeof *to);
        if (instead != label) {
            const float *from = features_at(set, pixel, instead);
            for (int k = 0; k < width; ++k) change[k] -= from[k];
        }
        for (int dy = 0; dy < TAPS; ++dy) {
            for (int dx = 0; dx < TAPS; ++dx) {
                float w = g->kernel.tap[dy][dx];
                if (w == 0.0f) continue;
                int x = (x0 + dx - REACH) & (SIDE - 1), y = (y0 + dy - REACH) & (SIDE - 1);
                float *field = set->field + (size_t)(y * SIDE + x) * width;
                for (int k = 0; k < width; ++k) field[k] += w * change[k];
            }
        }
    }
}

static void make_fields(arrangement *t) {
    for (int i = 0; i < t->groups; ++i) {
        feature_group *g = &t->group[i];
        for (int s = 0; s < g->sets; ++s) {
            memset(g->set[s].field, 0, (size_t)PIXELS * g->set[s].f.width * sizeof(float));
        }
        for (int p = 0; p < PIXELS; ++p) spread(g, p, t->label[p], t->label[p]);
    }
}

/* ---- Annealing ---- */

typedef struct {
    int block;
    uint32_t place[16];    /* of the block's pixels */
    float product[16][16]; /* a pixel's field times the features of a place there */
} block_state;

static void enter_block(const arrangement *t, int block, block_state *b) {
    memset(b->product, 0, sizeof b->product);
    b->block = block;
    for (int i = 0; i < t->groups; ++i) {
        const feature_group *g = &t->group[i];
        for (int k = 0; k < 16; ++k) {
            const int p = bake_pixel_of(block, k);
            const uint32_t upper = t->label[p] & ~15u;
            b->place[k] = t->label[p] & 15u;
            for (int s = 0; s < g->sets; ++s) {
                const feature_set *set = &g->set[s];
                const float *field = set->field + (size_t)p * set->f.width;
                for (uint32_t l = 0; l < 16; ++l) {
                    b->product[k][l] +=
                        bake_inner_product(field, features_at(set, p, upper | l), set->f.width);
                }
            }
        }
    }
}

/* A group's kernel between two pixels of a block. */
static float kernel_at(const feature_group *g, int p, int q) {
    return g->kernel.tap[REACH + q / 4 - p / 4][REACH + q % 4 - p % 4];
}

/* The product of the features of place i at pixel p and place j at pixel q. */
static float gram_at(const feature_group *g, const block_state *b, int p, uint32_t i, int q,
                     uint32_t j) {
    const int row = b->block * g->rows + p * g->pixels + (int)i;
    return g->gram[row * g->rows + q * g->pixels + (int)j];
}

static float swap_cost(const arrangement *t, const block_state *b, int p, int q) {
    uint32_t i = b->place[p], j = b->place[q];
    float cost = 2 * (b->product[p][j] - b->product[p][i] + b->product[q][i] - b->product[q][j]);
    for (int n = 0; n < t->groups; ++n) {
        const feature_group *g = &t->group[n];
        float here = gram_at(g, b, p, i, p, i) + gram_at(g, b, p, j, p, j) -
                     2 * gram_at(g, b, p, i, p, j) + gram_at(g, b, q, i, q, i) +
                     gram_at(g, b, q, j, q, j) - 2 * gram_at(g, b, q, i, q, j);
        float between = gram_at(g, b, p, j, q, i) - gram_at(g, b, p, j, q, j) -
                        gram_at(g, b, p, i, q, i) + gram_at(g, b, p, i, q, j);
        cost += kernel_at(g, p, p) * here + 2 * kernel_at(g, p, q) * between;
    }
    return cost;
}

static void swap(const arrangement *t, block_state *b, int p, int q) {
    uint32_t i = b->place[p], j = b->place[q];
    for (int n = 0; n < t->groups; ++n) {
        const feature_group *g = &t->group[n];
        for (int r = 0; r < 16; ++r) {
            const float kp = kernel_at(g, p, r), kq = kernel_at(g, q, r);
            for (uint32_t l = 0; l < 16; ++l) {
                b->product[r][l] += kp * (gram_at(g, b, p, j, r, l) - gram_at(g, b, p, i, r, l)) +
                                    kq * (gram_at(g, b, q, i, r, l) - gram_at(g, b, q, j, r, l));
            }
        }
    }
    b->place[p] = j;
    b->place[q] = i;
}

/* The pixels a move exchanges: two pixels, or the four of one quarter with the four of another. */
static int make_move(uint64_t bits, int from[4], int to[4]) {
    const int quarter = (int)(bits & 3u), p = (int)(bits >> 2 & 3u);
    const int q = (p + 1 + (int)((bits >> 4 & 0xffffu) * 3 >> 16)) & 3;
    if ((bits >> 20 & 7u) != 0) { /* inside a quarter */
        from[0] = (quarter / 2 * 2 + p / 2) * 4 + quarter % 2 * 2 + p % 2;
        to[0] = (quarter / 2 * 2 + q / 2) * 4 + quarter % 2 * 2 + q % 2;
        return 1;
    }
    for (int i = 0; i < 4; ++i) {
        from[i] = (p / 2 * 2 + i / 2) * 4 + p % 2 * 2 + i % 2;
        to[i] = (q / 2 * 2 + i / 2) * 4 + q % 2 * 2 + i % 2;
    }
    return 4;
}

static void visit(arrangement *t, int block, double temperature, bake_random *r) {
    static block_state b;
    enter_block(t, block, &b);
    for (int i = 0; i < PROPOSALS; ++i) {
        const uint64_t bits = bake_random_bits(r);
        int from[4], to[4];
        const int moved = make_move(bits, from, to);
        float cost = 0;
        for (int k = 0; k < moved; ++k) {
            cost += swap_cost(t, &b, from[k], to[k]);
            if (moved > 1) swap(t, &b, from[k], to[k]);
        }
        const int taken =
            cost <= 0 || (cost <= 16 * temperature &&
                          (double)(bits >> 32) * (1.0 / 4294967296.0) < exp(-cost / temperature));
        if (moved == 1 && taken) swap(t, &b, from[0], to[0]);
        for (int k = moved - 1; k >= 0 && moved > 1 && !taken; --k) swap(t, &b, from[k], to[k]);
    }
    for (int k = 0; k < 16; ++k) {
        const int p = bake_pixel_of(block, k);
        const uint16_t old = t->label[p], label = (uint16_t)((old & ~15u) | b.place[k]);
        if (label == old) continue;
        t->label[p] = label;
        for (int n = 0; n < t->groups; ++n) spread(&t->group[n], p, label, old);
    }
}

/* ---- The stage ---- */

static void add_set(feature_group *g, bake_features f, const uint16_t *other) {
    g->set[g->sets++] =
        (feature_set){f, other, bake_allocate((size_t)PIXELS * f.width, sizeof(float))};
}

/* Adds features of one type, weighted by the sum of kernels along two axes (one if the second is 0). */
static feature_group *add_group(arrangement *t, bake_features f, double weight, int axes,
                                int more_axes, double narrow) {
    feature_group *g = &t->group[t->groups++];
    bake_kernel_add(&g->kernel, axes, narrow, weight);
    if (more_axes != 0) bake_kernel_add(&g->kernel, more_axes, narrow, weight);
    add_set(g, f, NULL);
    return g;
}

static arrangement *begin(const bake_table *table, const bake_options *options, int member) {
    arrangement *t = bake_allocate(1, sizeof *t);
#define OF(what) bake_features_of_label(table, options, member, FEATURES_##what)
    feature_group *own = add_group(t, OF(OWN), 1, 3, 0, 0.25);
    for (int a = 0; a < member; ++a) { /* products over two members share the kernel */
        bake_features f = bake_features_of_two(table, options, a, member);
        const float w = (float)sqrt(2.0 / member);
        for (size_t i = 0; i < (size_t)BLOCKS * 256 * f.width; ++i) f.rows[i] *= w;
        add_set(own, f, table->label[a]);
        own->pixels = 16;
    }
    add_group(t, OF(SINGLES), 0.5, 3, 0, 0.25);
    add_group(t, OF(AXES), member == 0 ? 0.4 : 0.12, 1, 2, 0);
    if (member == 0) { /* steps in dimension 0 lie along columns, steps in dimension 1 along rows */
        add_group(t, OF(STEP_X), 1.1, 2, 0, 0.2);
        add_group(t, OF(STEP_Y), 1.1, 1, 0, 0.2);
    }
#undef OF
    memcpy(t->label, table->label[member], sizeof t->label);
    for (int i = 0; i < t->groups; ++i) {
        feature_group *g = &t->group[i];
        g->rows = g->pixels == 0 ? 16 : 256;
        g->gram = bake_allocate((size_t)BLOCKS * g->rows * g->rows, sizeof *g->gram);
        for (int block = 0; block < BLOCKS; ++block) gram_of_block(g, t, block);
    }
    return t;
}

static void end(arrangement *t) {
    for (int i = 0; i < t->groups; ++i) {
        for (int s = 0; s < t->group[i].sets; ++s) {
            free(t->group[i].set[s].f.rows);
            free(t->group[i].set[s].field);
        }
        free(t->group[i].gram);
    }
    free(t);
}

void bake_places(bake_table *table, const bake_options *options, int member) {
    enum { PARTS = 6 };
    arrangement *t = begin(table, options, member);
    const double hot = member == 0 ? 9 : 14, cold = 0.1 * hot;
    const int sweeps = bake_count(options, 90, 1);
    for (int part = 0; part < PARTS; ++part) {
        make_fields(t);
        bake_random r = bake_random_make(options->seed, 7, (uint64_t)(member * 64 + part));
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            for (int i = 0; i < BLOCKS; ++i) {
                double done = (part + (sweep + (double)i / BLOCKS) / sweeps) / PARTS;
                double temperature = hot * pow(cold / hot, done);
                visit(t, (int)bake_random_below(&r, BLOCKS), temperature, &r);
            }
        }
    }
    memcpy(table->label[member], t->label, sizeof t->label);
    end(t);
}
