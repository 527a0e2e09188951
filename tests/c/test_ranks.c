/* SPDX-License-Identifier: Apache-2.0
 * Ranks from values, on any number of threads, and values from ranks. */
#include "check.h"
#include "masks.h"
#ifdef BN_TEST_INTERNALS
#include "base/threads.h"
#include "masks/ranks.h"
#endif
#include <math.h>

static void test_against_counting(void) {
    static const float special[] = {0.0f,    -0.0f,    INFINITY, -INFINITY, 1e-45f, -1e-45f,
                                    3.4e38f, -3.4e38f, 1.0f,     -1.0f,     0.5f,   0.5f};
    enum { special_count = sizeof special / sizeof *special };
    uint32_t state = 1;
    for (size_t count = 1; count < 400; count += 7) {
        float values[400];
        uint32_t ranks[400];
        for (size_t i = 0; i < count; ++i) {
            uint32_t r = next_random(&state);
            values[i] = r % 3 == 0 ? special[r / 3 % special_count]
                                   : (float)((int32_t)(r / 3 % 64) - 32) * 0.37f;
        }
        CHECK(bn_ranks_from_values(values, count, ranks) == BN_SUCCESS);
        size_t wrong = 0;
        for (size_t i = 0; i < count; ++i) {
            uint32_t smaller = 0;
            for (size_t j = 0; j < count; ++j) {
                smaller += values[j] < values[i] || (values[j] == values[i] && j < i);
            }
            wrong += ranks[i] != smaller;
        }
        CHECK(wrong == 0);
    }
}

/* Ranks are right if, in their order, values ascend and equal values keep their order. */
static int are_ranks(const float *values, size_t count, const uint32_t *ranks) {
    if (!is_permutation(ranks, count)) return 0;
    uint32_t *at = malloc(count * sizeof *at);
    size_t wrong = 0;
    for (size_t i = 0; i < count; ++i) at[ranks[i]] = (uint32_t)i;
    for (size_t r = 1; r < count; ++r) {
        const float before = values[at[r - 1]], value = values[at[r]];
        wrong += !(before < value || (before == value && at[r - 1] < at[r]));
    }
    free(at);
    return wrong == 0;
}

typedef enum distribution {
    UNIFORM,
    BELL,
    EQUAL,
    ZEROS,
    TWO_VALUES,
    LEVELS,
    OCTAVES,
    ASCENDING,
    DESCENDING,
    OUTLIER,
    DENORMAL,
    INFINITIES,
    EVERY_FLOAT,
    CLUSTER,
    CROWDED_CLUSTER,
    DISTRIBUTIONS
} distribution;

static float value_of(distribution d, size_t i, uint32_t *state) {
    const uint32_t random = next_random(state), sign = random << 31;
    const float uniform = (float)(next_random(state) >> 8) * 0x1p-24f;
    uint32_t bits = next_random(state);
    float value;
    switch (d) {
    case UNIFORM:
        return uniform;
    case BELL:
        return (float)((bits >> 16) + (bits & 0xffff)) + uniform - 65536;
    case EQUAL:
        return -7;
    case ZEROS:
        return sign ? -0.0f : 0.0f;
    case TWO_VALUES:
        return sign ? -1e20f : 0.5f;
    case LEVELS:
        return floorf(uniform * 256);
    case OCTAVES:
        return exp2f(30 * uniform);
    case ASCENDING:
        return (float)i;
    case DESCENDING:
        return -(float)i;
    case OUTLIER:
        return i == 1 ? 1e30f : uniform;
    case CLUSTER: /* in one cell of the histogram, whose ends are far away */
        return i == 0 ? -1e30f : i == 1 ? 1e30f : 1 + uniform * 0x1p-7f;
    case CROWDED_CLUSTER: /* half of them in a bucket or two, of more keys than one pass sorts */
        return sign ? (uniform - 0.5f) * 1e30f : 1 + uniform * 0x1p-10f;
    case INFINITIES:
        return random % 100 < 5 ? (sign ? INFINITY : -INFINITY) : uniform;
    case DENORMAL:
        bits &= 0x807fffffu;
        break;
    default:
        if ((bits & 0x7fffffffu) > 0x7f800000u) bits &= 0xff7fffffu;
    }
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void test_distributions(void) {
    static const size_t counts[] = {1, 2, 3, 100, 4096, 65536, 65537, 70000, 1 << 20};
    enum { most = 1 << 20 };
    float *values = malloc(most * sizeof *values);
    uint32_t *ranks = malloc(most * sizeof *ranks), state = 5;
    for (int d = 0; d < DISTRIBUTIONS; ++d) {
        for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
            const size_t count = counts[c];
            for (size_t i = 0; i < count; ++i) values[i] = value_of((distribution)d, i, &state);
            CHECK(bn_ranks_from_values(values, count, ranks) == BN_SUCCESS);
            CHECK(are_ranks(values, count, ranks));
#ifdef BN_TEST_INTERNALS
            static const uint32_t threads[] = {2, 3, 7};
            static uint32_t others[most];
            for (size_t t = 0; t < sizeof threads / sizeof *threads; ++t) {
                CHECK(bn_ranks_on_threads(values, count, threads[t], others) == BN_SUCCESS);
                CHECK(memcmp(others, ranks, count * sizeof *ranks) == 0);
            }
#endif
        }
    }
    free(values);
    free(ranks);
}

