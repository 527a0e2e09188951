/* SPDX-License-Identifier: Apache-2.0
 * Ranks of values and values of ranks.
 *
 * Floats become integers of the same order, the keys. Up to 2^16 keys are ranked by a radix sort of
 * their positions, least significant digit first. Larger inputs would fall out of the cache, so they
 * are first divided into buckets of about the same size, by the distribution of a sample (the idea of
 * Kristo et al., "The Case for a Learned Sorting Algorithm", 2020). Each bucket is ranked by that
 * sort, and each value then reads its rank from its bucket. All of this is linear and stable, so
 * equal values keep their order. Threads first share the values, then the buckets.
 *
 * Scratch memory per value: 14 bytes up to 2^16 values, 5 beyond, and up to 15 if most of them are so
 * close together that they share a bucket. */
#include "masks/ranks.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/threads.h"
#include <string.h>

enum {
    BN_RANKS_CACHED = 1 << 16, /* up to so many are ranked without buckets, on one thread */
    /* With fewer, a thread saves hardly more time than it takes to start. */
    BN_RANKS_PER_THREAD = 1 << 16,
    BN_RANKS_MOST_THREADS = 64,
    BN_BUCKETS_MOST = 256,      /* so that the number of a bucket is a byte */
    BN_BUCKET_VALUES = 1 << 11, /* of an average bucket, at least */
    BN_SAMPLES = 1 << 12,
    BN_CELL_BITS = 12,
    BN_CELLS = 1 << BN_CELL_BITS, /* of the histogram of the samples */
    BN_DIGIT_LEAST_BITS = 6,
    BN_DIGIT_MOST_BITS = 11,
    BN_DIGIT_COUNTERS = 3 << BN_DIGIT_MOST_BITS, /* of 3 passes; shorter digits need fewer */
    /* Hardware prefetchers follow a few streams, not one per bucket: without prefetching a cache line
     * (16 values) ahead, a million values take half as long again. */
    BN_AHEAD = 16
};

#if defined(__GNUC__)
#define PREFETCH_READ(address) __builtin_prefetch(address, 0)
#define PREFETCH_WRITE(address) __builtin_prefetch(address, 1)
#else
#define PREFETCH_READ(address) ((void)(address))
#define PREFETCH_WRITE(address) ((void)(address))
#endif

/* The key of infinity: those of NaNs are greater, or less than its negative. */
static const int32_t BN_KEY_INFINITY = 0x7f800000;

/* A signed integer in the order of the floats. Both zeros have the key 0. Reads no float, so that
 * the host's floating-point environment has no effect. */
static inline int32_t key_at(const float *values, size_t i) {
    uint32_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    const uint32_t sign = 0u - (bits >> 31);
    return (int32_t)((bits ^ (sign & 0x7fffffffu)) - sign);
}

typedef struct key_range {
    int32_t low, high;
} key_range;

static inline key_range widened(key_range r, int32_t key) {
    return (key_range){key < r.low ? key : r.low, key > r.high ? key : r.high};
}

static int has_nan(key_range r) {
    return r.low < -BN_KEY_INFINITY || r.high > BN_KEY_INFINITY;
}

static uint32_t bit_length(uint32_t x) {
    uint32_t length = 0;
    for (; x != 0; x >>= 1) ++length;
    return length;
}

/* ---- Radix sort */

typedef struct sorter {
    uint32_t *positions;
    size_t room;
    uint32_t counters[BN_DIGIT_COUNTERS];
} sorter;

/* Room for `count` positions. Returns 0 if out of memory. */
static int reserve(sorter *s, size_t count) {
    if (count <= s->room) return 1;
    bn_free(s->positions);
    /* A quarter more than that, as the next bucket may be a little larger. */
    s->room = count + count / 4;
    s->positions = bn_allocate(s->room, sizeof *s->positions);
    if (s->positions == NULL) s->room = 0;
    return s->room != 0;
}

/* Counts the digits of each pass. Two or three at a time, which are the most common, take less time
 * than one after the other. */
static void count_digits(uint32_t *counters, uint32_t passes, uint32_t width, const uint32_t *keys,
                         size_t count, uint32_t base) {
    const uint32_t size = 1u << width, mask = size - 1;
    uint32_t *second = counters + size, *third = second + size;
    memset(counters, 0, (size_t)passes * size * sizeof *counters);
    if (passes == 2) {
        for (size_t i = 0; i < count; ++i) {
            const uint32_t key = keys[i] - base;
            ++counters[key & mask];
            ++second[key >> width];
        }
    } else if (passes == 3) {
        for (size_t i = 0; i < count; ++i) {
            const uint32_t key = keys[i] - base;
            ++counters[key & mask];
            ++second[key >> width & mask];
            ++third[key >> 2 * width];
        }
    } else {
        for (uint32_t pass = 0; pass < passes; ++pass) {
            uint32_t *here = counters + pass * size;
            const uint32_t shift = pass * width;
            for (size_t i = 0; i < count; ++i) ++here[(keys[i] - base) >> shift & mask];
        }
    }
}

