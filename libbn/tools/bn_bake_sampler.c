/* SPDX-License-Identifier: Apache-2.0
 * Makes the table behind BN_SAMPLER_BLUE.
 *
 * Every pixel of a tile owns a set of 256 points, a (0,8,2)-net given by a digital shift (two
 * bytes) of one Owen-scrambled Sobol' set and by its next eight digits (two bytes). The first 2^l
 * samples of a pixel are a dyadic block of its set, so the order of the samples is a path in a
 * binary tree of blocks. With the errors of every block for many test integrands (half-planes and
 * discs), and the errors of the neighbouring pixels weighted by the Gaussian the picture is seen
 * through, the best of all 256 orders is a shortest path in that tree. Coordinate descent over
 * pixels, orders and random proposals of other sets minimises the blurred error of all nine
 * prefixes together. (The energy is that of Georgiev and Fajardo, "Blue-noise Dithered Sampling",
 * 2016, and Heitz et al., "A Low-Discrepancy Sampler that Distributes Monte Carlo Errors as a Blue
 * Noise in Screen Space", 2019; the start is the hierarchical order of Ahmed and Wonka, 2020.)
 *
 * The result depends on the options alone, not on the number of threads, and sums are made in a
 * fixed order without fused operations: the same bytes on every machine. */
#include <bn/bn_draw.h>
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { LEVELS = 9, POINTS = 256, LANES = 16, PARTITIONS = 10, MAX_CELLS = 1 << 14 };

typedef struct options {
    uint32_t size;
    uint32_t integrands;
    uint32_t sweeps;
    uint32_t proposals;
    uint32_t threads;
    uint64_t seed;
    double wide;     /* weight of the wider of the two blurs, the rest is the narrow one's */
    double sigma[2]; /* the two blurs, in pixels */
    double level_weight[LEVELS];
    double temperature; /* at the first sweep; falls to zero over the sweeps */
    double evenness;    /* weight of the evenness of the first samples over the tile */
    double refresh;     /* share of the integrands that is replaced before each sweep */
    double seconds;     /* stop after this long; 0: run all sweeps */
    const char *output;
    const char *resume;
} options;

/* ---- Random numbers: a counter hashed with SplitMix64
 * --------------------------------------------- */

static uint64_t mix(uint64_t v) {
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

typedef struct random_state {
    uint64_t key, counter;
} random_state;

static uint64_t random_u64(random_state *state) {
    return mix(state->key ^ mix(state->counter++));
}
static double random_double(random_state *state) {
    return (double)(random_u64(state) >> 11) * 0x1p-53;
}

/* ---- Test integrands
 * ------------------------------------------------------------------------------ */

/* A half-plane a x + b y < c, or with r > 0 the disc (x - a)^2 + (y - b)^2 < r. */
typedef struct integrand {
    double a, b, c, r, mean;
} integrand;

static double integrand_value(const integrand *f, double x, double y) {
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

static void integrand_finish(integrand *f) {
    enum { columns = 4096 };
    double sum = 0.0;
    for (int i = 0; i < columns; ++i) sum += integrand_column(f, (i + 0.5) / columns);
    f->mean = sum / columns;
}

/* Integrand number `index` of an endless, well-spread sequence: angle and point by the additive
 * recurrence of the generalised golden ratio in three dimensions. */
static integrand integrand_make(uint64_t seed, uint64_t index, int allow_discs) {
    const double tau = 6.283185307179586;
    double u[3];
    const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    for (int i = 0; i < 3; ++i) {
        double start = (double)(mix(seed + (uint64_t)i) >> 11) * 0x1p-53;
        u[i] = start + step[i] * (double)(index + 1);
        u[i] -= floor(u[i]);
    }
    integrand f;
    if (allow_discs && index % 8 == 7) {
        double radius = 0.15 + 0.6 * u[0];
        f = (integrand){1.5 * u[1] - 0.25, 1.5 * u[2] - 0.25, 0.0, radius * radius, 0.0};
    } else {
        double a = cos(tau * u[0]), b = sin(tau * u[0]);
        f = (integrand){a, b, a * u[1] + b * u[2], 0.0, 0.0};
    }
    integrand_finish(&f);
    return f;
}

/* ---- The tile
 * ------------------------------------------------------------------------------------- */

typedef struct neighbour {
    int dx, dy;
    float weight;
} neighbour;

typedef struct partition {
    int bits_x, bits_y;
    float scale; /* one over the mean count of a cell */
} partition;

typedef struct tile {
    options opt;
    partition partitions[PARTITIONS];
    uint8_t second[256];   /* the first eight digits of y for those of the index */
    uint32_t *entries;     /* [size][size], the table that is made */
    float *errors;         /* [size][size][LEVELS][integrands] */
    integrand *integrands; /* [integrands] */
    float *a, *b, *c, *r;  /* the same, one array per parameter */
    float *mean;
    neighbour *neighbours;
    int neighbour_count;
    float level_weight[LEVELS];
    int32_t (*occupied)[MAX_CELLS]; /* [PARTITIONS]: entries in every cell of every partition */
    int32_t (*changes)[PARTITIONS][MAX_CELLS]; /* of each block of the colour being visited */
    uint64_t next_integrand;
    uint32_t sweep;
    bn_digit_tables digits;
} tile;

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "bn_bake_sampler: out of memory\n");
        exit(1);
    }
    return memory;
}

