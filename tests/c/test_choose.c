/* SPDX-License-Identifier: Apache-2.0
 * Choices over every possible draw: the probability of each item, the exact limits between items, and how
 * evenly the remainders fill [0, 1). */
#include "check.h"
#include <bn/bn_choose.h>
#include <math.h>
#include <stdlib.h>

enum { STEPS = 1 << 24, THRESHOLDS = 8 };

static float draw(uint32_t step) {
    return (float)step / STEPS;
}

/* A remainder is a valid draw: a multiple of 2^-24 in [0, 1). */
static int is_draw(float u) {
    return u >= 0.0f && u < 1.0f && u * STEPS == floorf(u * STEPS);
}

/* An item's statistics: how many draws choose it, and how many remainders are below each threshold. */
typedef struct item {
    uint32_t count, below[THRESHOLDS];
    float last;
    int bad; /* remainders that are not valid draws or not in ascending order */
} item;

static void item_add(item *it, float left) {
    it->bad += !is_draw(left) || (it->count > 0 && left < it->last);
    it->last = left;
    ++it->count;
    for (int t = 0; t < THRESHOLDS; ++t) it->below[t] += left < ((float)t + 0.5f) / THRESHOLDS;
}

/* The number of remainders below each threshold deviates from uniform by at most `slack`. */
static void check_even(const item *it, double slack) {
    CHECK(it->bad == 0);
    for (int t = 0; t < THRESHOLDS; ++t) {
        CHECK(fabs(it->below[t] - it->count * (t + 0.5) / THRESHOLDS) <= slack);
    }
}

static void test_probability(float p) {
    item items[2] = {{0}, {0}};
    int wrong = 0;
    for (uint32_t step = 0; step < STEPS; ++step) {
        float u = draw(step);
        const int expected = u < p, chosen = bn_choose(p, &u);
        wrong += chosen != expected;
        item_add(&items[!chosen], u);
    }
    CHECK(wrong == 0);
    CHECK(items[0].count == (uint32_t)ceil((double)p * STEPS));
    CHECK(items[0].count + items[1].count == STEPS);
    check_even(&items[0], 0.5);
    check_even(&items[1], 0.5);
}

/* Tests the last draw below a limit and the first draw above it. Their remainders are the largest and
 * smallest of their items. */
static void check_limit(uint32_t limit, float p) {
    const uint32_t width[2] = {limit, STEPS - limit};
    for (uint32_t side = 0; side < 2; ++side) {
        if (width[side] == 0) continue;
        float u = draw(side == 0 ? limit - 1 : limit);
        const uint32_t numerator = side == 0 ? 2 * width[side] - 1 : 1;
        CHECK(bn_choose(p, &u) == (side == 0));
        CHECK(u == draw((uint32_t)(((uint64_t)numerator << 23) / width[side])));
        CHECK(is_draw(u));
    }
}

static void test_limits(void) {
    uint32_t random = 1;
    for (uint32_t i = 0; i <= 100000; ++i) {
        random = random * 1664525u + 1013904223u;
        const uint32_t limit = i < 300 ? i : i < 600 ? STEPS - (i - 300) : random >> 8;
        check_limit(limit, draw(limit));
        /* Only probabilities below 1/2 can lie between multiples of 2^-24. They are rounded up. */
        if (limit > 0 && limit < STEPS / 2) check_limit(limit + 1, nextafterf(draw(limit), 1.0f));
        if (limit > 1 && limit <= STEPS / 2) check_limit(limit, nextafterf(draw(limit), 0.0f));
    }
    check_limit(1, 1e-45f);
}

static void test_count(uint32_t count) {
    item *items = calloc(count, sizeof *items);
    uint32_t last = 0, narrow = STEPS, wide = 0;
    int wrong = 0;
    for (uint32_t step = 0; step < STEPS; ++step) {
        float u = draw(step);
        const uint32_t chosen = bn_choose_u32(count, &u);
        wrong +=
            chosen >= count || chosen < last || chosen > last + 1 || (step == 0 && chosen != 0);
        if (chosen >= count) break;
        last = chosen;
        /* Together, the choice and its remainder give the centre of the step. */
        wrong += fabs((chosen + (double)u) / count - (step + 0.5) / STEPS) > 1.0 / STEPS / count;
        item_add(&items[chosen], u);
    }
    CHECK(wrong == 0 && last == count - 1);
    for (uint32_t i = 0; i < count; ++i) {
        if (items[i].count < narrow) narrow = items[i].count;
        if (items[i].count > wide) wide = items[i].count;
        check_even(&items[i], STEPS % count == 0 ? 0.5 : 1.0);
    }
    CHECK(narrow >= STEPS / count && wide <= STEPS / count + (STEPS % count != 0));
    free(items);
}

