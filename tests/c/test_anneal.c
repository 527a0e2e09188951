/* SPDX-License-Identifier: Apache-2.0
 * Annealing: permutations, determinism, better than where it started. */
#include "check.h"
#include "masks.h"
#include <math.h>

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

/* The error of a half-plane's pattern after a Gaussian, summed over directions and offsets: what a
 * vector mask is for. Slow and plain. */
static double half_plane_error(const uint32_t *ranks, uint32_t size) {
    const size_t texels = (size_t)size * size;
    const double pi = acos(-1);
    uint32_t *order = malloc(texels * sizeof *order);
    float *values = malloc(texels * sizeof *values);
    double total = 0;
    for (int direction = 0; direction < 12; ++direction) {
        double c = cos(pi * direction / 12 + 0.1), s = sin(pi * direction / 12 + 0.1), error = 0;
        for (size_t i = 0; i < texels; ++i)
            values[i] = (float)(c * ranks[i] + s * ranks[texels + i]);
        /* The mask error of the ranks along the direction is its mean over all offsets. */
        CHECK(bn_ranks_from_values(values, texels, order) == BN_SUCCESS);
        CHECK(bn_mask_error(order, size, size, texels, 1, &error, NULL, NULL) == BN_SUCCESS);
        total += error * error;
    }
    free(order);
    free(values);
    return sqrt(total / 12);
}

static void test_vectors(void) {
    enum { size = 32, texels = size * size };
    static uint32_t ranks[2 * texels];
    fill_white(ranks, texels, 1);
    fill_white(ranks + texels, texels, 2);
    const double white = half_plane_error(ranks, size);
    bn_anneal_options options = bn_anneal_options_default();
    options.start_from_ranks = 1;
    options.sweeps = 150;
    CHECK(bn_anneal(&options, size, size, 2, ranks, 2 * texels) == BN_SUCCESS);
    CHECK(is_permutation(ranks, texels) && is_permutation(ranks + texels, texels));
    CHECK(half_plane_error(ranks, size) < 0.62 * white);
}

/* The weight of a pair of texels: the Gaussians of both blurs over the shorter way around the torus, of
 * 32,000 over all pairs of a texel, rounded; none at exactly half of an extent. */
static double blur_weight(const bn_anneal_options *o, double square) {
    return exp(-square / (4 * o->sigma * o->sigma)) / (o->sigma * o->sigma) +
           o->far_weight * exp(-square / (4 * o->far_sigma * o->far_sigma)) /
               (o->far_sigma * o->far_sigma);
}

static int along(uint32_t from, uint32_t to, uint32_t extent) {
    const int way = abs((int)to - (int)from);
    return way < (int)extent - way ? way : (int)extent - way;
}

/* Where annealing has become cold, none of the exchanges that it tries brings ranks that differ more
 * closer together: with the energy summed anew for each, on tori so small that windows reach around
 * them, even, odd and narrow. Exact. */
static void test_coldest_is_a_minimum(void) {
    enum { MOST = 80, REACH = 7 };
    static const uint32_t extents[][2] = {{8, 8}, {6, 10}, {9, 7}, {4, 16}, {5, 5}};
    static int64_t weights[MOST][MOST];
    for (size_t e = 0; e < sizeof extents / sizeof *extents; ++e) {
        const uint32_t width = extents[e][0], height = extents[e][1], count = width * height;
        uint32_t ranks[MOST];
        bn_anneal_options options = bn_anneal_options_default();
        options.sweeps = 4000;
        options.start_temperature = 1e-2;
        options.end_temperature = 1e-12;
        options.order_ends = 0;
        options.seed = e;
        CHECK(bn_anneal(&options, width, height, 1, ranks, count) == BN_SUCCESS);
        double sum = 0;
        for (int pass = 0; pass < 2; ++pass) {
            for (uint32_t i = 0; i < count; ++i) {
                for (uint32_t j = 0; j < count; ++j) {
                    const int x = along(i % width, j % width, width);
                    const int y = along(i / width, j / width, height);
                    const int in = i != j && 2 * x < (int)width && 2 * y < (int)height &&
                                   x <= REACH && y <= REACH;
                    const double weight = in ? blur_weight(&options, x * x + y * y) : 0;
                    if (pass == 0 && i == 0) sum += weight;
                    if (pass == 1) weights[i][j] = (int64_t)(weight * 32000 / sum + 0.5);
                }
            }
        }
        int better = 0;
        for (uint32_t i = 0; i < count; ++i) {
            for (uint32_t j = 0; j < count; ++j) {
                const int near = along(i % width, j % width, width) <= 3 &&
                                 along(i / width, j / width, height) <= 3;
                const int64_t a = ranks[i], b = ranks[j];
                if (i == j || (!near && llabs(a - b) > count / 32 + 1)) continue;
                int64_t gain = 0;
                for (uint32_t k = 0; k < count; ++k) {
                    if (k == i || k == j) continue;
                    const int64_t r = ranks[k];
                    gain += (weights[i][k] - weights[j][k]) * (llabs(b - r) - llabs(a - r));
                }
                better += gain > 0;
            }
        }
        printf("%ux%u: %d exchanges would be better\n", (unsigned)width, (unsigned)height, better);
        CHECK(better == 0);
    }
}

int main(void) {
    test_coldest_is_a_minimum();
    test_extents();
    test_improves();
    test_vectors();
    return check_result();
}