static uint32_t entry_make(uint32_t sx, uint32_t sy, uint32_t fx, uint32_t fy) {
    return sx | sy << 8 | fx << 16 | fy << 24;
}

/* x has the digits j of a shifted index where y has those of j ^ key. */
static uint32_t entry_key(uint32_t entry) {
    return (entry ^ entry >> 8) & 255u;
}

/* The point j of a set: in the middle of what the table fixes. */
static void set_point(const tile *t, uint32_t j, uint32_t key, uint32_t fx, uint32_t fy, float *x,
                      float *y) {
    uint32_t ux = (t->digits.x[j] ^ fx << 16) & 0xffff0000u;
    uint32_t uy = (t->digits.y[j ^ key] ^ fy << 16) & 0xffff0000u;
    *x = (float)((ux | 0x8000u) * 0x1p-32);
    *y = (float)((uy | 0x8000u) * 0x1p-32);
}

/* The start: consecutive blocks of 256 points along a scrambled Morton curve. */
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
            uint32_t digits = bn_reverse_bits(m) >> 8; /* index digits from the ninth on */
            uint32_t second = bn_sobol_second(digits);
            /* The first eight digits of y, taken back to digits of the index: the map is its own
             * inverse. */
            uint32_t key = bn_sobol_second(second & 0xff000000u) >> 24;
            t->entries[y * n + x] = entry_make(0, key, digits >> 16 & 255u, second >> 16 & 255u);
        }
    }
}

static float *tile_errors(const tile *t, uint32_t pixel) {
    return t->errors + (size_t)pixel * LEVELS * t->opt.integrands;
}

/* The integrands begin .. end - 1 at all points of a set, [POINTS][LANES], points in index order.
 */
static void evaluate(const tile *t, const float *xs, const float *ys, uint32_t begin, float *out) {
    float a[LANES], b[LANES], c[LANES], r[LANES], mean[LANES];
    for (int i = 0; i < LANES; ++i) {
        a[i] = t->a[begin + i];
        b[i] = t->b[begin + i];
        c[i] = t->c[begin + i];
        r[i] = t->r[begin + i];
        mean[i] = t->mean[begin + i];
    }
    for (int p = 0; p < POINTS; ++p) {
        float x = xs[p], y = ys[p];
        for (int i = 0; i < LANES; ++i) {
            float dx = x - a[i], dy = y - b[i];
            float disc = dx * dx + dy * dy < r[i] ? 1.0f : 0.0f;
            float plane = a[i] * x + b[i] * y < c[i] ? 1.0f : 0.0f;
            out[p * LANES + i] = (r[i] > 0.0f ? disc : plane) - mean[i];
        }
    }
}

static void set_points_in_order(const tile *t, uint32_t k, uint32_t fx, uint32_t fy, float *xs,
                                float *ys) {
    for (uint32_t index = 0; index < POINTS; ++index) {
        set_point(t, bn_reverse_bits(index) >> 24, k, fx, fy, &xs[index], &ys[index]);
    }
}

