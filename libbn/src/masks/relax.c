/* SPDX-License-Identifier: Apache-2.0
 * Parallel relaxation of a mask.
 *
 * Summed over all thresholds, the squared dithering error E_sigma^2 is a constant minus the sum
 * over pairs of W(p - q) |r_p - r_q|, where W is a Gaussian of sigma sqrt(2). Every step moves all
 * texels at once up the gradient of that sum, with the sign of r_p - r_q softened to clamp((r_p -
 * r_q) / softness). Then it ranks them again, by a histogram, its running sum and a lookup. Step
 * and softness decrease geometrically, as in annealing. Values and counts are integers, so threads
 * and instruction sets cannot change a bit. A step takes the kernel's 60 pairs and one histogram
 * entry per texel. */
#include "base/check.h"
#include "base/float_environment.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/options.h"
#include "base/portable_math.h"
#include "base/threads.h"
#include "masks/eliminate.h"
#include "masks/ranks.h"
#include "masks/relax_learned.h"
#include "simd/simd.h"
#include <float.h>
#include <string.h>

enum {
    BN_RELAX_REACH = 12, /* the most texels between a pair along an axis */
    BN_RELAX_MOST_BINS = 1 << 16,
    BN_RELAX_FRACTION = 4 /* bits below a 16-bit value */
};
static const double BN_RELAX_CUTOFF = 4.6;         /* of the kernel, in sigmas */
static const double BN_RELAX_SPARSE = 3.8;         /* sigmas between texels that do not interact */
static const double BN_RELAX_LEARNED_SPARSE = 3.5; /* the same for the learned steps, in texels */

typedef struct relaxation {
    const bn_relax_options *options;
    const bn_simd *simd;
    uint32_t width, height;
    size_t count, stride;
    int32_t reach[2];
    int16_t *image; /* the values less 32768, with a toroidal margin of the reach */
    ptrdiff_t *offsets;
    int16_t *weights; /* each repeated BN_WINDOW_LANES times */
    uint32_t pairs;
    uint16_t *bins; /* of each texel */
    uint32_t bin_count, teams;
    uint32_t *histograms; /* [threads][bin_count] */
    int16_t *values;      /* of the bins */
    int32_t *last;        /* the values after the last step, for the final ranks */
    int cancelled;
} relaxation;

typedef struct relax_step {
    int16_t limit;  /* softness in 16-bit values */
    int32_t shift;  /* that makes the limit use all 16 bits */
    int32_t rate;   /* from gradient to value, times 2^6 */
    int32_t lowest; /* value of bin 0 */
    int32_t bin_shift;
} relax_step;

static double between(double from, double to, double t) {
    return from * bn_portable_exp(t * bn_portable_log(to / from));
}

static relax_step step_at(const relaxation *r, uint32_t index) {
    const bn_relax_options *o = r->options;
    const double t = o->steps > 1 ? (double)index / (o->steps - 1) : 1;
    const double size = between(o->start_step, o->end_step, t);
    const int32_t one = 1 << (16 + BN_RELAX_FRACTION);
    relax_step s = {.limit = (int16_t)(between(o->start_softness, o->end_softness, t) * 65535)};
    if (s.limit < 1) s.limit = 1;
    while (s.limit << (s.shift + 1) <= INT16_MAX) ++s.shift;
    s.rate = (int32_t)(size * one * 64 / (s.limit << s.shift));
    /* As far as a value can move, plus a little for rounding in the gradient. */
    const int32_t margin = (int32_t)(size * one * (1 + 1.0 / 32)) + one / 64;
    s.lowest = -margin;
    while (((int64_t)one + 2 * (int64_t)margin) >> s.bin_shift >= r->bin_count) ++s.bin_shift;
    return s;
}

