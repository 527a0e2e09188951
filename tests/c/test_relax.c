/* SPDX-License-Identifier: Apache-2.0
 * Relaxation, by the learned schedule and by given steps: permutations at any extents, the same
 * bits on any number of threads, quality, no fixed pattern, refining other masks, cancelling, bad
 * input. */
#include "check.h"
#include "masks.h"
#include <math.h>

static void test_extents(void) {
    static const uint32_t extents[][2] = {{1, 1},  {2, 1},   {1, 3},   {2, 2},   {5, 4},
                                          {40, 1}, {3, 500}, {700, 2}, {16, 16}, {33, 95}};
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        const size_t count = (size_t)extents[i][0] * extents[i][1];
        uint32_t *ranks = malloc(count * sizeof *ranks);
        static const double sigmas[] = {0.25, 0.92, 2.5};
        for (int s = 0; s < 3; ++s) {
            bn_relax_options options = bn_relax_options_default();
            options.sigma = sigmas[s];
            options.start_step = 8;
            options.start_softness = 0.49;
            options.steps = s == 0 ? 1 : 12;
            CHECK(bn_relax(&options, extents[i][0], extents[i][1], ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            options.steps = 0;
            CHECK(bn_relax(&options, extents[i][0], extents[i][1], ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
        }
        free(ranks);
    }
}

/* The height is prime, so that no number of threads gets equal shares of rows. */
static void test_threads(void) {
    enum { width = 200, height = 307, count = width * height };
    uint32_t *ranks = malloc(count * sizeof *ranks);
    for (uint32_t steps = 0; steps <= 10; steps += 10) {
        uint64_t expected = 0;
        for (uint32_t threads = 1; threads <= 5; ++threads) {
            bn_relax_options options = bn_relax_options_default();
            options.threads = threads;
            options.steps = steps;
            CHECK(bn_relax(&options, width, height, ranks, count) == BN_SUCCESS);
            if (threads == 1) expected = hash_ranks(ranks, count);
            CHECK(hash_ranks(ranks, count) == expected);
        }
    }
    free(ranks);
}

/* From the same mask, the seed decides the first and the last ranks alone, which are ordered
 * afresh. */
static void test_ends_have_the_seed(void) {
    enum { size = 64, count = size * size };
    static uint32_t start[count], first[count], ranks[count];
    CHECK(bn_builtin_mask_copy(size, start, count) == BN_SUCCESS);
    for (uint64_t seed = 0; seed < 3; ++seed) {
        bn_relax_options options = bn_relax_options_default();
        options.start_from_ranks = 1;
        options.start_step = options.end_step = 0.05;
        options.start_softness = options.end_softness = 0.01;
        options.steps = 2;
        options.seed = seed;
        memcpy(ranks, start, sizeof ranks);
        CHECK(bn_relax(&options, size, size, ranks, count) == BN_SUCCESS);
        if (seed == 0) memcpy(first, ranks, sizeof first);
        int low = 0, middle = 0, high = 0;
        for (int i = 0; i < count; ++i) {
            if (ranks[i] == first[i]) continue;
            if (first[i] < count / 4)
                ++low;
            else if (first[i] >= count - count / 4)
                ++high;
            else
                ++middle;
        }
        CHECK(middle == 0);
        CHECK(seed == 0 || (low > 0 && high > 0));
    }
}

/* Over seeds, the ranks of a texel are as uniform as independent ones. Of a chi-squared statistic
 * of 1,024 terms, 30 % is six deviations. */
static void test_no_fixed_pattern(void) {
    enum { size = 32, count = size * size, seeds = 100 };
    static uint32_t ranks[count];
    static double sum[count];
    bn_relax_options options = bn_relax_options_default();
    for (options.seed = 0; options.seed < seeds; ++options.seed) {
        CHECK(bn_relax(&options, size, size, ranks, count) == BN_SUCCESS);
        for (int i = 0; i < count; ++i) sum[i] += (ranks[i] + 0.5) / count - 0.5;
    }
    double square = 0;
    for (int i = 0; i < count; ++i) square += sum[i] * sum[i];
    CHECK(fabs(square * 12 / seeds / count - 1) < 0.3);
}

static void test_quality(void) {
    enum { size = 64, count = size * size };
    static uint32_t ranks[count], other[count];
    for (uint64_t seed = 0; seed < 4; ++seed) {
        bn_relax_options options = bn_relax_options_default();
        options.seed = seed;
        CHECK(bn_relax(&options, size, size, ranks, count) == BN_SUCCESS);
        CHECK(error_of(ranks, size, size, 1) <= 0.040);
        CHECK(error_of(ranks, size, size, 1.5) <= 0.019);
        CHECK(seed == 0 || memcmp(ranks, other, sizeof ranks) != 0);
        memcpy(other, ranks, sizeof ranks);
        options.steps = 64;
        CHECK(bn_relax(&options, size, size, ranks, count) == BN_SUCCESS);
        CHECK(error_of(ranks, size, size, 1) <= 0.042);
        CHECK(error_of(ranks, size, size, 1.5) <= 0.019);
    }
    /* White noise after a few small steps is better than white noise. */
    fill_white(ranks, count, 1);
    const double before = error_of(ranks, size, size, 1);
    bn_relax_options options = bn_relax_options_default();
    options.start_from_ranks = 1;
    options.start_step = 0.3;
    options.start_softness = 0.05;
    options.steps = 16;
    CHECK(bn_relax(&options, size, size, ranks, count) == BN_SUCCESS);
    CHECK(is_permutation(ranks, count) && error_of(ranks, size, size, 1) < 0.8 * before);
}

static int32_t cancel_late(void *user, double fraction) {
    ++*(int *)user;
    return fraction > 0.5;
}

static void test_bad_input(void) {
    uint32_t ranks[16];
    for (uint32_t i = 0; i < 16; ++i) ranks[i] = 7;
    bn_relax_options options = bn_relax_options_default();
    static const double bad[] = {0, 9};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        double *const fields[] = {&options.sigma, &options.start_step, &options.end_step,
                                  &options.start_softness, &options.end_softness};
        for (size_t f = 0; f < sizeof fields / sizeof *fields; ++f) {
            const double kept = *fields[f];
            *fields[f] = bad[i];
            CHECK(bn_relax(&options, 4, 4, ranks, 16) == BN_ERROR_INVALID_ARGUMENT);
            *fields[f] = kept;
        }
    }
    options.start_from_ranks = 1;
    CHECK(bn_relax(&options, 4, 4, ranks, 16) == BN_ERROR_INVALID_ARGUMENT);
    options.steps = 10;
    CHECK(bn_relax(&options, 4, 4, ranks, 16) == BN_ERROR_BAD_DATA);
    options.start_from_ranks = 0;
    int calls = 0;
    options.progress = cancel_late;
    options.progress_user = &calls;
    CHECK(bn_relax(&options, 4, 4, ranks, 16) == BN_ERROR_CANCELLED);
    CHECK(calls == 7);
    /* On several threads, all of them must stop. */
    enum { width = 256, height = 128, count = width * height };
    uint32_t *large = malloc(count * sizeof *large);
    memset(large, 7, count * sizeof *large);
    options.steps = 0;
    options.threads = 3;
    for (int i = 0; i < 20; ++i) {
        CHECK(bn_relax(&options, width, height, large, count) == BN_ERROR_CANCELLED);
    }
    for (size_t i = 0; i < count; ++i) CHECK(large[i] == 0x07070707);
    free(large);
    for (uint32_t i = 0; i < 16; ++i) CHECK(ranks[i] == 7);
}

/* The torus has no first row: ranks that are moved over it before are moved after. The values of
 * 2-D masks this small are all different, so nothing is decided by position; ordering the ends is. */
static void test_moves_with_the_torus(void) {
    static const uint32_t extents[][2] = {{64, 48}, {40, 96}, {33, 65}};
    enum { MOST = 64 * 96 };
    static uint32_t ranks[MOST], moved[MOST], start[MOST];
    for (size_t e = 0; e < 3; ++e) {
        const uint32_t width = extents[e][0], height = extents[e][1], count = width * height;
        fill_white(start, count, (uint32_t)e + 5u);
        for (uint32_t shift = 1; shift < 40; shift += 19) {
            bn_relax_options options = bn_relax_options_default();
            uint32_t different = 0;
            options.start_from_ranks = 1;
            options.steps = 6;
            for (uint32_t i = 0; i < count; ++i) {
                const uint32_t x = (i % width + 3 * shift) % width,
                               y = (i / width + shift) % height;
                ranks[i] = start[i];
                moved[y * width + x] = start[i];
            }
            CHECK(bn_relax(&options, width, height, ranks, count) == BN_SUCCESS);
            CHECK(bn_relax(&options, width, height, moved, count) == BN_SUCCESS);
            for (uint32_t i = 0; i < count; ++i) {
                const uint32_t x = (i % width + 3 * shift) % width,
                               y = (i / width + shift) % height;
                const uint32_t rank = ranks[i], other = moved[y * width + x];
                different += rank != other && rank > count / 5 && rank < count - count / 5;
            }
            printf("%ux%u moved by %u: %u middle ranks differ\n", (unsigned)width, (unsigned)height,
                   (unsigned)shift, (unsigned)different);
            CHECK(different <= 16);
        }
    }
}

int main(void) {
    test_moves_with_the_torus();
    test_extents();
    test_threads();
    test_ends_have_the_seed();
    test_quality();
    test_no_fixed_pattern();
    test_bad_input();
    return check_result();
}