/* The errors of all prefixes of one pixel for integrands begin .. begin + LANES - 1. */
static void pixel_errors(tile *t, uint32_t pixel, uint32_t begin) {
    float xs[POINTS], ys[POINTS], values[POINTS * LANES];
    uint32_t entry = t->entries[pixel], start = bn_reverse_bits(entry & 255u) >> 24;
    float *errors = tile_errors(t, pixel);
    set_points_in_order(t, entry_key(entry), entry >> 16 & 255u, entry >> 24, xs, ys);
    evaluate(t, xs, ys, begin, values);
    for (int level = 0; level < LEVELS; ++level) {
        uint32_t first = start >> level << level;
        float sum[LANES] = {0};
        for (uint32_t p = first; p < first + (1u << level); ++p) {
            for (int i = 0; i < LANES; ++i) sum[i] += values[p * LANES + i];
        }
        float scale = 1.0f / (float)(1 << level);
        for (int i = 0; i < LANES; ++i) {
            errors[(size_t)level * t->opt.integrands + begin + i] = sum[i] * scale;
        }
    }
}

/* ---- Evenness ---------------------------------------------------------------------------------
 * The estimate of a whole picture must not be biased: over the tile, the first samples have to fill
 * the unit square evenly, and so then do all others, which are digital shifts of them. The
 * elementary intervals of several shapes count the entries in them, and crowded ones cost energy.
 */

/* Five shapes with 4 entries per cell and five with 64, for a tile of 2^log2 pixels. */
static void make_partitions(tile *t) {
    int log2 = 0;
    while (1u << log2 < t->opt.size * t->opt.size) ++log2;
    for (int i = 0; i < PARTITIONS; ++i) {
        int bits = i < 5 ? log2 - 2 : log2 - 6;
        int bits_x = bits / 2 + (i % 5 - 2) * (i < 5 ? 1 : 2);
        if (bits_x > (bits < 8 ? bits : 8)) bits_x = bits < 8 ? bits : 8;
        if (bits_x < 0) bits_x = 0;
        int bits_y = bits - bits_x > 8 ? 8 : bits - bits_x;
        float scale = (float)(1 << (bits_x + bits_y)) / (float)(t->opt.size * t->opt.size);
        t->partitions[i] = (partition){bits_x, bits_y, scale};
    }
    for (uint32_t d = 0; d < 256; ++d) t->second[d] = (uint8_t)(bn_sobol_second(d << 24) >> 24);
}

static uint32_t cell_of(const tile *t, int i, uint32_t entry) {
    partition p = t->partitions[i];
    uint32_t x = entry & 255u, y = t->second[entry >> 8 & 255u];
    return x >> (8 - p.bits_x) << p.bits_y | y >> (8 - p.bits_y);
}

static void count_cells(tile *t) {
    memset(t->occupied, 0, PARTITIONS * sizeof *t->occupied);
    for (int i = 0; i < PARTITIONS; ++i) {
        for (uint32_t pixel = 0; pixel < t->opt.size * t->opt.size; ++pixel) {
            ++t->occupied[i][cell_of(t, i, t->entries[pixel])];
        }
    }
}

/* The energy of one more entry: how full its cells are, relative to the mean. */
static float crowding(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry) {
    float sum = 0.0f;
    for (int i = 0; i < PARTITIONS; ++i) {
        uint32_t cell = cell_of(t, i, entry);
        sum += (float)(t->occupied[i][cell] + change[i][cell]) * t->partitions[i].scale;
    }
    return sum * (float)t->opt.evenness;
}

static void count_entry(const tile *t, int32_t (*change)[MAX_CELLS], uint32_t entry, int32_t by) {
    for (int i = 0; i < PARTITIONS; ++i) change[i][cell_of(t, i, entry)] += by;
}

/* ---- One visit of one pixel
 * ----------------------------------------------------------------------- */

typedef struct workspace {
    float *field; /* [LEVELS][integrands]: what the neighbours add up to */
    float values[POINTS * LANES];
    float dot[2 * POINTS * LANES]; /* partial energies of the nodes, heap order by level */
} workspace;

