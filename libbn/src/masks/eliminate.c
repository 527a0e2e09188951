/* SPDX-License-Identifier: Apache-2.0
 * Weighted sample elimination (Yuksel, 2015) with Gaussian weights, for the sparse patterns at
 * void-and-cluster's first and last ranks.
 *
 * Where points are farther apart than the Gaussian reaches, its sums carry no information, and
 * rounding would decide which point is the "tightest cluster". So the Gaussian widens as points are
 * removed: its sigma is 0.45 times the remaining points' spacing, the same ratio as in
 * void-and-cluster at the initial pattern's usual density. This keeps the pattern blue at every grey
 * level down to single points. Points are sorted into cells as large as the kernel's reach. Energies
 * are integers that only decrease, so the next point comes from a bucket queue whose entries are
 * corrected when they reach the front. Time is linear in the number of points, and so is memory, 36 bytes per
 * point, all of which bn_eliminate() allocates and frees. */
#include "masks/eliminate.h"
#include "base/assert.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/portable_math.h"
#include <string.h>

static const double BN_ELIMINATE_SIGMA = 0.45; /* in spacings */
static const double BN_ELIMINATE_REACH = 3; /* in sigmas, where the Gaussian is 1% of its maximum */
/* The fraction of points remaining when the Gaussian widens. */
static const double BN_ELIMINATE_STAGE = 0.5;

enum {
    BN_ELIMINATE_TABLE = 1024,      /* weights by squared distance, up to the reach */
    BN_ELIMINATE_BUCKETS = 1024,    /* of energies, up to the largest at the start of a stage */
    BN_ELIMINATE_INTERVAL = 1 << 12 /* points between two reports of progress */
};
static const uint32_t BN_ELIMINATE_NONE = UINT32_MAX;

typedef struct elimination {
    const uint32_t *extent;
    /* The remaining points, sorted by cell; a slot is a position in this order. A removed point becomes
     * BN_ELIMINATE_NONE. A point's energy is the sum of its pairs' weights. It fits 32 bits if at most 256 other
     * points lie within the reach, or if the spacing is at most 14 texels, where even a solid cluster adds up to
     * less. Only a network that asks for a wider spacing and clusters its points can exceed this; energies then
     * wrap, and the order is less even. */
    uint32_t *point, *x, *y, *z, *energy;
    uint32_t *cell_of;    /* scratch for sorting: a point's cell, then its slot */
    uint32_t *cell_start; /* the first slot of each cell, and the end */
    uint32_t *scratch;
    size_t count; /* at the start of the stage, with those removed since */
    uint32_t cells[3];
    uint64_t scale;                         /* from squared distance to table entry, times 2^32 */
    uint64_t bucket_scale;                  /* from energy to bucket, times 2^32 */
    uint32_t bucket[BN_ELIMINATE_BUCKETS];  /* lists: the first slot of each bucket, */
    uint32_t *next;                         /* and the one after each slot */
    uint32_t table[BN_ELIMINATE_TABLE + 1]; /* the last entry is 0 */
    const bn_eliminate_watch *watch;
    size_t all, calls; /* the points of the first stage; calls of elimination_cancelled() */
    int cancelled;
} elimination;

/* Reports progress at intervals while `remaining` points are left to order; returns whether to stop. */
static int elimination_cancelled(elimination *t, size_t remaining) {
    const bn_eliminate_watch *w = t->watch;
    if (t->cancelled || t->calls++ % BN_ELIMINATE_INTERVAL != 0) return t->cancelled;
    if (w->progress != NULL) {
        const double done = 1 - (double)remaining / (double)t->all;
        t->cancelled = w->progress(w->user, w->from + (w->to - w->from) * done) != 0;
        if (t->cancelled && w->team != NULL) bn_team_stop(w->team);
    }
    if (w->team != NULL && bn_team_next(w->team) == UINT32_MAX) t->cancelled = 1;
    return t->cancelled;
}

