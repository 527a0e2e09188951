/* SPDX-License-Identifier: Apache-2.0
 * Relaxation does not depend on the number of threads and has no fixed pattern. test_hard_numbers.c tests
 * extents, and tests/python/test_relax_learned.py tests the formula. */
#include "check.h"
#include "masks.h"
#include <math.h>

/* The height is prime, so threads process different numbers of rows. */
static void test_threads(void) {
    enum { width = 72, height = 307, count = width * height };
    uint32_t *ranks = malloc(count * sizeof *ranks);
    const bn_mask mask = bn_mask_u32(ranks, width, height);
    uint64_t expected = 0;
    for (uint32_t threads = 1; threads <= 5; ++threads) {
        bn_relax_options options = bn_relax_options_default();
        options.threads = threads;
        CHECK(bn_relax(&options, &mask, NULL, NULL) == BN_SUCCESS);
        if (threads == 1) expected = hash_ranks(ranks, count);
        CHECK(hash_ranks(ranks, count) == expected);
    }
    free(ranks);
}

/* Over many seeds, each texel's ranks are as uniform as independent random ranks. The limit of 30% is six
 * standard deviations of a chi-squared statistic with 1,024 terms. */
static void test_no_fixed_pattern(void) {
    enum { size = 32, count = size * size, seeds = 100 };
    static uint32_t ranks[count];
    static double sum[count];
    const bn_mask mask = bn_mask_u32(ranks, size, size);
    bn_relax_options options = bn_relax_options_default();
    for (options.seed = 0; options.seed < seeds; ++options.seed) {
        CHECK(bn_relax(&options, &mask, NULL, NULL) == BN_SUCCESS);
        for (int i = 0; i < count; ++i) sum[i] += (ranks[i] + 0.5) / count - 0.5;
    }
    double square = 0;
    for (int i = 0; i < count; ++i) square += sum[i] * sum[i];
    CHECK(fabs(square * 12 / seeds / count - 1) < 0.3);
}

int main(void) {
    test_threads();
    test_no_fixed_pattern();
    return check_result();
}