/* Energies of all 511 nodes of the tree of a set, node[level][block] at offset level_offset. */
static void tree_energies(const tile *t, workspace *w, const float *xs, const float *ys,
                          float energy[2 * POINTS]) {
    uint32_t count = t->opt.integrands;
    memset(w->dot, 0, sizeof w->dot);
    for (uint32_t begin = 0; begin < count; begin += LANES) {
        float *values = w->values;
        evaluate(t, xs, ys, begin, values);
        float *dot = w->dot;
        for (int level = 0; level < LEVELS; ++level) {
            const float *field = w->field + (size_t)level * count + begin;
            float scale = 1.0f / (float)(1 << level);
            int blocks = POINTS >> level;
            for (int block = 0; block < blocks; ++block) {
                float *v = values + block * LANES, *d = dot + block * LANES;
                if (level > 0) {
                    const float *left = values + 2 * block * LANES, *right = left + LANES;
                    for (int i = 0; i < LANES; ++i) v[i] = left[i] + right[i];
                }
                for (int i = 0; i < LANES; ++i) {
                    float e = v[i] * scale;
                    d[i] += e * (e + 2.0f * field[i]);
                }
            }
            dot += blocks * LANES;
        }
    }
    const float *dot = w->dot;
    float *out = energy;
    for (int level = 0; level < LEVELS; ++level) {
        for (int block = 0; block < POINTS >> level; ++block, dot += LANES) {
            float sum = 0.0f;
            for (int i = 0; i < LANES; ++i) sum += dot[i];
            *out++ = sum * t->level_weight[level];
        }
    }
}

/* The cheapest path from the root to a leaf: its cost and its leaf, the index of the first sample.
 */
static float best_path(const float energy[2 * POINTS], uint32_t *leaf) {
    float cost[POINTS];
    uint32_t best[POINTS];
    for (uint32_t i = 0; i < POINTS; ++i) {
        cost[i] = energy[i];
        best[i] = i;
    }
    const float *level_energy = energy + POINTS;
    for (int blocks = POINTS / 2; blocks >= 1; blocks /= 2) {
        for (int block = 0; block < blocks; ++block) {
            int child = cost[2 * block + 1] < cost[2 * block] ? 2 * block + 1 : 2 * block;
            cost[block] = cost[child] + level_energy[block];
            best[block] = best[child];
        }
        level_energy += blocks;
    }
    *leaf = best[0];
    return cost[0];
}

/* Gumbel noise of this scale on every order makes the choice of the best one a draw from the Gibbs
 * distribution at that temperature. */
static float gumbel(random_state *random) {
    return (float)-log(-log(random_double(random) * (1.0 - 0x1p-50) + 0x1p-54));
}

static void visit(tile *t, workspace *w, int32_t (*change)[MAX_CELLS], uint32_t pixel,
                  random_state *random) {
    uint32_t n = t->opt.size, count = t->opt.integrands;
    uint32_t px = pixel % n, py = pixel / n, total = LEVELS * count;
    memset(w->field, 0, total * sizeof *w->field);
    for (int k = 0; k < t->neighbour_count; ++k) {
        const neighbour *q = &t->neighbours[k];
        uint32_t x = (px + (uint32_t)q->dx) & (n - 1), y = (py + (uint32_t)q->dy) & (n - 1);
        const float *errors = tile_errors(t, y * n + x);
        float weight = q->weight;
        for (uint32_t i = 0; i < total; ++i) w->field[i] += weight * errors[i];
    }
    double cooled = 1.0 - (double)t->sweep / t->opt.sweeps;
    float temperature =
        t->sweep + 1 < t->opt.sweeps ? (float)(t->opt.temperature * cooled * cooled) : 0.0f;
    uint32_t entry = t->entries[pixel];
    uint32_t best_k = entry_key(entry), best_fx = entry >> 16 & 255u, best_fy = entry >> 24;
    uint32_t best_leaf = 0;
    float best = INFINITY;
    count_entry(t, change, entry, -1);
    const uint32_t now_k = best_k, now_fx = best_fx, now_fy = best_fy;
    for (uint32_t proposal = 0; proposal <= t->opt.proposals; ++proposal) {
        uint32_t k = now_k, fx = now_fx, fy = now_fy, leaf;
        if (proposal > 0) {
            uint64_t bits = random_u64(random);
            if (bits & 1u) k = (uint32_t)(bits >> 8) & 255u;
            fx = (uint32_t)(bits >> 16) & 255u;
            fy = (uint32_t)(bits >> 24) & 255u;
        }
        float xs[POINTS], ys[POINTS], energy[2 * POINTS];
        set_points_in_order(t, k, fx, fy, xs, ys);
        tree_energies(t, w, xs, ys, energy);
        for (uint32_t i = 0; i < POINTS; ++i) {
            uint32_t first = bn_reverse_bits(i) >> 24;
            energy[i] += crowding(t, change, entry_make(first, first ^ k, 0, 0));
        }
        if (temperature > 0.0f) {
            for (int i = 0; i < POINTS; ++i) energy[i] -= temperature * gumbel(random);
        }
        float cost = best_path(energy, &leaf);
        if (cost < best) {
            best = cost;
            best_k = k;
            best_fx = fx;
            best_fy = fy;
            best_leaf = leaf;
        }
    }
    uint32_t sx = bn_reverse_bits(best_leaf) >> 24;
    uint32_t chosen = entry_make(sx, sx ^ best_k, best_fx, best_fy);
    count_entry(t, change, chosen, 1);
    if (chosen != entry) {
        t->entries[pixel] = chosen;
        for (uint32_t begin = 0; begin < count; begin += LANES) pixel_errors(t, pixel, begin);
    }
}

