/* SPDX-License-Identifier: Apache-2.0
 * Annealing: better than where it started. test_hard_numbers.c and tests/python/test_anneal.py have more. */
#include "check.h"
#include "masks.h"

/* Fixed seeds, exact integers: no false alarms. */
static void test_improves(void) {
    enum { size = 32 };
    static uint32_t start[size * size], ranks[size * size], white[size * size];
    CHECK(bn_void_and_cluster(NULL, size, size, 1, start, size * size) == BN_SUCCESS);
    memcpy(ranks, start, sizeof ranks);
    bn_anneal_options options = bn_anneal_options_default();
    options.start_from_ranks = 1;
    options.sweeps = 3000;
    CHECK(bn_anneal(&options, size, size, 1, ranks, size * size) == BN_SUCCESS);
    CHECK(is_permutation(ranks, size * size));
    CHECK(error_of(ranks, size, size, 1) < 0.037);
    CHECK(error_of(ranks, size, size, 1) < 0.985 * error_of(start, size, size, 1));
    CHECK(error_of(ranks, size, size, 1.5) < 0.0165);

    /* From white noise too, and the weight of the far blur trades one error for the other. */
    fill_white(white, size * size, 3);
    memcpy(ranks, white, sizeof ranks);
    options.start_temperature = 1e-2;
    options.far_weight = 0;
    CHECK(bn_anneal(&options, size, size, 1, ranks, size * size) == BN_SUCCESS);
    const double near_only = error_of(ranks, size, size, 1.5);
    CHECK(error_of(ranks, size, size, 1) < 0.038);
    memcpy(ranks, white, sizeof ranks);
    options.far_weight = 4;
    CHECK(bn_anneal(&options, size, size, 1, ranks, size * size) == BN_SUCCESS);
    CHECK(error_of(ranks, size, size, 1.5) < near_only);
}

int main(void) {
    test_improves();
    return check_result();
}
