/* SPDX-License-Identifier: Apache-2.0
 * Relaxes white noise in parallel, by learned steps
 *
 *     v <- keep v + sum over offsets o of w_o clip(v_p - v_(p+o), -1, 1),
 *
 * which the evolution strategy in trainer/ found. Only the values after the last step are ranked.
 * Values, weights and their rounded products are 16-bit integers, and each step has its own scale, at
 * which no sum can overflow, so the result is bit-identical for any thread count and instruction set.
 * A step reads one image and writes another, so threads need one barrier per step. Costs
 * BN_RELAX_LEARNED_PAIRS pairs per texel. */
#include "base/assert.h"
#include "base/check.h"
#include "base/float_environment.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/options.h"
#include "base/threads.h"
#include "masks/eliminate.h"
#include "masks/relax_schedule.h"
#include "simd/simd.h"
#include <string.h>

enum { REACH = BN_RELAX_LEARNED_REACH, VALUES = 1 << 16, COLUMNS = 256 };
static const double SPARSE = 3.5;       /* texels farther apart do not interact */
static const double STEPS_SHARE = 0.25; /* share of the time; ordering the ends takes the rest */

typedef struct relaxation {
    uint64_t seed;
    bn_progress progress;
    void *progress_user;
    const bn_simd *simd;
    uint32_t width, height;
    size_t rows, stride;  /* of an image; rows end with spare lanes for relax_row() */
    int16_t *image[2];    /* with a toroidal margin of REACH; the steps alternate between them */
    ptrdiff_t *offsets;   /* one per pair, for all steps */
    int16_t *weights;     /* each repeated BN_WINDOW_LANES times */
    uint32_t *histograms; /* [threads][VALUES] */
    uint32_t sums[BN_TEAM_MOST];
    uint32_t *ranks;
    int cancelled[2]; /* in even and odd steps: the first thread may be one step ahead */
} relaxation;

/* A thread's rows, first_row(index) to first_row(index + 1) - 1. No thread has none: there are at most as many
 * threads as rows. */
static uint32_t first_row(const relaxation *r, uint32_t index, uint32_t threads) {
    return (uint32_t)((uint64_t)r->height * index / threads);
}

static int16_t *row_of(const relaxation *r, int image, uint32_t y) {
    return r->image[image] + (y + (size_t)REACH) * r->stride + REACH;
}

/* Completes a row of new values by repeating it in the margins on all four sides. A mask narrower than the
 * margin is repeated several times. */
static void wrap_edges(relaxation *r, int image, uint32_t y) {
    int16_t *row = row_of(r, image, y) - REACH;
    for (size_t at = REACH; at-- > 0;) row[at] = row[at + r->width];
    for (size_t at = REACH + (size_t)r->width; at < r->stride; ++at) row[at] = row[at - r->width];
    for (size_t other = (y + (size_t)REACH) % r->height; other < r->rows; other += r->height) {
        if (other == y + (size_t)REACH) continue;
        memcpy(r->image[image] + other * r->stride, row, r->stride * sizeof *row);
    }
}

/* White noise as signed 16-bit numbers, a hash of the seed and the texel. */
static void first_values(relaxation *r, uint32_t y) {
    int16_t *row = row_of(r, 0, y);
    for (uint32_t x = 0; x < r->width; ++x) {
        const uint64_t i = (uint64_t)y * r->width + x;
        row[x] = (int16_t)((int32_t)(bn_mix64(r->seed ^ bn_mix64(i + 1)) >> 48) - (1 << 15));
    }
}

/* Moves a row of one image by a step's gradient, into the other image. The first `pairs` offsets from `pair` on
 * are those of the step. */
static void move(relaxation *r, const bn_relax_learned_step *s, uint32_t pair, uint32_t pairs,
                 int from, uint32_t y) {
    int16_t moved[COLUMNS + BN_WINDOW_LANES];
    for (uint32_t x0 = 0; x0 < r->width; x0 += COLUMNS) {
        const uint32_t columns = r->width - x0 < COLUMNS ? r->width - x0 : COLUMNS;
        const int16_t *here = row_of(r, from, y) + x0;
        int16_t *there = row_of(r, !from, y) + x0;
        r->simd->relax_row(here, r->offsets + pair, r->weights + (size_t)pair * BN_WINDOW_LANES,
                           pairs, columns, s->limit, s->shift, moved);
        for (uint32_t x = 0; x < columns; ++x) {
            const int32_t value = moved[x] + ((here[x] * s->keep + (1 << 14)) >> 15);
            BN_ASSERT(value >= INT16_MIN && value <= INT16_MAX); /* by the step's scale */
            there[x] = (int16_t)value;
        }
    }
}

