/* SPDX-License-Identifier: Apache-2.0
 * One sweep of bn_bake_sampler: visits of all pixels, each a shortest path in the tree of its
 * orders. */
#include "bake_tile.h"
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

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
            float own = begin < STEPS ? 1.0f + (float)t->opt.edges[level] : 1.0f;
            int blocks = POINTS >> level;
            for (int block = 0; block < blocks; ++block) {
                float *v = values + block * LANES, *d = dot + block * LANES;
                if (level > 0) {
                    const float *left = values + 2 * block * LANES, *right = left + LANES;
                    for (int i = 0; i < LANES; ++i) v[i] = left[i] + right[i];
                }
                for (int i = 0; i < LANES; ++i) {
                    float e = v[i] * scale;
                    d[i] += e * (own * e + 2.0f * field[i]);
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
    for (int k = 0; k < t->line_count; ++k) {
        const neighbour *q = &t->line[k];
        uint32_t x = (px + (uint32_t)q->dx) & (n - 1), y = (py + (uint32_t)q->dy) & (n - 1);
        const float *errors = tile_errors(t, y * n + x);
        /* Columns for steps in x, the first lanes; rows for steps in y. */
        uint32_t first = q->dx == 0 ? 0 : LANES;
        for (uint32_t level = 0; level < LEVELS; ++level) {
            float weight = q->weight * (float)t->opt.edges[level];
            for (uint32_t i = level * count + first; i < level * count + first + LANES; ++i) {
                w->field[i] += weight * errors[i];
            }
        }
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

static void set_chunk(tile *t, uint32_t chunk, uint64_t number) {
    for (uint32_t i = chunk * LANES, k = 0; k < LANES; ++i, ++k) {
        integrand f = chunk < STEPS / LANES ? step_make(number, (int)chunk, (int)k)
                                            : integrand_make(t->opt.seed + 77, number * LANES + k);
        t->a[i] = (float)f.a;
        t->b[i] = (float)f.b;
        t->c[i] = (float)f.c;
        t->r[i] = (float)f.r;
        t->mean[i] = (float)f.mean;
    }
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

/* The integrands of a sweep: the first ones, with a share of them, in turn, replaced by new ones
 * before every later sweep. */
void tile_set_integrands(tile *t, uint32_t sweep) {
    uint32_t count = t->opt.integrands, chunks = count / LANES;
    uint32_t each = (uint32_t)(t->opt.refresh * count) / LANES;
    uint64_t replaced = (uint64_t)each * sweep, previous = sweep > 0 ? replaced - each : 0;
    /* After a start or a resume all of them are new to this tile. */
    uint64_t first = t->prepared ? previous : replaced > chunks ? replaced - chunks : 0;
    if (!t->prepared) {
        for (uint32_t chunk = 0; chunk < chunks; ++chunk) set_chunk(t, chunk, chunk);
    }
    for (uint64_t i = first; i < replaced; ++i) set_chunk(t, (uint32_t)(i % chunks), chunks + i);
    job j = {t, 0, BLOCKS, 0, count};
    if (t->prepared) {
        for (uint64_t i = first; i < replaced; ++i) {
            j.refresh_begin = (uint32_t)(i % chunks) * LANES;
            j.refresh_end = j.refresh_begin + LANES;
            run(&j);
        }
    } else {
        run(&j);
    }
    if (sweep == 0) set_level_weights(t);
    t->prepared = 1;
    t->sweep = sweep;
}

void tile_sweep(tile *t) {
    for (uint32_t colour = 0; colour < BLOCKS; ++colour) {
        job j = {t, 0, colour, 0, 0};
        /* Blocks of one colour see each other's changes only afterwards, whatever the threads. */
        memset(t->changes, 0, BLOCKS * BLOCKS / 4 * sizeof *t->changes);
        run(&j);
        count_cells(t);
    }
}
