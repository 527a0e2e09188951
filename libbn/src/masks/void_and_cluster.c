/* SPDX-License-Identifier: Apache-2.0
 * Void-and-cluster (Ulichney, "The void-and-cluster method for dither array generation", 1993).
 *
 * It differs from the paper in three ways. The initial pattern is made by filling the largest voids, so
 * it is closer to the final pattern than white noise. Phases two and three are merged, because with a
 * linear filter the tightest cluster of zeros is the largest void of ones. At both ends of the grey
 * scale, where the minority texels are far apart, bn_eliminate() orders them. Time and memory are almost
 * linear in the number of texels. */
#include "base/assert.h"
#include "base/check.h"
#include "base/float_environment.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/options.h"
#include "masks/eliminate.h"
#include "masks/energy_field.h"
#include "simd/simd.h"
#include <float.h>

enum { BN_PROGRESS_INTERVAL = 4096 }; /* changes to the field: some milliseconds */

typedef struct maker {
    const bn_void_and_cluster_options *options;
    bn_progress progress;
    void *progress_user;
    const bn_simd *simd;
    bn_field field;
    size_t count, ones;    /* texels, and those that are set */
    size_t done, expected; /* changes to the field, for progress; `expected` is an estimate */
    uint32_t *ranks;       /* of texels in row-major order; not yet known for some */
    uint32_t *minority;    /* texels by rank, while they are removed or ordered */
    int cancelled;
} maker;

static int cancelled(maker *m) {
    if (m->done++ % BN_PROGRESS_INTERVAL == 0 && m->progress != NULL) {
        double fraction = (double)m->done / (double)m->expected;
        if (fraction > 1) fraction = 1;
        m->cancelled = m->progress(m->progress_user, fraction) != 0;
    }
    return m->cancelled;
}

/* A texel's energy; at least BN_FIELD_SET if it is set. */
static int32_t energy_at(const maker *m, bn_field_texel t) {
    return m->field.energy[(size_t)t.tile * BN_TILE_SIZE + t.lane];
}

/* Fills the largest voids until `ones` texels are set. Writes their ranks unless `ranks` is NULL. */
static void fill(maker *m, size_t ones, uint32_t *ranks) {
    while (m->ones < ones && !cancelled(m)) {
        bn_field_texel empty = m->simd->field_find(&m->field, BN_FIELD_LOWEST);
        BN_ASSERT(energy_at(m, empty) >= 0 && energy_at(m, empty) < BN_FIELD_SET);
        if (ranks != NULL) ranks[bn_field_index(&m->field, empty)] = (uint32_t)m->ones;
        m->simd->field_change(&m->field, empty, 1, BN_FIELD_LOWEST);
        ++m->ones;
    }
}

/* Moves the tightest cluster to the largest void until the two coincide. Each move lowers an
 * integer, the sum of the kernel over all pairs, so the loop ends; its bound is never reached. */
static void spread(maker *m) {
    const int both = BN_FIELD_LOWEST | BN_FIELD_HIGHEST;
    bn_field_refresh(&m->field);
    for (size_t move = 0; move < 64 * m->ones && !cancelled(m); ++move) {
        bn_field_texel cluster = m->simd->field_find(&m->field, BN_FIELD_HIGHEST);
        BN_ASSERT(energy_at(m, cluster) >= BN_FIELD_SET && move + 1 < 64 * m->ones);
        m->simd->field_change(&m->field, cluster, -1, both);
        bn_field_texel empty = m->simd->field_find(&m->field, BN_FIELD_LOWEST);
        if (energy_at(m, empty) >= energy_at(m, cluster)) {
            m->simd->field_change(&m->field, cluster, 1, both);
            break;
        }
        m->simd->field_change(&m->field, empty, 1, both);
    }
}

/* Removes the tightest cluster until `ones` texels remain. The removed texels are listed in
 * m->minority by rank, for put_back(). */
static void empty(maker *m, size_t ones) {
    if (m->ones <= ones) return;
    bn_field_refresh(&m->field);
    while (m->ones > ones && !cancelled(m)) {
        bn_field_texel cluster = m->simd->field_find(&m->field, BN_FIELD_HIGHEST);
        BN_ASSERT(energy_at(m, cluster) >= BN_FIELD_SET);
        m->minority[--m->ones] = (uint32_t)bn_field_index(&m->field, cluster);
        m->ranks[m->minority[m->ones]] = (uint32_t)m->ones;
        m->simd->field_change(&m->field, cluster, -1, BN_FIELD_HIGHEST);
    }
}

/* Sets the removed texels again, which restores the field exactly. */
static void put_back(maker *m, size_t ones) {
    for (; m->ones < ones && !cancelled(m); ++m->ones) {
        const bn_field_texel removed = bn_field_at(&m->field, m->minority[m->ones]);
        BN_ASSERT(energy_at(m, removed) < BN_FIELD_SET);
        m->simd->field_change(&m->field, removed, 1, BN_FIELD_LOWEST);
    }
    bn_field_refresh(&m->field);
}