/* Writes a texel and its copies in the margin. */
static void place(relaxation *r, uint32_t x, uint32_t y, int16_t value) {
    const size_t rows = r->height + 2 * (size_t)r->reach[1];
    for (size_t row = (y + (uint32_t)r->reach[1]) % r->height; row < rows; row += r->height) {
        for (size_t at = (x + (uint32_t)r->reach[0]) % r->width; at < r->stride; at += r->width) {
            r->image[row * r->stride + at] = value;
        }
    }
}

static void first_values(relaxation *r, const uint32_t *ranks) {
    for (size_t i = 0; i < r->count; ++i) {
        uint32_t value = r->options->start_from_ranks
                             ? (uint32_t)((2 * (uint64_t)ranks[i] + 1) * 32768 / r->count)
                             : (uint32_t)(bn_mix64(r->options->seed ^ bn_mix64(i + 1)) >> 48);
        place(r, (uint32_t)(i % r->width), (uint32_t)(i / r->width),
              (int16_t)((int32_t)value - 32768));
    }
}

/* Moves the rows first .. last - 1: stores the bin of each new value, and counts the bins. */
static void move(relaxation *r, const relax_step *s, uint32_t first, uint32_t last,
                 uint32_t *histogram, int keep) {
    int16_t gradient[256 + BN_WINDOW_LANES];
    memset(histogram, 0, r->bin_count * sizeof *histogram);
    for (uint32_t y = first; y < last; ++y) {
        for (uint32_t x0 = 0; x0 < r->width; x0 += 256) {
            const uint32_t columns = r->width - x0 < 256 ? r->width - x0 : 256;
            const int16_t *centre =
                r->image + (y + (size_t)r->reach[1]) * r->stride + (size_t)r->reach[0] + x0;
            uint16_t *bins = r->bins + (size_t)y * r->width + x0;
            r->simd->relax_row(centre, r->offsets, r->weights, r->pairs, columns, s->limit,
                               s->shift, gradient);
            for (uint32_t x = 0; x < columns; ++x) {
                const int32_t moved =
                    ((centre[x] + 32768) << BN_RELAX_FRACTION) + (gradient[x] * s->rate >> 6);
                const uint32_t bin = (uint32_t)(moved - s->lowest) >> s->bin_shift;
                bins[x] = (uint16_t)bin;
                ++histogram[bin];
                if (keep) r->last[(size_t)y * r->width + x0 + x] = moved;
            }
        }
    }
}

/* The running sum of all histograms: the value of a bin becomes the middle of its ranks. */
static void equalise(relaxation *r, uint32_t threads) {
    uint64_t below = 0;
    const uint64_t scale = ((uint64_t)65536 << 31) / r->count;
    for (uint32_t bin = 0; bin < r->bin_count; ++bin) {
        uint64_t here = 0;
        for (uint32_t t = 0; t < threads; ++t)
            here += r->histograms[(size_t)t * r->bin_count + bin];
        uint64_t middle = (2 * below + here) * scale >> 32;
        r->values[bin] = (int16_t)((int32_t)(middle > 65535 ? 65535 : middle) - 32768);
        below += here;
    }
}

/* Writes the values of the rows first .. last - 1, with their margins at both ends. */
static void assign_values(relaxation *r, uint32_t first, uint32_t last) {
    for (uint32_t y = first; y < last; ++y) {
        int16_t *row = r->image + (y + (size_t)r->reach[1]) * r->stride;
        const uint16_t *bins = r->bins + (size_t)y * r->width;
        for (uint32_t x = 0; x < r->width; ++x) row[(size_t)r->reach[0] + x] = r->values[bins[x]];
        for (size_t at = 0; at < r->stride; ++at) {
            if (at == (size_t)r->reach[0]) at += r->width;
            if (at >= r->stride) break;
            const size_t from =
                (at + (size_t)r->width * BN_RELAX_REACH - (size_t)r->reach[0]) % r->width;
            row[at] = r->values[bins[from]];
        }
    }
}