/* Counts the values in each thread's rows, sums the counts over smaller values and earlier rows, and
 * assigns ranks in that order. The result is a stable sort for any number of threads. */
static void rank(relaxation *r, int image, bn_team *team, uint32_t index, uint32_t threads) {
    const uint32_t first = first_row(r, index, threads), last = first_row(r, index + 1, threads);
    uint32_t *mine = r->histograms + (size_t)index * VALUES;
    memset(mine, 0, VALUES * sizeof *mine);
    for (uint32_t y = first; y < last; ++y) {
        const int16_t *row = row_of(r, image, y);
        for (uint32_t x = 0; x < r->width; ++x) ++mine[row[x] + (1 << 15)];
    }
    bn_team_wait(team);
    const uint32_t low = VALUES * index / threads, high = VALUES * (index + 1) / threads;
    uint32_t sum = 0, below = 0;
    for (uint32_t t = 0; t < threads; ++t) {
        for (uint32_t value = low; value < high; ++value)
            sum += r->histograms[(size_t)t * VALUES + value];
    }
    r->sums[index] = sum;
    bn_team_wait(team);
    for (uint32_t t = 0; t < index; ++t) below += r->sums[t];
    for (uint32_t value = low; value < high; ++value) {
        for (uint32_t t = 0; t < threads; ++t) {
            uint32_t *count = &r->histograms[(size_t)t * VALUES + value];
            const uint32_t here = *count;
            *count = below;
            below += here;
        }
    }
    bn_team_wait(team);
    for (uint32_t y = first; y < last; ++y) {
        const int16_t *row = row_of(r, image, y);
        uint32_t *ranks = r->ranks + (size_t)y * r->width;
        for (uint32_t x = 0; x < r->width; ++x) {
            ranks[x] = mine[row[x] + (1 << 15)]++;
            BN_ASSERT(ranks[x] < (uint64_t)r->width * r->height);
        }
    }
}

/* The number of offsets that the symmetries of the square make of one. */
static uint32_t images_of(const bn_relax_learned_group *g) {
    return g->y == 0 || g->y == g->x ? 4 : 8;
}

/* Runs all steps in one thread's rows. Everyone has written an image before anyone reads it: the barrier at the
 * end of each step also protects the image that the next step overwrites. */
static void work(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    relaxation *r = user;
    const uint32_t first = first_row(r, index, threads), last = first_row(r, index + 1, threads);
    for (uint32_t y = first; y < last; ++y) {
        first_values(r, y);
        wrap_edges(r, 0, y);
    }
    bn_team_wait(team);
    uint32_t pair = 0;
    for (int i = 0; i < BN_RELAX_LEARNED_STEPS; ++i) {
        const bn_relax_learned_step *s = &bn_relax_learned_steps[i];
        uint32_t pairs = 0;
        for (uint32_t g = 0; g < s->group_count; ++g) pairs += images_of(&s->groups[g]);
        if (index == 0 && r->progress != NULL) {
            const double fraction = STEPS_SHARE * i / BN_RELAX_LEARNED_STEPS;
            r->cancelled[i & 1] = r->progress(r->progress_user, fraction) != 0;
        }
        for (uint32_t y = first; y < last; ++y) {
            move(r, s, pair, pairs, i & 1, y);
            wrap_edges(r, !(i & 1), y);
        }
        pair += pairs;
        bn_team_wait(team);
        if (r->cancelled[i & 1]) return;
    }
    rank(r, BN_RELAX_LEARNED_STEPS & 1, team, index, threads);
}

