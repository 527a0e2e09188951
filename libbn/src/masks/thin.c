/* SPDX-License-Identifier: Apache-2.0
 * Thinning of a sparse pattern: the first and the last ranks of void-and-cluster.
 *
 * Where points are further apart than the Gaussian reaches, its sums carry no information, and
 * rounding would decide which point is the "tightest cluster". So here the Gaussian widens as
 * points are removed: its sigma is 0.45 of the spacing of the remaining points, the ratio that
 * void-and-cluster has at the usual density of the initial pattern. That keeps the pattern blue at
 * every grey level down to single points. Points are sorted into cells as large as the kernel's
 * reach. Energies are integers that only decrease, so the next point comes from a bucket queue
 * whose entries are corrected when they reach the front. Time and memory are linear in the points.
 * */
#include "masks/thin.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/portable_math.h"
#include "base/threads.h"
#include <string.h>

static const double BN_THIN_SIGMA = 0.45; /* in spacings */
static const double BN_THIN_REACH = 3;    /* in sigmas */
static const double BN_THIN_STAGE =
    0.5; /* share of the points that remain when the Gaussian widens */

enum { BN_THIN_TABLE = 1024, BN_THIN_BUCKETS = 1024 };
static const uint32_t BN_THIN_NONE = UINT32_MAX;

typedef struct thin {
    const uint32_t *extent;
    /* The remaining points, in the order of their cells. A removed point is BN_THIN_NONE. The
     * energy of a point is the sum of the weights of its pairs. */
    uint32_t *point, *x, *y, *z, *energy;
    uint32_t *cell_of, *home, *cell_start, *next, *scratch;
    size_t count;
    uint32_t cells[3];
    uint64_t scale; /* from squared distance to table entry, times 2^32 */
    uint64_t bucket_scale;
    uint32_t bucket[BN_THIN_BUCKETS];
    uint32_t table[BN_THIN_TABLE + 1]; /* the last entry is 0 */
} thin;

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

double bn_thin_spacing(double sigma) {
    return sigma / BN_THIN_SIGMA;
}

static uint32_t cell_along(const thin *t, int axis, uint32_t at) {
    return (uint32_t)((uint64_t)at * t->cells[axis] / t->extent[axis]);
}

static uint64_t square_along(uint32_t a, uint32_t b, uint32_t extent) {
    uint32_t d = a > b ? a - b : b - a;
    d = d < extent - d ? d : extent - d;
    return (uint64_t)d * d;
}

/* Visits the points first .. last - 1 near `slot`. With `collect` it adds the weight of each pair
 * to both points; otherwise it subtracts the weight from the others. Removed points are included,
 * as nothing reads their energies. */
static void visit_range(thin *t, uint32_t slot, uint32_t first, uint32_t last, int collect) {
    /* Local copies: the compiler cannot know that stores to the energies leave them alone. */
    const uint32_t width = t->extent[0], height = t->extent[1], depth = t->extent[2];
    const uint32_t *xs = t->x, *ys = t->y, *zs = t->z, x = xs[slot], y = ys[slot], z = zs[slot];
    const uint64_t scale = t->scale;
    uint32_t *energy = t->energy, sum = 0;
    for (uint32_t other = first; other < last; ++other) {
        uint64_t square = square_along(x, xs[other], width) + square_along(y, ys[other], height);
        if (depth > 1) square += square_along(z, zs[other], depth);
        const uint64_t entry = square * scale >> 32;
        const uint32_t weight = t->table[entry < BN_THIN_TABLE ? entry : BN_THIN_TABLE];
        if (collect) {
            sum += weight;
            energy[other] += weight;
        } else {
            energy[other] -= weight;
        }
    }
    if (collect) energy[slot] += sum;
}

/* The ranges of points in and around a cell, at most 18. Cells along x are contiguous, except
 * across the edge of the torus. */
static uint32_t ranges_around(const thin *t, uint32_t cell, uint32_t ranges[18][2]) {
    const uint32_t home[3] = {cell % t->cells[0], cell / t->cells[0] % t->cells[1],
                              cell / t->cells[0] / t->cells[1]};
    uint32_t from[3], number[3], count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t cells = t->cells[axis];
        number[axis] = cells < 3 ? cells : 3;
        from[axis] = cells < 3 ? 0 : home[axis] == 0 ? cells - 1 : home[axis] - 1;
    }
    const uint32_t end = from[0] + number[0];
    const uint32_t wrapped = end > t->cells[0] ? end - t->cells[0] : 0;
    for (uint32_t z = 0; z < number[2]; ++z) {
        uint32_t cz = from[2] + z < t->cells[2] ? from[2] + z : from[2] + z - t->cells[2];
        for (uint32_t y = 0; y < number[1]; ++y) {
            uint32_t cy = from[1] + y < t->cells[1] ? from[1] + y : from[1] + y - t->cells[1];
            const uint32_t *row = t->cell_start + (cz * t->cells[1] + cy) * t->cells[0];
            ranges[count][0] = row[from[0]];
            ranges[count++][1] = row[end - wrapped];
            if (wrapped == 0) continue;
            ranges[count][0] = row[0];
            ranges[count++][1] = row[wrapped];
        }
    }
    return count;
}

