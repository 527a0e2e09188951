/* SPDX-License-Identifier: Apache-2.0
 * Relaxation of white noise by learned steps
 *
 *     v <- keep v + sum over offsets o of w_o clip(v_p - v_(p+o), -1, 1),
 *
 * found by the evolution strategy in trainer/. Nothing is ranked between steps: the ranks of the
 * last values are the mask. Values, weights and the rounding of their products are integers of 16
 * bits, each step at a scale of its own at which no sum can overflow. A step makes one image of
 * another, so threads need one barrier a step. Takes BN_RELAX_LEARNED_PAIRS pairs per texel. */
#include "masks/relax_learned.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/threads.h"
#include "masks/relax_schedule.h"
#include "simd/simd.h"
#include <string.h>

enum { REACH = BN_RELAX_LEARNED_REACH, VALUES = 1 << 16, COLUMNS = 256 };

typedef struct learned {
    const bn_relax_options *options;
    const bn_simd *simd;
    uint32_t width, height;
    size_t rows, stride;
    int16_t *image[2];    /* with a toroidal margin of REACH; the steps take turns */
    ptrdiff_t *offsets;   /* of the pairs of all steps */
    int16_t *weights;     /* each repeated BN_WINDOW_LANES times */
    uint32_t *histograms; /* [threads][VALUES] */
    uint32_t sums[BN_RELAX_MOST_THREADS];
    uint32_t *ranks;
    int cancelled[2]; /* in even and odd steps: the first thread may be one step ahead */
} learned;

static uint32_t first_row(const learned *l, uint32_t index, uint32_t threads) {
    return (uint32_t)((uint64_t)l->height * index / threads);
}

static int16_t *row_of(const learned *l, int image, uint32_t y) {
    return l->image[image] + (y + (size_t)REACH) * l->stride + REACH;
}

/* Completes a row of new values: repeats it in the margins left, right, above and below. */
static void wrap(learned *l, int image, uint32_t y) {
    int16_t *row = row_of(l, image, y) - REACH;
    for (size_t at = REACH; at-- > 0;) row[at] = row[at + l->width];
    for (size_t at = REACH + (size_t)l->width; at < l->stride; ++at) row[at] = row[at - l->width];
    for (size_t other = (y + (size_t)REACH) % l->height; other < l->rows; other += l->height) {
        if (other == y + (size_t)REACH) continue;
        memcpy(l->image[image] + other * l->stride, row, l->stride * sizeof *row);
    }
}

static void first_values(learned *l, uint32_t y) {
    int16_t *row = row_of(l, 0, y);
    for (uint32_t x = 0; x < l->width; ++x) {
        const uint64_t i = (uint64_t)y * l->width + x;
        row[x] =
            (int16_t)((int32_t)(bn_mix64(l->options->seed ^ bn_mix64(i + 1)) >> 48) - (1 << 15));
    }
}

static void move(learned *l, const bn_relax_learned_step *s, uint32_t pair, uint32_t pairs,
                 int from, uint32_t y) {
    int16_t moved[COLUMNS + BN_WINDOW_LANES];
    for (uint32_t x0 = 0; x0 < l->width; x0 += COLUMNS) {
        const uint32_t columns = l->width - x0 < COLUMNS ? l->width - x0 : COLUMNS;
        const int16_t *here = row_of(l, from, y) + x0;
        int16_t *there = row_of(l, !from, y) + x0;
        l->simd->relax_row(here, l->offsets + pair, l->weights + (size_t)pair * BN_WINDOW_LANES,
                           pairs, columns, s->limit, s->shift, moved);
        for (uint32_t x = 0; x < columns; ++x)
            there[x] = (int16_t)(moved[x] + ((here[x] * s->keep + (1 << 14)) >> 15));
    }
}

/* Counts the values in the rows of each thread, sums the counts over smaller values and earlier
 * rows, and gives ranks in that order: that of a stable sort, whatever the number of threads. */
static void rank(learned *l, int image, bn_team *team, uint32_t index, uint32_t threads) {
    const uint32_t first = first_row(l, index, threads), last = first_row(l, index + 1, threads);
    uint32_t *mine = l->histograms + (size_t)index * VALUES;
    memset(mine, 0, VALUES * sizeof *mine);
    for (uint32_t y = first; y < last; ++y) {
        const int16_t *row = row_of(l, image, y);
        for (uint32_t x = 0; x < l->width; ++x) ++mine[row[x] + (1 << 15)];
    }
    bn_team_wait(team);
    const uint32_t low = VALUES * index / threads, high = VALUES * (index + 1) / threads;
    uint32_t sum = 0, below = 0;
    for (uint32_t t = 0; t < threads; ++t) {
        for (uint32_t value = low; value < high; ++value)
            sum += l->histograms[(size_t)t * VALUES + value];
    }
    l->sums[index] = sum;
    bn_team_wait(team);
    for (uint32_t t = 0; t < index; ++t) below += l->sums[t];
    for (uint32_t value = low; value < high; ++value) {
        for (uint32_t t = 0; t < threads; ++t) {
            uint32_t *count = &l->histograms[(size_t)t * VALUES + value];
            const uint32_t here = *count;
            *count = below;
            below += here;
        }
    }
    bn_team_wait(team);
    for (uint32_t y = first; y < last; ++y) {
        const int16_t *row = row_of(l, image, y);
        uint32_t *ranks = l->ranks + (size_t)y * l->width;
        for (uint32_t x = 0; x < l->width; ++x) ranks[x] = mine[row[x] + (1 << 15)]++;
    }
}

