/* SPDX-License-Identifier: Apache-2.0
 * Void-and-cluster: what its options do. test_hard_numbers.c has the extents. */
#include "check.h"
#include "masks.h"
#include <math.h>

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
    test_options();
    return check_result();
}
