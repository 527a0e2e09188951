/* SPDX-License-Identifier: Apache-2.0
 * In a program that is compiled with -ffast-math (choose_fast_math.c), choices and inline draws have the
 * bits that they have elsewhere, for NaN, infinities and numbers out of range too. */
#include "check.h"
#include "choose_fast_math.h"
#include <math.h>
#include <string.h>

static uint32_t state = 1;

static uint32_t random_u32(void) {
    state = state * 1664525u + 1013904223u;
    return state ^ state >> 16;
}

/* A draw, a special number or any bits at all. */
static float random_float(void) {
    static const float special[] = {NAN, INFINITY, -INFINITY, 0.0f, -0.0f, 1.0f, -1.0f, 1e-40f};
    const uint32_t choice = random_u32() >> 29, bits = random_u32();
    float value;
    if (choice < 4) return (float)(bits >> 8) * (1.0f / 16777216.0f);
    if (choice < 6) return special[bits >> 29];
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void test_choices(void) {
    int wrong = 0;
    for (int i = 0; i < 200000; ++i) {
        const float probability = random_float(), u = random_float();
        const float cdf[4] = {random_float(), random_float(), random_float(), random_float()};
        const uint32_t count = random_u32() >> random_u32() % 32;
        float fast = u, own = u;
        wrong += fast_choose(probability, &fast) != bn_choose(probability, &own) || fast != own;
        fast = own = u;
        wrong += fast_choose_u32(count, &fast) != bn_choose_u32(count, &own) || fast != own;
        fast = own = u;
        wrong += fast_choose_cdf(cdf, 4, &fast) != bn_choose_cdf(cdf, 4, &own) || fast != own;
    }
    CHECK(wrong == 0);
}

static void test_draws(void) {
    const bn_sampler sampler = bn_sampler_make(BN_SAMPLER_BLUE, 0);
    int wrong = 0;
    for (int i = 0; i < 100000; ++i) {
        const int32_t x = (int32_t)random_u32(), y = (int32_t)random_u32();
        const uint32_t index = random_u32() >> random_u32() % 32, domain = random_u32();
        float fast[4], own[4];
        fast_draw_4d(&sampler, x, y, index, domain, fast);
        bn_sample_4d(&sampler, x, y, index, domain, own);
        wrong += memcmp(fast, own, sizeof own) != 0;
    }
    CHECK(wrong == 0);
}

int main(void) {
    test_choices();
    test_draws();
    return check_result();
}