/* Computes the energy of every point, visiting each pair once. */
static void collect(thin *t, uint32_t cells) {
    uint32_t ranges[18][2];
    for (uint32_t cell = 0; cell < cells; ++cell) {
        if (t->cell_start[cell] == t->cell_start[cell + 1]) continue;
        const uint32_t count = ranges_around(t, cell, ranges);
        for (uint32_t slot = t->cell_start[cell]; slot < t->cell_start[cell + 1]; ++slot) {
            t->home[slot] = cell;
            for (uint32_t i = 0; i < count; ++i) {
                if (ranges[i][1] <= slot) continue;
                visit_range(t, slot, ranges[i][0] > slot ? ranges[i][0] : slot + 1, ranges[i][1],
                            1);
            }
        }
    }
}

/* Puts values into the order of the cells: values[i] moves to cell_of[i]. */
static void reorder(thin *t, uint32_t **values) {
    uint32_t *from = *values;
    for (size_t i = 0; i < t->count; ++i) t->scratch[t->cell_of[i]] = from[i];
    *values = t->scratch;
    t->scratch = from;
}

static void sort_into_cells(thin *t, double reach) {
    size_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        double fit = t->extent[axis] / reach;
        t->cells[axis] = fit < 1 ? 1 : (uint32_t)fit;
        cells *= t->cells[axis];
    }
    memset(t->cell_start, 0, (cells + 2) * sizeof *t->cell_start);
    for (size_t i = 0; i < t->count; ++i) {
        t->cell_of[i] =
            (cell_along(t, 2, t->z[i]) * t->cells[1] + cell_along(t, 1, t->y[i])) * t->cells[0] +
            cell_along(t, 0, t->x[i]);
        ++t->cell_start[t->cell_of[i] + 2];
    }
    for (size_t c = 2; c < cells + 2; ++c) t->cell_start[c] += t->cell_start[c - 1];
    for (size_t i = 0; i < t->count; ++i) {
        t->cell_of[i] = t->cell_start[t->cell_of[i] + 1]++;
    }
    reorder(t, &t->point);
    reorder(t, &t->x);
    reorder(t, &t->y);
    reorder(t, &t->z);
}

static void push(thin *t, uint32_t slot) {
    uint32_t *head = &t->bucket[t->energy[slot] * t->bucket_scale >> 32];
    t->next[slot] = *head;
    *head = slot;
}

