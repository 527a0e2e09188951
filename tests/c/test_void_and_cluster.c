/* SPDX-License-Identifier: Apache-2.0
 * Void-and-cluster: permutations at any extents, determinism. */
#include "check.h"
#include "masks.h"
#include <math.h>

static void test_extents(void) {
    static const uint32_t extents[][3] = {
        {1, 1, 1},  {2, 1, 1},   {1, 3, 1},   {1, 1, 5}, {2, 2, 2},    {7, 1, 1},  {100, 1, 1},
        {1, 65, 1}, {1, 1, 129}, {13, 5, 1},  {8, 8, 1}, {9, 17, 1},   {3, 50, 1}, {1, 12, 13},
        {64, 2, 1}, {31, 33, 1}, {70, 66, 1}, {5, 6, 7}, {16, 16, 16}, {20, 3, 11}};
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        const uint32_t *e = extents[i];
        size_t count = (size_t)e[0] * e[1] * e[2];
        uint32_t *ranks = malloc(count * sizeof *ranks), *again = malloc(count * sizeof *again);
        static const double sigmas[] = {0.25, 1.5, 4.0, 16.0};
        for (size_t s = 0; s < (count <= 256 ? 4 : 2); ++s) {
            bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
            options.sigma = sigmas[s];
            options.seed = i;
            CHECK(bn_void_and_cluster(&options, e[0], e[1], e[2], ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            CHECK(bn_void_and_cluster(&options, e[0], e[1], e[2], again, count) == BN_SUCCESS);
            CHECK(memcmp(ranks, again, count * sizeof *ranks) == 0);
        }
        free(ranks);
        free(again);
    }
}

static void test_options(void) {
    uint32_t first[1024], second[1024];
    CHECK(bn_void_and_cluster(NULL, 32, 32, 1, first, 1024) == BN_SUCCESS);
    bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
    CHECK(bn_void_and_cluster(&options, 32, 32, 1, second, 1024) == BN_SUCCESS);
    CHECK(memcmp(first, second, sizeof first) == 0);
    options.seed = 1;
    CHECK(bn_void_and_cluster(&options, 32, 32, 1, second, 1024) == BN_SUCCESS);
    CHECK(memcmp(first, second, sizeof first) != 0);
    /* Not the ends alone: a seed decides ties everywhere, and the whole pattern with them. Of
     * independent masks, one of a thousand texels has the same rank. */
    int same = 0;
    for (int i = 0; i < 1024; ++i) same += first[i] == second[i];
    CHECK(same < 12);
    static const double fractions[] = {1e-9, 0.05, 0.3, 0.5};
    for (size_t i = 0; i < 4; ++i) {
        options.initial_fraction = fractions[i];
        CHECK(bn_void_and_cluster(&options, 32, 32, 1, second, 1024) == BN_SUCCESS);
        CHECK(is_permutation(second, 1024));
        CHECK(error_of(second, 32, 32, 1.5) < 0.018);
    }
}

int main(void) {
    test_extents();
    test_options();
    return check_result();
}