/* Lists the texels that are set (or not set) in m->minority, and orders them with bn_eliminate(). */
static bn_result eliminate(maker *m, int set, size_t expected) {
    const bn_field *f = &m->field;
    size_t listed = 0;
    for (uint32_t tile = 0; tile < f->tile_count; ++tile) {
        const int32_t *energy = f->energy + (size_t)tile * BN_TILE_SIZE;
        const int32_t *keep = f->edge_keep[f->tile[tile].edge];
        for (uint32_t lane = 0; lane < BN_TILE_SIZE; ++lane) {
            if ((energy[lane] >= BN_FIELD_SET) != set || keep[lane] == 0) continue;
            const bn_field_texel texel = {tile, lane};
            if (listed < expected) m->minority[listed++] = (uint32_t)bn_field_index(f, texel);
        }
    }
    BN_ASSERT(listed == expected);
    double at = (double)m->done / (double)m->expected;
    if (at > 1) at = 1;
    const bn_eliminate_watch watch = {m->progress, m->progress_user, at, at, NULL};
    return bn_eliminate(f->extent, m->options->seed, m->minority, listed, &watch);
}

/* Runs the phases. `initial` texels are set in the initial pattern. The first `sparse` and the last `last` ranks
 * are ordered by elimination; the ranks between come from removing clusters, then from filling voids. */
static bn_result make(maker *m, const uint32_t extent[3]) {
    size_t initial = (size_t)((double)m->count * m->options->initial_fraction);
    size_t sparse = bn_eliminate_count(extent, m->count, bn_eliminate_spacing(m->options->sigma));
    if (initial == 0) initial = 1;
    if (sparse > initial) sparse = initial;
    size_t last = m->count - initial < sparse ? m->count - initial : sparse;
    m->expected = m->count + 4 * initial + 2 * (initial - sparse);

    fill(m, initial, NULL);
    if (!m->cancelled && initial < m->count) spread(m);
    empty(m, sparse);
    if (m->cancelled) return BN_ERROR_CANCELLED;
    /* bn_eliminate() uses the front of the list; the texels after it have yet to be restored. */
    bn_result result = eliminate(m, 1, sparse);
    if (result != BN_SUCCESS) return result;
    for (size_t i = 0; i < sparse; ++i) m->ranks[m->minority[i]] = (uint32_t)i;
    put_back(m, initial);
    fill(m, m->count - last, m->ranks);
    if (m->cancelled || cancelled(m)) return BN_ERROR_CANCELLED;
    BN_ASSERT(m->ones == m->count - last);
    result = eliminate(m, 0, last);
    if (result != BN_SUCCESS) return result;
    for (size_t i = 0; i < last; ++i) m->ranks[m->minority[i]] = (uint32_t)(m->count - 1 - i);
    return BN_SUCCESS;
}

/* Moves axes of extent 1 to the end, which does not change row-major order. */
static void squeeze(uint32_t extent[3]) {
    int used = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (extent[axis] > 1) extent[used++] = extent[axis];
    }
    for (; used < 3; ++used) extent[used] = 1;
}

static int good_options(const bn_void_and_cluster_options *o) {
    return bn_in_range(o->sigma, 0.25, 16) && bn_in_range(o->initial_fraction, DBL_TRUE_MIN, 0.5);
}

static BN_NOINLINE bn_result void_and_cluster(const bn_void_and_cluster_options *given,
                                              const bn_mask *mask, bn_progress progress,
                                              void *progress_user) {
    bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
    size_t count;
    bn_result result = bn_options_read(&options, sizeof options, given);
    if (result == BN_SUCCESS) result = bn_check_new_mask(mask, &count);
    if (result != BN_SUCCESS) return result;
    if (mask->channels != 1 || !good_options(&options)) return BN_ERROR_INVALID_ARGUMENT;

    uint32_t extent[3] = {mask->width, mask->height, mask->depth};
    squeeze(extent);
    maker m = {&options, progress, progress_user, .simd = bn_simd_get(), .count = count};
    m.ranks = bn_allocate(count, sizeof *m.ranks);
    m.minority = bn_allocate(count / 2 + 1, sizeof *m.minority);
    if (bn_field_create(&m.field, extent, options.sigma, bn_mix64(options.seed)) &&
        m.ranks != NULL && m.minority != NULL) {
        bn_field_refresh(&m.field);
        result = make(&m, extent);
    } else {
        result = BN_ERROR_OUT_OF_MEMORY;
    }
    if (result == BN_SUCCESS) bn_mask_write(mask, m.ranks, count);
    bn_field_destroy(&m.field);
    bn_free(m.ranks);
    bn_free(m.minority);
    return result;
}

bn_result bn_void_and_cluster(const bn_void_and_cluster_options *options, const bn_mask *mask,
                              bn_progress progress, void *progress_user) {
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(void_and_cluster(options, mask, progress, progress_user));
}
