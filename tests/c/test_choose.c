/* SPDX-License-Identifier: Apache-2.0
 * Choices at every seventh draw and on both sides of each limit: the item is the one that contains the draw, and
 * the remainder is the draw's position in the item, so remainders fill [0, 1) evenly. */
#include "check.h"
#include <bn/bn_choose.h>
#include <math.h>

enum { STEPS = 1 << 24, STRIDE = 7 /* coprime to STEPS */ };

static float draw(uint32_t step) {
    return (float)step / STEPS;
}

/* A remainder is a valid draw: a multiple of 2^-24 in [0, 1). */
static int is_draw(float u) {
    return u >= 0.0f && u < 1.0f && u * STEPS == floorf(u * STEPS);
}

/* Whether a remainder is the centre of a step within the steps low to high - 1, rounded down to a draw. */
static int is_remainder(float left, uint32_t step, uint32_t low, uint32_t high) {
    return step >= low && step < high &&
           left == draw((uint32_t)(((uint64_t)(2 * (step - low) + 1) << 23) / (high - low)));
}

static int is_choice(float p, uint32_t step, uint32_t limit) {
    float u = draw(step);
    const int below = u < p;
    return bn_choose(p, &u) == below &&
           is_remainder(u, step, below ? 0 : limit, below ? limit : STEPS);
}

/* Tests the draws on both sides of a probability's limit: the last and the first of their items. */
static void check_limit(uint32_t limit, float p) {
    if (limit > 0) CHECK(is_choice(p, limit - 1, limit));
    if (limit < STEPS) CHECK(is_choice(p, limit, limit));
}

static void test_probabilities(void) {
    const float p = 0.3f;
    const uint32_t third = (uint32_t)ceil((double)p * STEPS);
    int wrong = 0;
    for (uint32_t step = 0; step < STEPS; step += STRIDE) wrong += !is_choice(p, step, third);
    CHECK(wrong == 0);
    uint32_t random = 1;
    for (uint32_t i = 0; i <= 100000; ++i) {
        const uint32_t some = next_random(&random) >> 8;
        const uint32_t limit = i < 300 ? i : i < 600 ? STEPS - (i - 300) : some;
        check_limit(limit, draw(limit));
        /* Only probabilities below 1/2 can lie between multiples of 2^-24. They are rounded up. */
        if (limit > 0 && limit < STEPS / 2) check_limit(limit + 1, nextafterf(draw(limit), 1.0f));
        if (limit > 1 && limit <= STEPS / 2) check_limit(limit, nextafterf(draw(limit), 0.0f));
    }
    check_limit(1, 1e-45f);
}

/* Together, a choice and its remainder give the centre of the step. */
static int is_count_choice(uint32_t count, uint32_t step) {
    float u = draw(step);
    const uint32_t chosen = bn_choose_u32(count, &u);
    const double at = (chosen + (double)u) / count, centre = (step + 0.5) / STEPS;
    return chosen < count && is_draw(u) && fabs(at - centre) <= 1.0 / STEPS / count;
}

static void test_count(uint32_t count) {
    int wrong = 0;
    for (uint32_t step = 0; step < STEPS; step += STRIDE) wrong += !is_count_choice(count, step);
    for (uint64_t i = 0; i <= count; ++i) {
        const uint32_t limit = (uint32_t)(i * STEPS / count);
        wrong += limit > 0 && !is_count_choice(count, limit - 1);
        wrong += limit < STEPS && !is_count_choice(count, limit);
    }
    CHECK(wrong == 0);
}

/* Tables of cumulative weights with any sum. The choice is the first item whose limit exceeds u times the
 * sum. If the sum is a power of two, the results match those for a table of probabilities. */
static void test_cumulative_tables(void) {
    static const float sums[] = {1.0f, 1e-30f};
    enum { COUNT = 9 };
    static const float shares[COUNT] = {0.0f, 0.125f,     0.3f, 0.3f, 0.3f + 6e-8f,
                                        0.6f, 0.9999999f, 1.0f, 1.0f};
    for (int s = 0; s < 2; ++s) {
        float cdf[COUNT], doubled[COUNT];
        uint32_t bounds[COUNT + 1] = {0};
        int wrong = 0;
        for (int i = 0; i < COUNT; ++i) {
            cdf[i] = shares[i] * sums[s];
            doubled[i] = shares[i] * 0.25f;
            uint32_t low = 0, high = STEPS; /* bisects for the first draw that is not below */
            while (low < high) {
                const uint32_t middle = (low + high) / 2;
                if (draw(middle) * sums[s] < cdf[i]) {
                    low = middle + 1;
                } else {
                    high = middle;
                }
            }
            bounds[i + 1] = low;
        }
        CHECK(bounds[COUNT] == STEPS && bounds[5] - bounds[4] <= 2);
        for (uint32_t k = 0; k < STEPS / STRIDE + 2 * COUNT; ++k) {
            const uint32_t edge = k / 2 < COUNT ? bounds[k / 2 + 1] - k % 2 : 0;
            const uint32_t step = k < 2 * COUNT ? edge % STEPS : (k - 2 * COUNT) * STRIDE;
            float u = draw(step), v = u, w = u;
            uint32_t item = 0;
            while (item < COUNT - 1 && !(u * sums[s] < cdf[item])) ++item;
            wrong += bn_choose_cdf(cdf, COUNT, &u) != item ||
                     !is_remainder(u, step, bounds[item], bounds[item + 1]);
            wrong +=
                bn_choose_cdf(shares, COUNT, &v) != bn_choose_cdf(doubled, COUNT, &w) || v != w;
        }
        CHECK(wrong == 0);
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
            next_random(&random);
            table[k] = random >> 28 == 0 ? NAN : (float)(int32_t)random / (float)(1u << 30);
        }
        u = draw(random >> 8);
        wrong += bn_choose_cdf(table, 9, &u) >= 9 || !is_draw(u);
    }
    CHECK(wrong == 0);
}

int main(void) {
    test_probabilities();
    test_count(7);
    test_count(1000);
    test_cumulative_tables();
    test_bad_arguments();
    return check_result();
}