/* Replaces keys, which are all in the range, by their ranks plus `first`. (Writing ranks to another
 * array would touch more memory.) Returns 0 if out of memory. */
static int rank_keys(sorter *s, uint32_t *keys, size_t count, key_range range, uint32_t first) {
    const uint32_t base = (uint32_t)range.low, bits = bit_length((uint32_t)range.high - base);
    if (bits == 0) {
        for (size_t i = 0; i < count; ++i) keys[i] = first + (uint32_t)i;
        return 1;
    }
    /* Short digits for few keys, so that clearing and summing the counters stays cheap. */
    uint32_t most = bit_length((uint32_t)count);
    most = most < BN_DIGIT_LEAST_BITS + 2  ? BN_DIGIT_LEAST_BITS
           : most > BN_DIGIT_MOST_BITS + 2 ? BN_DIGIT_MOST_BITS
                                           : most - 2;
    const uint32_t passes = (bits + most - 1) / most;
    const uint32_t width = (bits + passes - 1) / passes, mask = (1u << width) - 1;
    const uint32_t last_shift = (passes - 1) * width;
    uint32_t *counters = s->counters;
    count_digits(counters, passes, width, keys, count, base);
    for (uint32_t pass = 0; pass < passes; ++pass) {
        uint32_t *here = counters + (pass << width);
        uint32_t sum = pass + 1 == passes ? first : 0;
        for (uint32_t digit = 0; digit <= mask; ++digit) {
            const uint32_t equal = here[digit];
            here[digit] = sum;
            sum += equal;
        }
    }
    if (passes == 1) {
        for (size_t i = 0; i < count; ++i) keys[i] = counters[keys[i] - base]++;
        return 1;
    }
    if (!reserve(s, passes == 2 ? count : 2 * count)) return 0;
    uint32_t *from = s->positions, *to = s->positions + count;
    for (size_t i = 0; i < count; ++i) from[counters[(keys[i] - base) & mask]++] = (uint32_t)i;
    for (uint32_t pass = 1; pass + 1 < passes; ++pass) {
        uint32_t *here = counters + (pass << width);
        const uint32_t shift = pass * width;
        for (size_t i = 0; i < count; ++i) {
            const uint32_t at = from[i];
            to[here[(keys[at] - base) >> shift & mask]++] = at;
        }
        uint32_t *swap = from;
        from = to;
        to = swap;
    }
    uint32_t *here = counters + ((passes - 1) << width);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t at = from[i];
        keys[at] = here[(keys[at] - base) >> last_shift]++;
    }
    return 1;
}

static bn_result rank_few(const float *values, size_t count, uint32_t *ranks) {
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    sorter *s = bn_allocate(1, sizeof *s);
    uint32_t *keys = bn_allocate(count, sizeof *keys);
    if (s == NULL || keys == NULL) goto done;
    s->positions = NULL;
    s->room = 0;
    key_range range = {INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < count; ++i) {
        const int32_t key = key_at(values, i);
        range = widened(range, key);
        keys[i] = (uint32_t)key;
    }
    if (has_nan(range)) {
        result = BN_ERROR_BAD_DATA;
    } else if (rank_keys(s, keys, count, range, 0)) {
        memcpy(ranks, keys, count * sizeof *ranks);
        result = BN_SUCCESS;
    }
    bn_free(s->positions);
done:
    bn_free(s);
    bn_free(keys);
    return result;
}

/* ---- Buckets */

typedef struct ranking {
    const float *values;
    size_t count;
    uint32_t *ranks;
    uint32_t buckets;
    key_range ranges[BN_RANKS_MOST_THREADS];
    bn_result results[BN_RANKS_MOST_THREADS];
    /* Cells have 2^cell_shift keys, from the least key on. A cell begins in bucket cells[c] / 2^16
     * and its keys are spread evenly as far as cells[c + 1]. */
    uint32_t least, cell_shift;
    uint32_t cells[BN_CELLS + 1];
    uint32_t bounds[BN_BUCKETS_MOST + 1]; /* where the buckets begin in `keys` */
    uint32_t (*ends)[BN_BUCKETS_MOST];    /* [threads]: where each thread adds to the buckets */
    uint8_t *bucket_of;                   /* [count] */
    uint32_t *keys;                       /* [count]: bucket by bucket */
    sorter *sorters;                      /* [threads] */
} ranking;

/* Divides the range of keys so that the buckets get about the same number of samples. Bad samples
 * cost time, but change no rank. */
