/* SPDX-License-Identifier: Apache-2.0
 * Which of a mask's ranks are so sparse that bn_eliminate() orders them, and their order. */
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
    int good[2];
} ends;

static void eliminate_ends(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    ends *e = user;
    (void)index, (void)threads;
    for (uint32_t i; (i = bn_team_next(team)) < 2;)
        e->good[i] = bn_eliminate(e->extent, i == 0 ? e->seed : ~e->seed, e->end[i], e->points);
}

int bn_eliminate_ends(const uint32_t extent[3], double spacing, uint64_t seed, uint32_t threads,
                      uint32_t *ranks, size_t count) {
    const size_t points = bn_eliminate_count(extent, count, spacing);
    if (points > count / 2) return 1;
    uint32_t *first = bn_allocate(points, 2 * sizeof *first);
    if (first == NULL) return 0;
    uint32_t *last = first + points;
    for (size_t i = 0; i < count; ++i) {
        if (ranks[i] < points) first[ranks[i]] = (uint32_t)i;
        if (ranks[i] >= count - points) last[count - 1 - ranks[i]] = (uint32_t)i;
    }
    ends e = {extent, seed, points, {first, last}, {0, 0}};
    bn_team_run(threads < 2 ? 1 : 2, eliminate_ends, &e);
    const int good = e.good[0] && e.good[1];
    for (size_t i = 0; i < points && good; ++i) {
        ranks[first[i]] = (uint32_t)i;
        ranks[last[i]] = (uint32_t)(count - 1 - i);
    }
    bn_free(first);
    return good;
}