/* Chooses the Gaussian for t->count points and computes their cells, energies and buckets. */
static void begin_stage(thin *t, uint64_t seed) {
    const double reach = BN_THIN_REACH * BN_THIN_SIGMA * bn_spacing(t->extent, t->count);
    uint32_t most = 0;
    t->scale = (uint64_t)((double)BN_THIN_TABLE * 0x1p32 / (reach * reach));
    sort_into_cells(t, reach);
    memset(t->energy, 0, t->count * sizeof *t->energy);
    collect(t, t->cells[0] * t->cells[1] * t->cells[2]);
    for (size_t i = 0; i < t->count; ++i) most = t->energy[i] > most ? t->energy[i] : most;
    t->bucket_scale = ((uint64_t)BN_THIN_BUCKETS << 32) / ((uint64_t)most + 1);
    for (int i = 0; i < BN_THIN_BUCKETS; ++i) t->bucket[i] = BN_THIN_NONE;
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
static void remove_points(thin *t, size_t left, uint32_t *removed) {
    int top = BN_THIN_BUCKETS - 1;
    for (size_t remaining = t->count; remaining > left;) {
        const uint32_t slot = t->bucket[top];
        if (slot == BN_THIN_NONE) {
            --top;
            continue;
        }
        t->bucket[top] = t->next[slot];
        if ((int)(t->energy[slot] * t->bucket_scale >> 32) < top) {
            push(t, slot);
            continue;
        }
        *--removed = t->point[slot];
        t->point[slot] = BN_THIN_NONE;
        --remaining;
        uint32_t ranges[18][2];
        const uint32_t count = ranges_around(t, t->home[slot], ranges);
        for (uint32_t i = 0; i < count; ++i) visit_range(t, slot, ranges[i][0], ranges[i][1], 0);
    }
}

int bn_thin(const uint32_t extent[3], uint64_t seed, uint32_t *points, size_t count) {
    if (count < 2) return 1;
    thin *t = bn_allocate_zero(1, sizeof *t);
    if (t == NULL) return 0;
    uint32_t **const arrays[] = {&t->point, &t->x,    &t->y,      &t->z,      &t->cell_of,
                                 &t->home,  &t->next, &t->energy, &t->scratch};
    enum { array_count = sizeof arrays / sizeof *arrays };
    int good = 1;
    for (int i = 0; i < array_count; ++i) {
        *arrays[i] = bn_allocate(count, sizeof **arrays[i]);
        good = good && *arrays[i] != NULL;
    }
    /* A cell is at least as large as the reach, 1.35 spacings: there are fewer cells than points.
     * */
    t->cell_start = bn_allocate(count + 8, sizeof *t->cell_start);
    if (!good || t->cell_start == NULL) {
        good = 0;
        goto done;
    }
    t->extent = extent;
    t->count = count;
    for (int i = 0; i < BN_THIN_TABLE; ++i) {
        double x = BN_THIN_REACH * BN_THIN_REACH / 2 * (i + 0.5) / BN_THIN_TABLE;
        t->table[i] = (uint32_t)(0x1p24 * bn_portable_exp(-x));
    }
    for (size_t i = 0; i < count; ++i) {
        size_t line = points[i] / extent[0];
        t->point[i] = points[i];
        t->x[i] = points[i] % extent[0];
        t->y[i] = (uint32_t)(line % extent[1]);
        t->z[i] = (uint32_t)(line / extent[1]);
    }
    while (t->count > 1) {
        size_t left = (size_t)(BN_THIN_STAGE * (double)t->count), kept = 0;
        if (left < 1) left = 1;
        begin_stage(t, seed);
        remove_points(t, left, points + t->count);
        for (size_t i = 0; i < t->count; ++i) {
            if (t->point[i] == BN_THIN_NONE) continue;
            t->point[kept] = t->point[i];
            t->x[kept] = t->x[i];
            t->y[kept] = t->y[i];
            t->z[kept++] = t->z[i];
        }
        t->count = left;
    }
    points[0] = t->point[0];
done:
    for (int i = 0; i < array_count; ++i) bn_free(*arrays[i]);
    bn_free(t->cell_start);
    bn_free(t);
    return good;
}

size_t bn_thin_count(const uint32_t extent[3], size_t count, double spacing) {
    size_t low = 1, high = count / 2 + count % 2;
    while (low < high) {
        const size_t middle = low + (high - low + 1) / 2;
        if (bn_spacing(extent, middle) >= spacing) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    return low;
}

/* The two ends of a mask. */
typedef struct ends {
    const uint32_t *extent;
    uint64_t seed;
    size_t points;
    uint32_t *end[2];
    int good[2];
} ends;

static void thin_ends(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    ends *e = user;
    (void)index, (void)threads;
    for (uint32_t i; (i = bn_team_next(team)) < 2;)
        e->good[i] = bn_thin(e->extent, i == 0 ? e->seed : ~e->seed, e->end[i], e->points);
}

int bn_thin_ends(const uint32_t extent[3], double spacing, uint64_t seed, uint32_t threads,
                 uint32_t *ranks, size_t count) {
    const size_t points = bn_thin_count(extent, count, spacing);
    if (points > count / 2) return 1;
    uint32_t *first = bn_allocate(points, 2 * sizeof *first);
    if (first == NULL) return 0;
    uint32_t *last = first + points;
    for (size_t i = 0; i < count; ++i) {
        if (ranks[i] < points) first[ranks[i]] = (uint32_t)i;
        if (ranks[i] >= count - points) last[count - 1 - ranks[i]] = (uint32_t)i;
    }
    ends e = {extent, seed, points, {first, last}, {0, 0}};
    bn_team_run(threads < 2 ? 1 : 2, thin_ends, &e);
    const int good = e.good[0] && e.good[1];
    for (size_t i = 0; i < points && good; ++i) {
        ranks[first[i]] = (uint32_t)i;
        ranks[last[i]] = (uint32_t)(count - 1 - i);
    }
    bn_free(first);
    return good;
}