double bn_spacing(const uint32_t extent[3], size_t points) {
    int used[3] = {1, 1, 1};
    for (;;) {
        double volume = 1, spacing;
        int axes = 0, narrow = -1;
        for (int axis = 0; axis < 3; ++axis) {
            if (!used[axis]) continue;
            volume *= extent[axis];
            ++axes;
            if (narrow < 0 || extent[axis] < extent[narrow]) narrow = axis;
        }
        spacing = volume / (double)points;
        if (axes == 3) spacing = bn_portable_exp(bn_portable_log(spacing) / 3);
        if (axes == 2) spacing = sqrt(spacing);
        if (axes == 1 || extent[narrow] >= spacing) return spacing;
        used[narrow] = 0;
    }
}

double bn_eliminate_spacing(double sigma) {
    return sigma / BN_ELIMINATE_SIGMA;
}

/* The cell of a coordinate along an axis, and the squared distance of two on the torus. */
static uint32_t cell_along(const elimination *t, int axis, uint32_t at) {
    return (uint32_t)((uint64_t)at * t->cells[axis] / t->extent[axis]);
}

static uint64_t square_along(uint32_t a, uint32_t b, uint32_t extent) {
    uint32_t d = a > b ? a - b : b - a;
    d = d < extent - d ? d : extent - d;
    return (uint64_t)d * d;
}

/* A range of slots. */
typedef struct range {
    uint32_t first, last;
} range;

/* Visits the points in ranges near `slot`. If `collect` is set, adds each pair's weight to both
 * points; otherwise subtracts it from the other point. Removed points are included, because nothing
 * reads their energies. */
static void visit(elimination *t, uint32_t slot, const range *ranges, uint32_t count, int collect) {
    /* Local copies, because stores to the energies might alias the originals. */
    const uint32_t width = t->extent[0], height = t->extent[1], depth = t->extent[2];
    const uint32_t *xs = t->x, *ys = t->y, *zs = t->z, x = xs[slot], y = ys[slot];
    const uint64_t scale = t->scale;
    uint32_t *energy = t->energy, sum = 0;
    for (const range *r = ranges; r < ranges + count; ++r) {
        for (uint32_t other = r->first; other < r->last; ++other) {
            uint64_t square =
                square_along(x, xs[other], width) + square_along(y, ys[other], height);
            if (depth > 1) square += square_along(zs[slot], zs[other], depth);
            const uint64_t entry = square * scale >> 32;
            const uint32_t weight =
                t->table[entry < BN_ELIMINATE_TABLE ? entry : BN_ELIMINATE_TABLE];
            energy[other] += collect ? weight : 0 - weight;
            sum += weight;
        }
    }
    if (collect) energy[slot] += sum;
}

/* The ranges of points in and around the cell `home`, at most 18. Cells along x are contiguous,
 * except across the edge of the torus. */
static uint32_t ranges_around(const elimination *t, const uint32_t home[3], range ranges[18]) {
    const uint32_t *cells = t->cells;
    uint32_t from[3], number[3], count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        number[axis] = cells[axis] < 3 ? cells[axis] : 3;
        from[axis] = cells[axis] < 3 ? 0 : home[axis] == 0 ? cells[axis] - 1 : home[axis] - 1;
    }
    const uint32_t end = from[0] + number[0];
    const uint32_t wrapped = end > cells[0] ? end - cells[0] : 0;
    for (uint32_t z = 0; z < number[2]; ++z) {
        uint32_t cz = from[2] + z < cells[2] ? from[2] + z : from[2] + z - cells[2];
        for (uint32_t y = 0; y < number[1]; ++y) {
            const uint32_t cy = from[1] + y < cells[1] ? from[1] + y : from[1] + y - cells[1];
            const uint32_t *row = t->cell_start + (cz * cells[1] + cy) * cells[0];
            ranges[count++] = (range){row[from[0]], row[end - wrapped]};
            if (wrapped > 0) ranges[count++] = (range){row[0], row[wrapped]};
        }
    }
    BN_ASSERT(count <= 18); /* two for each of nine rows */
    return count;
}

/* Adds the weights of the pairs that each point in a cell forms with later points. */
static void collect_cell(elimination *t, uint32_t cell, const uint32_t home[3]) {
    range ranges[18];
    const uint32_t first = t->cell_start[cell], last = t->cell_start[cell + 1];
    if (first == last) return;
    const uint32_t count = ranges_around(t, home, ranges);
    for (uint32_t slot = first; slot < last; ++slot) {
        range later[18];
        uint32_t number = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (ranges[i].last <= slot) continue;
            later[number] = ranges[i];
            if (later[number].first <= slot) later[number].first = slot + 1;
            ++number;
        }
        visit(t, slot, later, number, 1);
    }
}

