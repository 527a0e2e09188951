/* SPDX-License-Identifier: Apache-2.0
 * Prints hashes of the masks of every classical generator, at extents and with options that reach
 * all vector code. The text must be the same with every instruction set, on every machine. */
#include "../c/masks.h"
#include <stdio.h>

static int failed;

static void print(const char *name, uint32_t width, uint32_t height, uint32_t depth, double sigma,
                  bn_result result, const uint32_t *ranks, size_t count) {
    if (result != BN_SUCCESS) failed = 1;
    printf("%s %ux%ux%u sigma %g: %016llx\n", name, width, height, depth, sigma,
           (unsigned long long)(result == BN_SUCCESS ? hash_ranks(ranks, count) : 0));
}

int main(void) {
    static const uint32_t extents[][3] = {{64, 64, 1},  {37, 53, 1}, {128, 40, 1},  {1000, 1, 1},
                                          {5, 300, 1},  {9, 70, 1},  {200, 136, 1}, {16, 16, 16},
                                          {21, 10, 19}, {4, 4, 4},   {65, 2, 33}};
    static const double sigmas[] = {0.7, 1.5, 3.1};
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        const uint32_t *e = extents[i];
        const size_t count = (size_t)e[0] * e[1] * e[2];
        uint32_t *ranks = malloc(2 * count * sizeof *ranks);
        bn_mask mask = bn_mask_u32(ranks, e[0], e[1]);
        mask.depth = e[2];
        for (int s = 0; s < 3; ++s) {
            bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
            options.sigma = sigmas[s];
            options.seed = i;
            options.initial_fraction = s == 1 ? 0.1 : 0.3;
            print("void-and-cluster", e[0], e[1], e[2], sigmas[s],
                  bn_void_and_cluster(&options, &mask, NULL, NULL), ranks, count);
        }
        if (e[2] == 1) {
            bn_anneal_options anneal = bn_anneal_options_default();
            anneal.sweeps = 3;
            for (uint32_t channels = 1; channels <= 2; ++channels) {
                print(channels == 1 ? "anneal" : "anneal two channels", e[0], e[1], 1, anneal.sigma,
                      anneal_channels(&anneal, e[0], e[1], channels, ranks), ranks,
                      channels * count);
            }
            print("relax", e[0], e[1], 1, 0, bn_relax(NULL, &mask, NULL, NULL), ranks, count);
        }
        free(ranks);
    }
    return failed;
}