static void divide(ranking *r, key_range range) {
    const uint32_t bits = bit_length((uint32_t)range.high - (uint32_t)range.low);
    const uint64_t all = (uint64_t)r->buckets << 16;
    uint32_t *cells = r->cells;
    r->least = (uint32_t)range.low;
    r->cell_shift = bits > BN_CELL_BITS ? bits - BN_CELL_BITS : 0;
    memset(cells, 0, sizeof r->cells);
    for (uint32_t i = 0; i < BN_SAMPLES; ++i) {
        /* One at a random place in each of equal parts, as values may repeat themselves. */
        const uint64_t place = ((uint64_t)i << 32 | bn_mix64(i) >> 32) / BN_SAMPLES;
        const size_t at = (size_t)(place * r->count >> 32);
        ++cells[((uint32_t)key_at(r->values, at) - r->least) >> r->cell_shift];
    }
    uint64_t sum = 0;
    for (uint32_t c = 0; c <= BN_CELLS; ++c) {
        const uint32_t here = cells[c];
        /* The greatest key is in the last bucket, not one further. */
        cells[c] = (uint32_t)(sum < BN_SAMPLES ? all * sum / BN_SAMPLES : all - 1);
        sum += here;
    }
}

/* The bucket of a key, from its distance to the least one. */
static inline uint32_t bucket_of(const uint32_t *cells, uint32_t cell_shift, uint32_t distance) {
    const uint32_t cell = distance >> cell_shift, begin = cells[cell];
    const uint64_t part = distance & ((1u << cell_shift) - 1), width = cells[cell + 1] - begin;
    return (begin + (uint32_t)(part * width >> cell_shift)) >> 16;
}

/* Sums counts, of each bucket in the order of the threads: they become the places where each thread
 * begins to add to each bucket. */
static void sum_counts(ranking *r, uint32_t threads) {
    uint32_t sum = 0;
    for (uint32_t b = 0; b < r->buckets; ++b) {
        r->bounds[b] = sum;
        for (uint32_t t = 0; t < threads; ++t) {
            const uint32_t here = r->ends[t][b];
            r->ends[t][b] = sum;
            sum += here;
        }
    }
    r->bounds[r->buckets] = sum;
}

/* Replaces the keys of a bucket by their ranks. */
static int rank_bucket(ranking *r, uint32_t bucket, sorter *s) {
    const uint32_t begin = r->bounds[bucket], count = r->bounds[bucket + 1] - begin;
    uint32_t *keys = r->keys + begin;
    key_range range = {INT32_MAX, INT32_MIN};
    for (uint32_t i = 0; i < count; ++i) range = widened(range, (int32_t)keys[i]);
    return count == 0 || rank_keys(s, keys, count, range, begin);
}

/* What one thread of the team does, with its share of the values. */
typedef struct share {
    ranking *r;
    bn_team *team;
    uint32_t index, threads;
    size_t begin, end;
} share;

static void find_range(const share *s) {
    const float *values = s->r->values;
    key_range range = {INT32_MAX, INT32_MIN};
    for (size_t i = s->begin; i < s->end; ++i) range = widened(range, key_at(values, i));
    s->r->ranges[s->index] = range;
}

static key_range range_of_all(const share *s) {
    key_range range = s->r->ranges[0];
    for (uint32_t t = 1; t < s->threads; ++t)
        range = widened(widened(range, s->r->ranges[t].low), s->r->ranges[t].high);
    return range;
}

/* Notes the bucket of each value and how many go to each. */
static void choose_buckets(const share *s) {
    const ranking *r = s->r;
    const float *values = r->values;
    uint32_t *mine = r->ends[s->index];
    uint8_t *buckets = r->bucket_of;
    const uint32_t least = r->least, cell_shift = r->cell_shift, *cells = r->cells;
    memset(mine, 0, sizeof r->ends[s->index]);
    for (size_t i = s->begin; i < s->end; ++i) {
        const uint32_t to = bucket_of(cells, cell_shift, (uint32_t)key_at(values, i) - least);
        buckets[i] = (uint8_t)to;
        ++mine[to];
    }
}

static void fill_buckets(const share *s) {
    const float *values = s->r->values;
    const uint8_t *buckets = s->r->bucket_of;
    uint32_t *keys = s->r->keys, *mine = s->r->ends[s->index];
    for (size_t i = s->begin; i < s->end; ++i) {
        const uint32_t at = mine[buckets[i]]++;
        PREFETCH_WRITE(keys + at + BN_AHEAD);
        keys[at] = (uint32_t)key_at(values, i);
    }
}

