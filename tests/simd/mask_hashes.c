/* SPDX-License-Identifier: Apache-2.0
 * The generators produce the same masks as the plain C code, whose hashes are listed below, with every
 * instruction set and on every machine. The extents and options reach all vector code. */
#include "../c/masks.h"
#include <limits.h>

/* Void-and-cluster with three values of sigma, annealing with one and two channels, and relaxation. */
enum { VOID_AND_CLUSTER, ANNEAL, ANNEAL_TWO, RELAX, GENERATORS };
static const struct {
    uint32_t extent[3];
    uint32_t hash[GENERATORS];
} cases[] = {
    {{64, 64, 1}, {0x5b46c063, 0xb06d3421, 0x08c658fa, 0xc5c975a0}},
    {{37, 53, 1}, {0x8f11bf3f, 0x6bcb1ac6, 0x7c26cb77, 0x30fd0903}},
    {{128, 40, 1}, {0x06236454, 0xd9e787ab, 0x40cf198a, 0x8c03ea14}},
    {{1000, 1, 1}, {0x489264bb, 0x01dbe6e7, 0x7a4800aa, 0x26839503}},
    {{5, 300, 1}, {0xaecd6072, 0x3951042f, 0xf006808a, 0xd2857850}},
    {{9, 70, 1}, {0x07167d9d, 0x042d55cb, 0xb773a2af, 0x51559c4d}},
    {{200, 136, 1}, {0x794c1f93, 0x8274b0fb, 0x46c414be, 0xee288f6f}},
    {{16, 16, 16}, {0xe6f1d37a}},
    {{21, 10, 19}, {0x6dced94d}},
    {{4, 4, 4}, {0xb9f1a41d}},
    {{65, 2, 33}, {0x1adb0e3d}},
};

static uint32_t hash_of(int generator, const uint32_t extent[3], uint64_t seed) {
    static const double sigmas[] = {0.7, 1.5, 3.1};
    const size_t count = (size_t)extent[0] * extent[1] * extent[2];
    uint32_t *ranks = malloc(2 * count * sizeof *ranks);
    bn_mask mask = bn_mask_u32(ranks, extent[0], extent[1]);
    mask.depth = extent[2];
    uint64_t hash = 0;
    if (generator == VOID_AND_CLUSTER) {
        for (int s = 0; s < 3; ++s) {
            bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
            options.sigma = sigmas[s];
            options.seed = seed;
            options.initial_fraction = s == 1 ? 0.1 : 0.3;
            CHECK(bn_void_and_cluster(&options, &mask, NULL, NULL) == BN_SUCCESS);
            hash = 3 * hash + hash_ranks(ranks, count);
        }
    } else if (generator == RELAX) {
        CHECK(bn_relax(NULL, &mask, NULL, NULL) == BN_SUCCESS);
        hash = hash_ranks(ranks, count);
    } else {
        bn_anneal_options options = bn_anneal_options_default();
        options.sweeps = 3;
        mask.channels = generator == ANNEAL ? 1 : 2;
        CHECK(bn_anneal(&options, &mask, NULL, NULL) == BN_SUCCESS);
        hash = hash_ranks(ranks, mask.channels * count);
    }
    free(ranks);
    return (uint32_t)(hash * 0x9e3779b97f4a7c15u >> 32);
}

/* mask_hashes [COUNT]: tests the masks that have at most COUNT texels. */
int main(int argc, char **argv) {
    const unsigned long most = argc > 1 ? strtoul(argv[1], NULL, 10) : ULONG_MAX;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const uint32_t *extent = cases[i].extent;
        if ((unsigned long)extent[0] * extent[1] * extent[2] > most) continue;
        for (int generator = 0; generator < (extent[2] == 1 ? GENERATORS : 1); ++generator) {
            const uint32_t hash = hash_of(generator, extent, i);
            CHECK(hash == cases[i].hash[generator]);
            if (hash == cases[i].hash[generator]) continue;
            printf("  generator %d, %u x %u x %u: 0x%08x\n", generator, extent[0], extent[1],
                   extent[2], hash);
        }
    }
    return check_result();
}