/* Computes the energy of every point, visiting each pair once. */
static void collect(elimination *t) {
    uint32_t at[3], cell = 0;
    for (at[2] = 0; at[2] < t->cells[2]; ++at[2]) {
        for (at[1] = 0; at[1] < t->cells[1]; ++at[1]) {
            for (at[0] = 0; at[0] < t->cells[0] && !elimination_cancelled(t, t->count); ++at[0])
                collect_cell(t, cell++, at);
        }
    }
}

/* Sorts values by cell: values[i] moves to cell_of[i]. */
static void reorder(elimination *t, uint32_t **values) {
    uint32_t *from = *values;
    for (size_t i = 0; i < t->count; ++i) t->scratch[t->cell_of[i]] = from[i];
    *values = t->scratch;
    t->scratch = from;
}

/* Sorts the points by cell, by counting: cell c has the slots cell_start[c] to cell_start[c + 1] - 1. While they
 * are assigned, the starts are stored one entry later. */
static void sort_into_cells(elimination *t, double reach) {
    size_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        double fit = t->extent[axis] / reach;
        t->cells[axis] = fit < 1 ? 1 : (uint32_t)fit;
        cells *= t->cells[axis];
    }
    BN_ASSERT(cells <= t->count + 6); /* see bn_eliminate() */
    memset(t->cell_start, 0, (cells + 2) * sizeof *t->cell_start);
    for (size_t i = 0; i < t->count; ++i) {
        const uint32_t plane = t->extent[2] > 1 ? cell_along(t, 2, t->z[i]) * t->cells[1] : 0;
        t->cell_of[i] =
            (plane + cell_along(t, 1, t->y[i])) * t->cells[0] + cell_along(t, 0, t->x[i]);
        ++t->cell_start[t->cell_of[i] + 2];
    }
    for (size_t c = 2; c < cells + 2; ++c) t->cell_start[c] += t->cell_start[c - 1];
    for (size_t i = 0; i < t->count; ++i) {
        t->cell_of[i] = t->cell_start[t->cell_of[i] + 1]++;
    }
    BN_ASSERT(t->cell_start[0] == 0 && t->cell_start[cells] == t->count);
    reorder(t, &t->point);
    reorder(t, &t->x);
    reorder(t, &t->y);
    if (t->extent[2] > 1) reorder(t, &t->z);
}

static uint64_t bucket_of(const elimination *t, uint32_t slot) {
    return t->energy[slot] * t->bucket_scale >> 32;
}

/* Puts a point at the front of its energy's bucket. */
static void push(elimination *t, uint32_t slot) {
    BN_ASSERT(bucket_of(t, slot) < BN_ELIMINATE_BUCKETS);
    uint32_t *head = &t->bucket[bucket_of(t, slot)];
    t->next[slot] = *head;
    *head = slot;
}

/* Chooses the Gaussian for t->count points and computes their cells, energies and buckets. */
static void begin_stage(elimination *t, uint64_t seed) {
    const double reach = BN_ELIMINATE_REACH * BN_ELIMINATE_SIGMA * bn_spacing(t->extent, t->count);
    uint32_t most = 0;
    t->scale = (uint64_t)((double)BN_ELIMINATE_TABLE * 0x1p32 / (reach * reach));
    sort_into_cells(t, reach);
    memset(t->energy, 0, t->count * sizeof *t->energy);
    collect(t);
    for (size_t i = 0; i < t->count; ++i) most = t->energy[i] > most ? t->energy[i] : most;
    t->bucket_scale = ((uint64_t)BN_ELIMINATE_BUCKETS << 32) / ((uint64_t)most + 1);
    for (int i = 0; i < BN_ELIMINATE_BUCKETS; ++i) t->bucket[i] = BN_ELIMINATE_NONE;
    /* Fill the buckets in pseudo-random order, so that ties do not depend on position. */
    uint32_t size = 1;
    while (size < t->count) size *= 2;
    const uint32_t step = (uint32_t)(bn_mix64(seed ^ t->count) | 1u);
    for (uint32_t i = 0; i < size; ++i) {
        uint32_t slot = (i * step + step / 2) & (size - 1);
        if (slot < t->count) push(t, slot);
    }
}