/* Ranks whole buckets, whichever is next, until none is left or memory runs out. */
static void rank_buckets(const share *s) {
    ranking *r = s->r;
    uint32_t bucket;
    while ((bucket = bn_team_next(s->team)) < r->buckets) {
        if (!rank_bucket(r, bucket, &r->sorters[s->index])) {
            r->results[s->index] = BN_ERROR_OUT_OF_MEMORY;
            bn_team_stop(s->team);
        }
    }
}

/* Backwards, each thread passes what it added to the buckets, from the last key to the first. */
static void read_ranks(const share *s) {
    const uint8_t *buckets = s->r->bucket_of;
    uint32_t *keys = s->r->keys, *ranks = s->r->ranks, *mine = s->r->ends[s->index];
    for (size_t i = s->end; i-- > s->begin;) {
        const uint32_t at = --mine[buckets[i]];
        PREFETCH_READ(keys + at - BN_AHEAD);
        ranks[i] = keys[at];
    }
}

/* The steps of ranking. Each reads what all threads wrote in the one before, so that they wait for
 * each other in between; all of them see the same reason to give up, and leave together. */
static void work(void *user, bn_team *team, uint32_t index, uint32_t threads) {
    ranking *r = user;
    const share s = {r,
                     team,
                     index,
                     threads,
                     (size_t)((uint64_t)r->count * index / threads),
                     (size_t)((uint64_t)r->count * (index + 1) / threads)};
    find_range(&s);
    bn_team_wait(team);
    const key_range range = range_of_all(&s);
    if (has_nan(range)) {
        r->results[index] = BN_ERROR_BAD_DATA;
        return;
    }
    if (index == 0) divide(r, range);
    bn_team_wait(team);
    choose_buckets(&s);
    bn_team_wait(team);
    if (index == 0) sum_counts(r, threads);
    bn_team_wait(team);
    fill_buckets(&s);
    bn_team_wait(team);
    rank_buckets(&s);
    bn_team_wait(team);
    for (uint32_t t = 0; t < threads; ++t) {
        if (r->results[t] != BN_SUCCESS) return;
    }
    read_ranks(&s);
}

static bn_result rank_many(const float *values, size_t count, uint32_t threads, uint32_t *ranks) {
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    ranking *r = bn_allocate_zero(1, sizeof *r);
    if (r == NULL) return result;
    const size_t most = count / BN_BUCKET_VALUES;
    r->values = values;
    r->count = count;
    r->ranks = ranks;
    r->buckets = most < BN_BUCKETS_MOST ? (uint32_t)most : BN_BUCKETS_MOST;
    r->ends = bn_allocate(threads, sizeof *r->ends);
    r->bucket_of = bn_allocate(count, sizeof *r->bucket_of);
    r->sorters = bn_allocate_zero(threads, sizeof *r->sorters);
    /* Prefetches stay within the array. */
    uint32_t *keys = bn_allocate(count + 2 * (size_t)BN_AHEAD, sizeof *keys);
    if (r->ends != NULL && r->bucket_of != NULL && r->sorters != NULL && keys != NULL) {
        r->keys = keys + BN_AHEAD;
        bn_team_run(threads, work, r);
        result = BN_SUCCESS;
        for (uint32_t t = 0; t < threads; ++t) {
            if (r->results[t] != BN_SUCCESS) result = r->results[t];
            bn_free(r->sorters[t].positions);
        }
    }
    bn_free(r->ends);
    bn_free(r->bucket_of);
    bn_free(r->sorters);
    bn_free(keys);
    bn_free(r);
    return result;
}

bn_result bn_ranks_on_threads(const float *values, size_t count, uint32_t threads,
                              uint32_t *ranks) {
    if (values == NULL || ranks == NULL || count == 0) return BN_ERROR_INVALID_ARGUMENT;
    if (count > UINT32_MAX) return BN_ERROR_OUT_OF_MEMORY;
    if (count <= BN_RANKS_CACHED) return rank_few(values, count, ranks);
    if (threads > count / BN_RANKS_PER_THREAD) threads = (uint32_t)(count / BN_RANKS_PER_THREAD);
    if (threads > BN_RANKS_MOST_THREADS) threads = BN_RANKS_MOST_THREADS;
    return rank_many(values, count, threads, ranks);
}

bn_result bn_ranks_from_values(const float *values, size_t count, uint32_t *ranks) {
    return bn_ranks_on_threads(values, count, 1, ranks);
}

float bn_rank_to_float(uint32_t rank, size_t count) {
    if (count == 0) return 0;
    if (rank >= count) rank = (uint32_t)(count - 1);
    double value = (rank + 0.5) / (double)count;
    if (value > 1 - 0x1p-24) return 1 - 0x1p-24f;
    float rounded = (float)value;
    if ((double)rounded > value) {
        uint32_t bits;
        memcpy(&bits, &rounded, sizeof bits);
        --bits;
        memcpy(&rounded, &bits, sizeof rounded);
    }
    return rounded;
}