/* Copies rows to the margins above and below. */
static void wrap_rows(relaxation *r) {
    for (int32_t row = 0; row < 2 * r->reach[1]; ++row) {
        const size_t at = row < r->reach[1] ? (size_t)row : (size_t)row + r->height;
        const size_t from =
            (at + (size_t)r->height * BN_RELAX_REACH - (size_t)r->reach[1]) % r->height;
        memcpy(r->image + at * r->stride, r->image + (from + (size_t)r->reach[1]) * r->stride,
               r->stride * sizeof *r->image);
    }
}

static void work(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    relaxation *r = user;
    const bn_relax_options *o = r->options;
    const uint32_t first = (uint32_t)((uint64_t)r->height * index / threads);
    const uint32_t last = (uint32_t)((uint64_t)r->height * (index + 1) / threads);
    uint32_t *histogram = r->histograms + (size_t)index * r->bin_count;
    for (uint32_t i = 0; i < o->steps; ++i) {
        const relax_step s = step_at(r, i);
        if (index == 0 && o->progress != NULL) {
            r->cancelled = o->progress(o->progress_user, (double)i / o->steps) != 0;
        }
        move(r, &s, first, last, histogram, i + 1 == o->steps);
        bn_team_wait(team);
        if (r->cancelled || i + 1 == o->steps) return;
        if (index == 0) equalise(r, threads);
        bn_team_wait(team);
        assign_values(r, first, last);
        bn_team_wait(team);
        if (index == 0) wrap_rows(r);
        bn_team_wait(team);
    }
}

static int fill_pairs(relaxation *r) {
    const double sigma = r->options->sigma;
    const int32_t side_x = 2 * r->reach[0] + 1, side_y = 2 * r->reach[1] + 1;
    const double limit = BN_RELAX_CUTOFF * sigma * BN_RELAX_CUTOFF * sigma;
    double sum = 0;
    r->offsets = bn_allocate((size_t)side_x * (size_t)side_y, sizeof *r->offsets);
    r->weights = bn_allocate((size_t)side_x * (size_t)side_y, BN_WINDOW_LANES * sizeof *r->weights);
    if (r->offsets == NULL || r->weights == NULL) return 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int32_t y = -r->reach[1]; y <= r->reach[1]; ++y) {
            for (int32_t x = -r->reach[0]; x <= r->reach[0]; ++x) {
                const double square = (double)x * x + (double)y * y;
                if (square == 0 || square > limit) continue;
                const double w = bn_portable_exp(-square / (4 * sigma * sigma));
                if (pass == 0) {
                    sum += w;
                    continue;
                }
                for (uint32_t lane = 0; lane < BN_WINDOW_LANES; ++lane) {
                    r->weights[r->pairs * BN_WINDOW_LANES + lane] =
                        (int16_t)(w / sum * 32000 + 0.5);
                }
                r->offsets[r->pairs++] = (ptrdiff_t)y * (ptrdiff_t)r->stride + x;
            }
        }
    }
    return 1;
}

static int good_options(const bn_relax_options *o) {
    /* The learned steps forget where they started. */
    return bn_in_range(o->sigma, 0.25, 2.5) && (o->steps != 0 || !o->start_from_ranks) &&
           bn_in_range(o->start_step, DBL_TRUE_MIN, 8) &&
           bn_in_range(o->end_step, DBL_TRUE_MIN, o->start_step) &&
           bn_in_range(o->start_softness, DBL_TRUE_MIN, 0.49) &&
           bn_in_range(o->end_softness, DBL_TRUE_MIN, o->start_softness);
}

