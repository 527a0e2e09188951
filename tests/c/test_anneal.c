/* SPDX-License-Identifier: Apache-2.0
 * Annealing: permutations, determinism, better than where it started. tests/python/test_anneal.py has more. */
#include "check.h"
#include "masks.h"

static void test_extents(void) {
    static const uint32_t extents[][2] = {{1, 1},  {2, 1},  {1, 3},   {2, 2}, {5, 4},
                                          {40, 1}, {3, 50}, {16, 16}, {33, 9}};
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        for (uint32_t channels = 1; channels <= 4; ++channels) {
            const uint32_t *e = extents[i];
            const size_t texels = (size_t)e[0] * e[1], count = texels * channels;
            uint32_t *ranks = malloc(count * sizeof *ranks), *again = malloc(count * sizeof *again);
            bn_anneal_options options = bn_anneal_options_default();
            options.sweeps = 5;
            options.sigma = i % 2 ? 0.25 : 4;
            options.far_sigma = 4;
            options.start_temperature = 0.01;
            options.seed = i;
            CHECK(bn_anneal(&options, e[0], e[1], channels, ranks, count) == BN_SUCCESS);
            CHECK(bn_anneal(&options, e[0], e[1], channels, again, count) == BN_SUCCESS);
            CHECK(memcmp(ranks, again, count * sizeof *ranks) == 0);
            for (uint32_t c = 0; c < channels; ++c) {
                CHECK(is_permutation(ranks + c * texels, texels));
            }
            free(ranks);
            free(again);
        }
    }
}

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
    test_extents();
    test_improves();
    return check_result();
}