/* Tables of cumulative weights with any sum. The choice is the first item whose limit exceeds u times the
 * sum. If the sum is a power of two, the results match those for a table of probabilities. */
static void test_cumulative_tables(void) {
    static const float sums[] = {1.0f, 1e-30f};
    enum { COUNT = 9 };
    static const float shares[COUNT] = {0.0f, 0.125f,     0.3f, 0.3f, 0.3f + 6e-8f,
                                        0.6f, 0.9999999f, 1.0f, 1.0f};
    for (int s = 0; s < 2; ++s) {
        item items[COUNT] = {{0}};
        float cdf[COUNT], doubled[COUNT];
        int wrong = 0;
        for (int i = 0; i < COUNT; ++i) {
            cdf[i] = shares[i] * sums[s];
            doubled[i] = shares[i] * 0.25f;
        }
        for (uint32_t step = 0; step < STEPS; ++step) {
            float u = draw(step), v = u, w = u;
            uint32_t expected = 0;
            while (expected < COUNT - 1 && !(u * sums[s] < cdf[expected])) ++expected;
            const uint32_t chosen = bn_choose_cdf(cdf, COUNT, &u);
            wrong += chosen != expected;
            item_add(&items[expected], u);
            if (s > 0) continue;
            wrong +=
                bn_choose_cdf(shares, COUNT, &v) != bn_choose_cdf(doubled, COUNT, &w) || v != w;
        }
        CHECK(wrong == 0);
        for (int i = 0; i < COUNT; ++i) {
            const double share = (double)cdf[i] - (i > 0 ? (double)cdf[i - 1] : 0.0);
            check_even(&items[i], 0.5);
            CHECK(fabs(items[i].count - share / cdf[COUNT - 1] * STEPS) < 2.5);
        }
    }
}

static void test_bad_arguments(void) {
    static const float outside[] = {-0.0f, -1e-30f, -1.0f, -INFINITY, NAN, 1.0f, 1.5f, INFINITY};
    const float last = draw(STEPS - 1);
    for (int i = 0; i < 8; ++i) {
        const float inside = i < 5 ? 0.0f : last;
        float u = outside[i], v = inside;
        CHECK(bn_choose(0.3f, &u) == bn_choose(0.3f, &v) && u == v);
        u = outside[i], v = inside;
        CHECK(bn_choose_u32(7, &u) == bn_choose_u32(7, &v) && u == v);
        static const float cdf[] = {0.3f, 0.6f, 1.0f};
        u = outside[i], v = inside;
        CHECK(bn_choose_cdf(cdf, 3, &u) == bn_choose_cdf(cdf, 3, &v) && u == v);
        u = 0.5f;
        CHECK(bn_choose(outside[i], &u) == (i >= 5) && u == 0.5f);
    }
    float u = 0.5f + 1.0f / STEPS;
    CHECK(bn_choose_u32(0, &u) == 0 && u == 0.5f + 1.0f / STEPS);
    CHECK(bn_choose_cdf(NULL, 0, &u) == 0 && u == 0.5f + 1.0f / STEPS);
    u = 0.5f + 1.0f / STEPS;
    CHECK(bn_choose_u32(1, &u) == 0 && u == 0.5f + 1.0f / STEPS);
    u = draw(3) / 4; /* more than 24 bits */
    CHECK(bn_choose(1.0f, &u) == 1 && u == 0.0f);

    static const float strange[][2] = {{0.5f, 0.0f}, {0.5f, -2.0f}, {0.5f, NAN}, {0.5f, 1e38f}};
    for (int i = 0; i < 4; ++i) { /* invalid sums are treated as 1 */
        u = 0.25f;
        CHECK(bn_choose_cdf(strange[i], 2, &u) == 0 && u == 0.5f + 1.0f / STEPS);
    }

    /* For any table, the result is an item of the table and the remainder is a valid draw. */
    float table[9];
    uint32_t random = 7;
    int wrong = 0;
    for (int i = 0; i < 200000; ++i) {
        for (int k = 0; k < 9; ++k) {
            random = random * 1664525u + 1013904223u;
            table[k] = random >> 28 == 0 ? NAN : (float)(int32_t)random / (float)(1u << 30);
        }
        u = draw(random >> 8);
        wrong += bn_choose_cdf(table, 9, &u) >= 9 || !is_draw(u);
    }
    CHECK(wrong == 0);
}

int main(void) {
    test_probability(0.3f);
    test_count(7);
    test_count(1000);
    test_limits();
    test_cumulative_tables();
    test_bad_arguments();
    return check_result();
}