static uint32_t images_of(const bn_relax_learned_group *g) {
    return g->y == 0 || g->y == g->x ? 4 : 8;
}

static void work(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    learned *l = user;
    const bn_relax_options *o = l->options;
    const uint32_t first = first_row(l, index, threads), last = first_row(l, index + 1, threads);
    for (uint32_t y = first; y < last; ++y) {
        first_values(l, y);
        wrap(l, 0, y);
    }
    bn_team_wait(team);
    uint32_t pair = 0;
    for (int i = 0; i < BN_RELAX_LEARNED_STEPS; ++i) {
        const bn_relax_learned_step *s = &bn_relax_learned_steps[i];
        uint32_t pairs = 0;
        for (uint32_t g = 0; g < s->group_count; ++g) pairs += images_of(&s->groups[g]);
        if (index == 0 && o->progress != NULL) {
            const double fraction = (double)i / BN_RELAX_LEARNED_STEPS;
            l->cancelled[i & 1] = o->progress(o->progress_user, fraction) != 0;
        }
        for (uint32_t y = first; y < last; ++y) {
            move(l, s, pair, pairs, i & 1, y);
            wrap(l, !(i & 1), y);
        }
        pair += pairs;
        bn_team_wait(team);
        if (l->cancelled[i & 1]) return;
    }
    rank(l, BN_RELAX_LEARNED_STEPS & 1, team, index, threads);
}

static void fill_pairs(learned *l) {
    static const int8_t sign[4][2] = {{1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
    uint32_t pair = 0;
    for (int i = 0; i < BN_RELAX_LEARNED_STEPS; ++i) {
        const bn_relax_learned_step *s = &bn_relax_learned_steps[i];
        for (uint32_t g = 0; g < s->group_count; ++g) {
            const ptrdiff_t x = s->groups[g].x, y = s->groups[g].y, stride = (ptrdiff_t)l->stride;
            const uint32_t count = images_of(&s->groups[g]);
            for (uint32_t k = 0; k < count; ++k, ++pair) {
                /* With x and y swapped: the other four of eight, or of an axis the other two. */
                const int swap = y == 0 ? k >= 2 : k >= 4;
                const int8_t *by = sign[y == 0 ? k & 1 : k & 3];
                l->offsets[pair] =
                    swap ? by[0] * x * stride + by[1] * y : by[1] * y * stride + by[0] * x;
                for (uint32_t lane = 0; lane < BN_WINDOW_LANES; ++lane)
                    l->weights[pair * BN_WINDOW_LANES + lane] = s->groups[g].weight;
            }
        }
    }
}

bn_result bn_relax_learned(const bn_relax_options *options, uint32_t threads, uint32_t width,
                           uint32_t height, uint32_t *ranks) {
    learned l = {.options = options,
                 .simd = bn_simd_get(),
                 .width = width,
                 .height = height,
                 .rows = height + 2 * (size_t)REACH,
                 .stride = width + 2 * (size_t)REACH + BN_WINDOW_LANES,
                 .ranks = ranks};
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    l.image[0] = bn_allocate(l.rows, l.stride * sizeof *l.image[0]);
    l.image[1] = bn_allocate(l.rows, l.stride * sizeof *l.image[1]);
    l.offsets = bn_allocate(BN_RELAX_LEARNED_PAIRS, sizeof *l.offsets);
    l.weights = bn_allocate(BN_RELAX_LEARNED_PAIRS, BN_WINDOW_LANES * sizeof *l.weights);
    l.histograms = bn_allocate(threads, VALUES * sizeof *l.histograms);
    if (l.image[0] && l.image[1] && l.offsets && l.weights && l.histograms) {
        fill_pairs(&l);
        bn_team_run(threads, work, &l);
        result = l.cancelled[0] || l.cancelled[1] ? BN_ERROR_CANCELLED : BN_SUCCESS;
    }
    bn_free(l.image[0]);
    bn_free(l.image[1]);
    bn_free(l.offsets);
    bn_free(l.weights);
    bn_free(l.histograms);
    return result;
}