/* ---- Threads: blocks of one colour are further apart than the blur reaches
 * ------------------------ */

enum { BLOCKS = 4 }; /* per side of the tile */

typedef struct job {
    tile *t;
    atomic_uint next;
    uint32_t colour; /* of the blocks to visit, or BLOCKS for the errors of new integrands */
    uint32_t refresh_begin, refresh_end;
} job;

static void visit_block(tile *t, workspace *w, int32_t (*change)[MAX_CELLS], uint32_t block) {
    uint32_t n = t->opt.size, side = n / BLOCKS, count = side * side;
    uint32_t bx = block % BLOCKS * side, by = block / BLOCKS * side;
    random_state random = {mix(t->opt.seed + 1) ^ mix((uint64_t)t->sweep << 32 | block), 0};
    uint32_t *order = allocate(count, sizeof *order);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t j = (uint32_t)(random_u64(&random) % (i + 1));
        order[i] = order[j];
        order[j] = i;
    }
    for (uint32_t i = 0; i < count; ++i) {
        visit(t, w, change, (by + order[i] / side) * n + bx + order[i] % side, &random);
    }
    free(order);
}

static void *worker(void *argument) {
    job *j = argument;
    tile *t = j->t;
    workspace *w = allocate(1, sizeof *w);
    w->field = allocate((size_t)LEVELS * t->opt.integrands, sizeof *w->field);
    for (;;) {
        uint32_t i = atomic_fetch_add(&j->next, 1);
        if (j->colour < BLOCKS) {
            if (i >= BLOCKS * BLOCKS / 4) break;
            uint32_t bx = i % (BLOCKS / 2) * 2 + (j->colour & 1u);
            uint32_t by = i / (BLOCKS / 2) * 2 + (j->colour >> 1);
            visit_block(t, w, t->changes[i], by * BLOCKS + bx);
        } else {
            if (i >= t->opt.size) break;
            for (uint32_t x = 0; x < t->opt.size; ++x) {
                for (uint32_t b = j->refresh_begin; b < j->refresh_end; b += LANES) {
                    pixel_errors(t, i * t->opt.size + x, b);
                }
            }
        }
    }
    free(w->field);
    free(w);
    return NULL;
}

static void run(job *j) {
    pthread_t threads[64];
    uint32_t count = j->t->opt.threads;
    atomic_store(&j->next, 0);
    for (uint32_t i = 1; i < count; ++i) {
        if (pthread_create(&threads[i], NULL, worker, j) != 0) count = i;
    }
    worker(j);
    for (uint32_t i = 1; i < count; ++i) pthread_join(threads[i], NULL);
}

static void refresh_integrands(tile *t, uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i) {
        integrand f = integrand_make(t->opt.seed + 77, t->next_integrand++, 1);
        t->integrands[i] = f;
        t->a[i] = (float)f.a;
        t->b[i] = (float)f.b;
        t->c[i] = (float)f.c;
        t->r[i] = (float)f.r;
        t->mean[i] = (float)f.mean;
    }
    job j = {t, 0, BLOCKS, begin, end};
    run(&j);
}

/* ---- Weights
 * -------------------------------------------------------------------------------------- */

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

/* Every prefix counts alike: one over the mean squared error of a random pixel at that count. */
static void set_level_weights(tile *t) {
    uint32_t n = t->opt.size * t->opt.size, count = t->opt.integrands;
    for (int level = 0; level < LEVELS; ++level) {
        double sum = 0.0;
        for (uint32_t pixel = 0; pixel < n; ++pixel) {
            const float *e = tile_errors(t, pixel) + (size_t)level * count;
            for (uint32_t i = 0; i < count; ++i) sum += (double)e[i] * e[i];
        }
        t->level_weight[level] = (float)(t->opt.level_weight[level] * n / sum);
    }
}

/* ---- What the tile is worth on integrands it was not made for
 * -------------------------------------- */

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

