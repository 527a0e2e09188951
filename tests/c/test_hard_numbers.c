/* SPDX-License-Identifier: Apache-2.0
 * Hard cases for the arithmetic: every float a draw can return, and extreme extents and sigmas. */
#include "check.h"
#include "masks.h"
#include <bn/bn_draw.h>
#include <float.h>
#include <math.h>

/* The conversion drops the lowest 8 bits, so all 2^32 inputs are covered by testing each result with these
 * bits clear and set. The results are the multiples of 2^-24 in [0, 1), in ascending order. */
static void test_every_float(void) {
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < 1u << 24; ++i) {
        const float low = bn_draw_float(i << 8), high = bn_draw_float(i << 8 | 255u);
        wrong += (double)low != (double)i / 16777216.0 || high != low;
    }
    CHECK(wrong == 0);
    CHECK(bn_draw_float(0) == 0 && bn_draw_float(255) == 0 && bn_draw_float(256) == 0x1p-24f);
    CHECK(bn_draw_float(UINT32_MAX) == 1 - 0x1p-24f);
}

static void check_error(const uint32_t *ranks, uint32_t width, uint32_t height) {
    static const double sigmas[] = {0, DBL_TRUE_MIN, 0.25, 16, 1e6, 1e150, DBL_MAX};
    double before = INFINITY;
    for (size_t i = 0; i < sizeof sigmas / sizeof *sigmas; ++i) {
        const double error = error_of(ranks, width, height, sigmas[i]);
        CHECK(error >= 0 && error <= before * (1 + 1e-12));
        before = error;
    }
}

enum { MOST = 70 * 66 };

/* Makes and measures masks with tiny, narrow and odd extents, at the limits of the generators' options. */
static void test_extents(void) {
    static const uint32_t extents[][3] = {
        {1, 1, 1},  {2, 1, 1},   {1, 3, 1},   {1, 1, 5}, {2, 2, 2},    {7, 1, 1},   {100, 1, 1},
        {1, 65, 1}, {1, 1, 129}, {13, 5, 1},  {8, 8, 1}, {9, 17, 1},   {3, 50, 1},  {1, 12, 13},
        {64, 2, 1}, {31, 33, 1}, {70, 66, 1}, {5, 6, 7}, {16, 16, 16}, {20, 3, 11}, {3, 500, 1}};
    static const double sigmas[] = {0.25, 1.5, 4, 16};
    static uint32_t ranks[4 * MOST];
    static float power[MOST];
    for (size_t e = 0; e < sizeof extents / sizeof *extents; ++e) {
        const uint32_t width = extents[e][0], height = extents[e][1], depth = extents[e][2];
        const size_t count = (size_t)width * height * depth;
        const bn_mask mask = bn_mask_u32(ranks, width, height);
        bn_mask volume = mask;
        volume.depth = depth;
        for (int s = 0; s < (count <= 256 ? 4 : 2); ++s) {
            bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
            v.sigma = sigmas[s];
            if (e % 3 > 0) v.initial_fraction = e % 3 == 1 ? 1e-9 : 0.5;
            v.seed = e;
            CHECK(bn_void_and_cluster(&v, &volume, NULL, NULL) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            if (depth > 1) continue;
            if (s == 0) check_error(ranks, width, height);
            CHECK(bn_power_spectrum(&mask, power, count, NULL, NULL) == BN_SUCCESS);
            for (size_t i = 0; i < count; ++i) CHECK(power[i] >= 0 && power[i] <= FLT_MAX);
            for (uint32_t channels = 1; channels <= (count <= 256 ? 4 : 1 + (uint32_t)s);
                 ++channels) {
                bn_anneal_options anneal = bn_anneal_options_default();
                anneal.sweeps = 2;
                anneal.sigma = s < 3 ? sigmas[s] : 4;
                anneal.far_sigma = 4;
                anneal.start_temperature = 0.01;
                anneal.seed = e;
                CHECK(anneal_channels(&anneal, width, height, channels, ranks) == BN_SUCCESS);
                for (uint32_t c = 0; c < channels; ++c)
                    CHECK(is_permutation(ranks + c * count, count));
            }
        }
        if (depth > 1) continue;
        CHECK(bn_relax(NULL, &mask, NULL, NULL) == BN_SUCCESS && is_permutation(ranks, count));
    }
}

int main(void) {
    test_every_float();
    test_extents();
    return check_result();
}
