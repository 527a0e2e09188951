/* SPDX-License-Identifier: Apache-2.0
 * Numbers at which arithmetic goes wrong: every float that a draw can be, extreme sigmas. */
#include "check.h"
#include "masks.h"
#include <bn/bn_draw.h>
#include <float.h>
#include <math.h>

/* The conversion drops the last 8 bits, so its 2^24 results at both ends of those are all cases of
 * 2^32: each is a multiple of 2^-24, larger than the one before, and below 1. */
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

/* Tiny and odd extents, at the ends of the range of every generator, and measured. */
static void test_sigmas(void) {
    static const uint32_t extents[][2] = {{1, 1}, {1, 2}, {3, 1}, {3, 3}, {17, 31}, {1, 97}};
    for (size_t e = 0; e < sizeof extents / sizeof *extents; ++e) {
        const uint32_t width = extents[e][0], height = extents[e][1];
        const size_t count = (size_t)width * height;
        uint32_t ranks[17 * 31];
        float power[17 * 31];
        for (double sigma = 0.25; sigma <= 16; sigma *= 2) {
            bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
            bn_anneal_options anneal = bn_anneal_options_default();
            v.sigma = sigma;
            CHECK(bn_void_and_cluster(&v, width, height, 1, ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            check_error(ranks, width, height);
            CHECK(bn_relax(NULL, width, height, ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            anneal.sigma = sigma < 4 ? sigma : 4;
            anneal.far_sigma = 4;
            anneal.sweeps = 2;
            CHECK(bn_anneal(&anneal, width, height, 1, ranks, count) == BN_SUCCESS);
            CHECK(is_permutation(ranks, count));
            CHECK(bn_power_spectrum(ranks, width, height, count, power, NULL, NULL) == BN_SUCCESS);
            for (size_t i = 0; i < count; ++i) CHECK(power[i] >= 0 && power[i] <= FLT_MAX);
        }
    }
}

int main(void) {
    test_every_float();
    test_sigmas();
    return check_result();
}