/* Removes points until `left` remain. Writes them from `removed` downwards. */
static void remove_points(elimination *t, size_t left, uint32_t *removed) {
    int top = BN_ELIMINATE_BUCKETS - 1;
    for (size_t remaining = t->count; remaining > left && !elimination_cancelled(t, remaining);) {
        BN_ASSERT(top >= 0); /* each remaining point is in a bucket, at or below the top one */
        const uint32_t slot = t->bucket[top];
        if (slot == BN_ELIMINATE_NONE) {
            --top;
            continue;
        }
        t->bucket[top] = t->next[slot];
        if (bucket_of(t, slot) < (uint64_t)top) {
            push(t, slot); /* its energy has fallen since it was put here */
            continue;
        }
        *--removed = t->point[slot];
        t->point[slot] = BN_ELIMINATE_NONE;
        --remaining;
        const uint32_t home[3] = {cell_along(t, 0, t->x[slot]), cell_along(t, 1, t->y[slot]),
                                  t->cells[2] > 1 ? cell_along(t, 2, t->z[slot]) : 0};
        range ranges[18];
        const uint32_t count = ranges_around(t, home, ranges);
        visit(t, slot, ranges, count, 0);
    }
}

bn_result bn_eliminate(const uint32_t extent[3], uint64_t seed, uint32_t *points, size_t count,
                       const bn_eliminate_watch *watch) {
    if (count < 2) return BN_SUCCESS;
    elimination *t = bn_allocate_zero(1, sizeof *t);
    if (t == NULL) return BN_ERROR_OUT_OF_MEMORY;
    uint32_t **const arrays[] = {&t->point,   &t->x,    &t->y,      &t->z,
                                 &t->cell_of, &t->next, &t->energy, &t->scratch};
    enum { array_count = sizeof arrays / sizeof *arrays };
    int good = 1;
    for (int i = 0; i < array_count; ++i) {
        *arrays[i] = bn_allocate(count, sizeof **arrays[i]);
        good = good && *arrays[i] != NULL;
    }
    /* A cell is at least as large as the reach, 1.35 spacings, so there are fewer cells than points. */
    t->cell_start = bn_allocate(count + 8, sizeof *t->cell_start);
    if (!good || t->cell_start == NULL) {
        good = 0;
        goto done;
    }
    t->extent = extent;
    t->count = t->all = count;
    t->watch = watch;
    for (int i = 0; i < BN_ELIMINATE_TABLE; ++i) {
        double x = BN_ELIMINATE_REACH * BN_ELIMINATE_REACH / 2 * (i + 0.5) / BN_ELIMINATE_TABLE;
        t->table[i] = (uint32_t)(0x1p24 * bn_portable_exp(-x));
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t line = points[i] / extent[0];
        t->point[i] = points[i];
        t->x[i] = points[i] % extent[0];
        t->y[i] = line % extent[1];
        t->z[i] = line / extent[1];
    }
    while (t->count > 1 && !t->cancelled) {
        size_t left = (size_t)(BN_ELIMINATE_STAGE * (double)t->count), kept = 0;
        if (left < 1) left = 1;
        BN_ASSERT(left < t->count);
        begin_stage(t, seed);
        remove_points(t, left, points + t->count);
        for (size_t i = 0; i < t->count; ++i) {
            /* Branchless, because a branch would be unpredictable. */
            t->point[kept] = t->point[i];
            t->x[kept] = t->x[i];
            t->y[kept] = t->y[i];
            t->z[kept] = t->z[i];
            kept += t->point[i] != BN_ELIMINATE_NONE;
        }
        BN_ASSERT(t->cancelled || kept == left);
        t->count = left;
    }
    if (!t->cancelled) points[0] = t->point[0];
done:
    for (int i = 0; i < array_count; ++i) bn_free(*arrays[i]);
    bn_free(t->cell_start);
    const bn_result result = !good          ? BN_ERROR_OUT_OF_MEMORY
                             : t->cancelled ? BN_ERROR_CANCELLED
                                            : BN_SUCCESS;
    bn_free(t);
    return result;
}