/* Relaxes by the steps of the options: `ranks` receives the mask, whose ends are yet to order. */
static bn_result relax_by_hand(const bn_relax_options *o, uint32_t threads, uint32_t width,
                               uint32_t height, const uint32_t *start, uint32_t *ranks,
                               size_t count) {
    bn_result result = BN_SUCCESS;
    relaxation r = {
        .options = o, .simd = bn_simd_get(), .width = width, .height = height, .count = count};
    for (int axis = 0; axis < 2; ++axis) {
        const uint32_t extent = axis == 0 ? width : height;
        r.reach[axis] = (int32_t)(BN_RELAX_CUTOFF * o->sigma);
        if ((uint32_t)r.reach[axis] > (extent - 1) / 2) r.reach[axis] = (int32_t)((extent - 1) / 2);
    }
    r.stride = (size_t)width + 2 * (size_t)r.reach[0] + BN_WINDOW_LANES;
    r.bin_count = 256;
    while (r.bin_count < BN_RELAX_MOST_BINS && r.bin_count < 4 * (uint64_t)count) r.bin_count *= 2;
    r.image = bn_allocate(height + 2 * (size_t)r.reach[1], r.stride * sizeof *r.image);
    r.bins = bn_allocate(count, sizeof *r.bins);
    r.histograms = bn_allocate((size_t)threads * r.bin_count, sizeof *r.histograms);
    r.values = bn_allocate(r.bin_count, sizeof *r.values);
    r.last = bn_allocate(count, sizeof *r.last);
    float *final = bn_allocate(count, sizeof *final);
    if (!r.image || !r.bins || !r.histograms || !r.values || !r.last || !final || !fill_pairs(&r)) {
        result = BN_ERROR_OUT_OF_MEMORY;
        goto done;
    }
    first_values(&r, start);
    bn_team_run(threads, work, &r);
    if (r.cancelled) {
        result = BN_ERROR_CANCELLED;
        goto done;
    }
    /* Integers below 2^24 are exact as floats. */
    for (size_t i = 0; i < count; ++i) final[i] = (float)r.last[i];
    result = bn_ranks_on_threads(final, count, threads, ranks);
done:
    bn_free(r.image);
    bn_free(r.offsets);
    bn_free(r.weights);
    bn_free(r.bins);
    bn_free(r.histograms);
    bn_free(r.values);
    bn_free(r.last);
    bn_free(final);
    return result;
}

static BN_NOINLINE bn_result relax(const bn_relax_options *given, uint32_t width, uint32_t height,
                                   uint32_t *ranks, size_t count) {
    bn_relax_options o = bn_relax_options_default();
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result != BN_SUCCESS) return result;
    if (ranks == NULL || !good_options(&o)) return BN_ERROR_INVALID_ARGUMENT;
    result = o.start_from_ranks ? bn_check_mask(ranks, width, height, count)
                                : bn_check_extents(width, height, 1, 1, count);
    if (result != BN_SUCCESS) return result;

    uint32_t threads = o.threads != 0 ? o.threads : bn_thread_count();
    /* More threads pay off only with several thousand texels each, because of the barriers. */
    const uint64_t worth = count / 8192 + 1;
    if (threads > worth) threads = (uint32_t)worth;
    if (threads > height) threads = height;
    if (threads > BN_RELAX_MOST_THREADS) threads = BN_RELAX_MOST_THREADS;
    uint32_t *made = bn_allocate(count, sizeof *made);
    if (made == NULL) return BN_ERROR_OUT_OF_MEMORY;
    result = o.steps == 0 ? bn_relax_learned(&o, threads, width, height, made)
                          : relax_by_hand(&o, threads, width, height, ranks, made, count);
    if (result == BN_SUCCESS) {
        const uint32_t extent[3] = {width, height, 1};
        const double sparse = o.steps == 0 ? BN_RELAX_LEARNED_SPARSE : BN_RELAX_SPARSE * o.sigma;
        if (bn_eliminate_ends(extent, sparse, o.seed, threads, made, count)) {
            memcpy(ranks, made, count * sizeof *ranks);
        } else {
            result = BN_ERROR_OUT_OF_MEMORY;
        }
    }
    bn_free(made);
    return result;
}

bn_result bn_relax(const bn_relax_options *options, uint32_t width, uint32_t height,
                   uint32_t *ranks, size_t count) {
    bn_float_environment host;
    bn_float_environment_set(&host);
    const bn_result result = relax(options, width, height, ranks, count);
    bn_float_environment_restore(&host);
    return result;
}