/* A NaN at either end of an input large enough for several threads. */
static void test_large_bad_input(void) {
    enum { count = 200000 };
    static float values[count];
    static uint32_t ranks[count];
    for (size_t at = 0; at < count; at += count - 1) {
        size_t touched = 0;
        values[at] = at == 0 ? NAN : -NAN;
        CHECK(bn_ranks_from_values(values, count, ranks) == BN_ERROR_BAD_DATA);
#ifdef BN_TEST_INTERNALS
        CHECK(bn_ranks_on_threads(values, count, 3, ranks) == BN_ERROR_BAD_DATA);
#endif
        for (size_t i = 0; i < count; ++i) touched += ranks[i] != 0;
        CHECK(touched == 0);
        values[at] = 0;
    }
}

static void test_bad_input(void) {
    float values[3] = {1, NAN, 2};
    uint32_t ranks[3] = {7, 7, 7};
    CHECK(bn_ranks_from_values(values, 3, ranks) == BN_ERROR_BAD_DATA);
    values[1] = -NAN;
    CHECK(bn_ranks_from_values(values, 3, ranks) == BN_ERROR_BAD_DATA);
    CHECK(bn_ranks_from_values(NULL, 3, ranks) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_ranks_from_values(values, 3, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_ranks_from_values(values, 0, ranks) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(ranks[0] == 7 && ranks[1] == 7 && ranks[2] == 7);
}

#ifdef BN_TEST_INTERNALS
enum { ROUNDS = 200, TEAM = 7, PIECES = 1000 };

typedef struct shared_work {
    uint32_t written[TEAM], wrong[TEAM], taken[TEAM][PIECES], taken_count[TEAM], size;
} shared_work;

/* Each member reads in every round what all others wrote in it, and takes pieces until there are
 * none. */
static void member(void *user, bn_team *team, uint32_t index, uint32_t size) {
    shared_work *w = user;
    if (index == 0) w->size = size;
    for (uint32_t round = 1; round <= ROUNDS; ++round) {
        w->written[index] = round;
        bn_team_wait(team);
        for (uint32_t i = 0; i < size; ++i) w->wrong[index] += w->written[i] != round;
        bn_team_wait(team);
    }
    for (uint32_t piece; (piece = bn_team_next(team)) != UINT32_MAX;) {
        if (piece + 1 >= PIECES) bn_team_stop(team);
        if (piece < PIECES) w->taken[index][w->taken_count[index]++] = piece;
    }
}

static void test_team(void) {
    CHECK(bn_thread_count() >= 1 && bn_thread_count() <= 64);
    for (uint32_t threads = 1; threads <= TEAM; threads += 3) {
        static shared_work w;
        static uint32_t times[PIECES];
        memset(&w, 0, sizeof w);
        memset(times, 0, sizeof times);
        bn_team_run(threads, member, &w);
        CHECK(w.size == threads);
        for (uint32_t i = 0; i < threads; ++i) {
            CHECK(w.wrong[i] == 0);
            for (uint32_t k = 0; k < w.taken_count[i]; ++k) ++times[w.taken[i][k]];
        }
        for (uint32_t piece = 0; piece < PIECES; ++piece) CHECK(times[piece] == 1);
    }
}
#endif

static void test_to_float(void) {
    CHECK(bn_rank_to_float(0, 1) == 0.5f);
    CHECK(bn_rank_to_float(1, 2) == 0.75f);
    CHECK(bn_rank_to_float(9, 2) == 0.75f);
    CHECK(bn_rank_to_float(3, 0) == 0.0f);
    static const size_t counts[] = {3, 4096, 65536, 1u << 24, (1u << 24) + 1, UINT32_MAX};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        uint32_t state = 3;
        for (int i = 0; i < 10000; ++i) {
            uint32_t rank = (uint32_t)(next_random(&state) % counts[c]);
            if (i == 0) rank = (uint32_t)(counts[c] - 1);
            float value = bn_rank_to_float(rank, counts[c]);
            double exact = (rank + 0.5) / (double)counts[c];
            /* Rounded down to the nearest float, and never one. */
            CHECK(value >= 0 && value < 1 && (double)value <= exact);
            CHECK((double)nextafterf(value, 2) > exact || value == 1 - 0x1p-24f);
        }
    }
}

int main(void) {
    test_against_counting();
    test_distributions();
    test_bad_input();
    test_large_bad_input();
    test_to_float();
#ifdef BN_TEST_INTERNALS
    test_team();
#endif
    return check_result();
}
