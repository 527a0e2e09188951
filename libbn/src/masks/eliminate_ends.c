/* SPDX-License-Identifier: Apache-2.0
 * Finds a mask's ranks that are sparse enough for bn_eliminate(), and orders them. The spacing falls as points
 * are added, so bisection finds the largest number. Both ends have that many ranks: the last ones, from the
 * highest down, are ordered as the first ones of the inverted mask. */
#include "base/assert.h"
#include "base/memory.h"
#include "base/threads.h"
#include "masks/eliminate.h"

size_t bn_eliminate_count(const uint32_t extent[3], size_t count, double spacing) {
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
    double from;
    bn_progress progress;
    void *user;
    bn_result result[2];
} ends;

/* Two threads take one end each; a single thread takes both in turn. The first thread reports progress. */
static void eliminate_ends(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    ends *e = user;
    const double share = (1 - e->from) * threads / 2;
    for (uint32_t i = index; i < 2; i += threads) {
        const double from = threads == 1 ? e->from + i * share : e->from;
        const bn_eliminate_watch watch = {index == 0 ? e->progress : NULL, e->user, from,
                                          from + share, team};
        e->result[i] =
            bn_eliminate(e->extent, i == 0 ? e->seed : ~e->seed, e->end[i], e->points, &watch);
    }
}

bn_result bn_eliminate_ends(const uint32_t extent[3], double spacing, uint64_t seed,
                            uint32_t threads, uint32_t *ranks, size_t count, double from,
                            bn_progress progress, void *user) {
    const size_t points = bn_eliminate_count(extent, count, spacing);
    if (points > count / 2) return BN_SUCCESS; /* a single texel */
    uint32_t *first = bn_allocate(points, 2 * sizeof *first);
    if (first == NULL) return BN_ERROR_OUT_OF_MEMORY;
    uint32_t *last = first + points;
    for (size_t i = 0; i < count; ++i) {
        BN_ASSERT(ranks[i] < count);
        if (ranks[i] < points) first[ranks[i]] = (uint32_t)i;
        if (ranks[i] >= count - points) last[count - 1 - ranks[i]] = (uint32_t)i;
    }
    ends e = {extent, seed, points, {first, last}, from, progress, user, {BN_SUCCESS, BN_SUCCESS}};
    bn_team_run(threads < 2 ? 1 : 2, eliminate_ends, &e);
    const bn_result result = e.result[0] != BN_SUCCESS ? e.result[0] : e.result[1];
    for (size_t i = 0; i < points && result == BN_SUCCESS; ++i) {
        ranks[first[i]] = (uint32_t)i;
        ranks[last[i]] = (uint32_t)(count - 1 - i);
    }
    bn_free(first);
    return result;
}