/* Mean RMSE over 40 half-planes after both blurs, as a ratio to white noise, for every prefix. */
static void report(const tile *t) {
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
    double worst = 0.0;
    for (int i = 0; i < PARTITIONS; ++i) {
        partition p = t->partitions[i];
        double cells = 1 << (p.bits_x + p.bits_y), mean = pixels / cells, chi = 0.0;
        for (int c = 0; c < 1 << (p.bits_x + p.bits_y); ++c) {
            double excess = t->occupied[i][c] - mean;
            chi += excess * excess / mean;
        }
        if (chi / cells > worst) worst = chi / cells;
    }
    printf("  crowding, worst shape: %.3f of random\n", worst);
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

/* ---- Files
 * ---------------------------------------------------------------------------------------- */

static int write_table(const tile *t) {
    char temporary[4096];
    uint32_t count = t->opt.size * t->opt.size;
    if (snprintf(temporary, sizeof temporary, "%s.part", t->opt.output) >= (int)sizeof temporary) {
        return 0;
    }
    FILE *file = fopen(temporary, "wb");
    int good = file != NULL;
    for (uint32_t i = 0; good && i < count; ++i) {
        uint32_t v = t->entries[i];
        unsigned char bytes[4] = {(unsigned char)v, (unsigned char)(v >> 8),
                                  (unsigned char)(v >> 16), (unsigned char)(v >> 24)};
        good = fwrite(bytes, 1, 4, file) == 4;
    }
    if (file != NULL && fclose(file) != 0) good = 0;
    if (good && rename(temporary, t->opt.output) != 0) good = 0;
    if (!good) {
        fprintf(stderr, "bn_bake_sampler: cannot write %s: %s\n", t->opt.output, strerror(errno));
        remove(temporary);
    }
    return good;
}

static int read_table(tile *t) {
    FILE *file = fopen(t->opt.resume, "rb");
    uint32_t count = t->opt.size * t->opt.size;
    int good = file != NULL;
    for (uint32_t i = 0; good && i < count; ++i) {
        unsigned char b[4];
        good = fread(b, 1, 4, file) == 4;
        if (good) t->entries[i] = b[0] | b[1] << 8 | b[2] << 16 | (uint32_t)b[3] << 24;
    }
    if (good && fgetc(file) != EOF) good = 0;
    if (file != NULL) fclose(file);
    if (!good) fprintf(stderr, "bn_bake_sampler: %s holds no table of this size\n", t->opt.resume);
    return good;
}

static const char usage[] = "usage: bn_bake_sampler [--size N] [--integrands N] [--sweeps N] "
                            "[--proposals N] [--threads N]\n"
                            "                       [--seed N] [--wide SHARE] [--level-weights "
                            "W0,...,W8] [--refresh SHARE]\n"
                            "                       [--temperature T] [--evenness W] [--seconds S] "
                            "[--resume FILE] -o FILE\n";

static int parse(int argc, char **argv, options *opt) {
    for (int i = 1; i < argc; ++i) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[++i] : NULL;
        if (value == NULL) return 0;
        char *end = NULL;
        double number = strtod(value, &end);
        int is_number = end != value && *end == '\0' && number >= 0.0 && number <= 1e18;
        if (strcmp(name, "-o") == 0)
            opt->output = value;
        else if (strcmp(name, "--resume") == 0)
            opt->resume = value;
        else if (strcmp(name, "--level-weights") == 0) {
            const char *at = value;
            for (int level = 0; level < LEVELS; ++level) {
                opt->level_weight[level] = strtod(at, &end);
                if (end == at) return 0;
                at = *end == ',' ? end + 1 : end;
            }
        } else if (!is_number)
            return 0;
        else if (strcmp(name, "--size") == 0)
            opt->size = (uint32_t)number;
        else if (strcmp(name, "--integrands") == 0)
            opt->integrands = (uint32_t)number;
        else if (strcmp(name, "--sweeps") == 0)
            opt->sweeps = (uint32_t)number;
        else if (strcmp(name, "--proposals") == 0)
            opt->proposals = (uint32_t)number;
        else if (strcmp(name, "--threads") == 0)
            opt->threads = (uint32_t)number;
        else if (strcmp(name, "--seed") == 0)
            opt->seed = strtoull(value, NULL, 10);
        else if (strcmp(name, "--wide") == 0)
            opt->wide = number;
        else if (strcmp(name, "--temperature") == 0)
            opt->temperature = number;
        else if (strcmp(name, "--evenness") == 0)
            opt->evenness = number;
        else if (strcmp(name, "--refresh") == 0)
            opt->refresh = number;
        else if (strcmp(name, "--seconds") == 0)
            opt->seconds = number;
        else
            return 0;
    }
    uint32_t n = opt->size;
    return opt->output != NULL && n >= 16 && n <= 256 && (n & (n - 1)) == 0 &&
           opt->integrands >= LANES && opt->integrands % LANES == 0 && opt->threads >= 1 &&
           opt->threads <= 64 && opt->wide <= 1.0 && opt->refresh <= 1.0;
}