/* Lists the offsets of all steps, as distances in memory, with their weights. */
static void fill_pairs(relaxation *r) {
    static const int8_t sign[4][2] = {{1, 1}, {-1, -1}, {1, -1}, {-1, 1}};
    uint32_t pair = 0;
    for (int i = 0; i < BN_RELAX_LEARNED_STEPS; ++i) {
        const bn_relax_learned_step *s = &bn_relax_learned_steps[i];
        for (uint32_t g = 0; g < s->group_count; ++g) {
            BN_ASSERT(s->groups[g].y <= s->groups[g].x && s->groups[g].x <= REACH);
            const ptrdiff_t x = s->groups[g].x, y = s->groups[g].y, stride = (ptrdiff_t)r->stride;
            const uint32_t count = images_of(&s->groups[g]);
            for (uint32_t k = 0; k < count; ++k, ++pair) {
                /* Swap x and y for the second half of the offsets: four of eight, or two of four. */
                const int swap = y == 0 ? k >= 2 : k >= 4;
                const int8_t *by = sign[y == 0 ? k & 1 : k & 3];
                r->offsets[pair] =
                    swap ? by[0] * x * stride + by[1] * y : by[1] * y * stride + by[0] * x;
                for (uint32_t lane = 0; lane < BN_WINDOW_LANES; ++lane)
                    r->weights[pair * BN_WINDOW_LANES + lane] = s->groups[g].weight;
            }
        }
    }
    BN_ASSERT(pair == BN_RELAX_LEARNED_PAIRS);
}

/* The caller has set the fields of `r` up to `ranks`. */
static bn_result make_relaxed(relaxation r, uint32_t threads) {
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    r.rows = r.height + 2 * (size_t)REACH;
    r.stride = r.width + 2 * (size_t)REACH + BN_WINDOW_LANES;
    r.image[0] = bn_allocate(r.rows, r.stride * sizeof *r.image[0]);
    r.image[1] = bn_allocate(r.rows, r.stride * sizeof *r.image[1]);
    r.offsets = bn_allocate(BN_RELAX_LEARNED_PAIRS, sizeof *r.offsets);
    r.weights = bn_allocate(BN_RELAX_LEARNED_PAIRS, BN_WINDOW_LANES * sizeof *r.weights);
    r.histograms = bn_allocate(threads, VALUES * sizeof *r.histograms);
    if (r.image[0] && r.image[1] && r.offsets && r.weights && r.histograms) {
        fill_pairs(&r);
        bn_team_run(threads, work, &r);
        result = r.cancelled[0] || r.cancelled[1] ? BN_ERROR_CANCELLED : BN_SUCCESS;
    }
    bn_free(r.image[0]);
    bn_free(r.image[1]);
    bn_free(r.offsets);
    bn_free(r.weights);
    bn_free(r.histograms);
    return result;
}

static BN_NOINLINE bn_result relax(const bn_relax_options *given, const bn_mask *mask,
                                   bn_progress progress, void *progress_user) {
    bn_relax_options o = bn_relax_options_default();
    size_t count;
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result == BN_SUCCESS) result = bn_check_new_mask(mask, &count);
    if (result != BN_SUCCESS) return result;
    if (mask->depth != 1 || mask->channels != 1) return BN_ERROR_INVALID_ARGUMENT;

    uint32_t threads = bn_team_threads(o.threads);
    /* Because of the barriers, more threads pay off only if each has several thousand texels. */
    const uint64_t worth = count / 8192 + 1;
    if (threads > worth) threads = (uint32_t)worth;
    if (threads > mask->height) threads = mask->height;
    uint32_t *made = bn_allocate(count, sizeof *made);
    if (made == NULL) return BN_ERROR_OUT_OF_MEMORY;
    const relaxation r = {.seed = o.seed,
                          .progress = progress,
                          .progress_user = progress_user,
                          .simd = bn_simd_get(),
                          .width = mask->width,
                          .height = mask->height,
                          .ranks = made};
    result = make_relaxed(r, threads);
    if (result == BN_SUCCESS) {
        const uint32_t extent[3] = {mask->width, mask->height, 1};
        result = bn_eliminate_ends(extent, SPARSE, o.seed, threads, made, count, STEPS_SHARE,
                                   progress, progress_user);
        if (result == BN_SUCCESS) bn_mask_write(mask, made, count);
    }
    bn_free(made);
    return result;
}

bn_result bn_relax(const bn_relax_options *options, const bn_mask *mask, bn_progress progress,
                   void *progress_user) {
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(relax(options, mask, progress, progress_user));
}