static double now(void) {
    struct timespec time;
    timespec_get(&time, TIME_UTC);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

int main(int argc, char **argv) {
    tile t;
    memset(&t, 0, sizeof t);
    t.opt = (options){.size = 128,
                      .integrands = 256,
                      .sweeps = 20,
                      .proposals = 2,
                      .threads = 2,
                      .seed = 1,
                      .wide = 0.4,
                      .sigma = {1.05, 2.1},
                      .refresh = 0.0,
                      .evenness = 0.3};
    for (int level = 0; level < LEVELS; ++level) t.opt.level_weight[level] = 1.0;
    if (!parse(argc, argv, &t.opt)) {
        fputs(usage, stderr);
        return 2;
    }
    uint32_t n = t.opt.size, count = t.opt.integrands;
    t.entries = allocate((size_t)n * n, sizeof *t.entries);
    t.errors = allocate((size_t)n * n * LEVELS * count, sizeof *t.errors);
    t.integrands = allocate(count, sizeof *t.integrands);
    t.a = allocate(5 * (size_t)count, sizeof *t.a);
    t.b = t.a + count;
    t.c = t.b + count;
    t.r = t.c + count;
    t.mean = t.r + count;
    t.neighbour_count = make_neighbours(&t.opt, NULL);
    t.neighbours = allocate((size_t)t.neighbour_count, sizeof *t.neighbours);
    make_neighbours(&t.opt, t.neighbours);
    t.occupied = allocate(PARTITIONS, sizeof *t.occupied);
    t.changes = allocate(BLOCKS * BLOCKS / 4, sizeof *t.changes);
    bn_digit_tables_fill(&t.digits);
    make_partitions(&t);
    tile_start(&t);
    refresh_integrands(&t, 0, count);
    set_level_weights(&t);
    if (t.opt.resume != NULL) {
        if (!read_table(&t)) return 1;
        job j = {&t, 0, BLOCKS, 0, count};
        run(&j);
    }
    count_cells(&t);
    printf("start\n");
    report(&t);
    double start = now();
    uint32_t refresh_at = 0, refresh = (uint32_t)(t.opt.refresh * count) / LANES * LANES;
    for (t.sweep = 0; t.sweep < t.opt.sweeps; ++t.sweep) {
        for (uint32_t done = 0; done < refresh && t.sweep > 0; done += LANES) {
            refresh_integrands(&t, refresh_at, refresh_at + LANES);
            refresh_at = (refresh_at + LANES) % count;
        }
        for (uint32_t colour = 0; colour < BLOCKS; ++colour) {
            job j = {&t, 0, colour, 0, 0};
            /* Blocks of one colour see each other's changes only afterwards, whatever the threads.
             */
            memset(t.changes, 0, BLOCKS * BLOCKS / 4 * sizeof *t.changes);
            run(&j);
            count_cells(&t);
        }
        double elapsed = now() - start, each = elapsed / (t.sweep + 1);
        int last = t.sweep + 1 == t.opt.sweeps || (t.opt.seconds > 0 && elapsed > t.opt.seconds);
        if (isatty(2)) {
            fprintf(stderr, "\rsweep %u of %u, %.1f s each, %.0f s left ", t.sweep + 1,
                    t.opt.sweeps, each, each * (t.opt.sweeps - t.sweep - 1));
        }
        if ((t.sweep & 7u) == 7u || last) {
            printf("sweep %u, %.0f s\n", t.sweep + 1, elapsed);
            report(&t);
            if (!write_table(&t)) return 1;
        }
        if (last) break;
    }
    free(t.entries);
    free(t.errors);
    free(t.integrands);
    free(t.a);
    free(t.neighbours);
    free(t.occupied);
    free(t.changes);
    return 0;
}
