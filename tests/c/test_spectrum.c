/* SPDX-License-Identifier: Apache-2.0
 * The power spectrum against a plain discrete Fourier transform, its sums, and bad input. */
#include "check.h"
#include "masks.h"
#include <math.h>

static void test_against_definition(void) {
    static const uint32_t extents[][2] = {{2, 1}, {1, 5}, {8, 8}, {7, 11}, {12, 10}, {16, 9}};
    const double pi = acos(-1);
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        uint32_t width = extents[i][0], height = extents[i][1], ranks[160];
        size_t count = (size_t)width * height;
        float power[160];
        double mean = (double)(count - 1) / 2, total = 0, sum = 0;
        fill_white(ranks, count, (uint32_t)i + 1);
        for (size_t p = 0; p < count; ++p) total += (ranks[p] - mean) * (ranks[p] - mean);
        CHECK(bn_power_spectrum(ranks, width, height, count, power, NULL, NULL) == BN_SUCCESS);
        for (uint32_t v = 0; v < height; ++v) {
            for (uint32_t u = 0; u < width; ++u) {
                double re = 0, im = 0;
                for (uint32_t y = 0; y < height; ++y) {
                    for (uint32_t x = 0; x < width; ++x) {
                        double angle = -2 * pi * ((double)u * x / width + (double)v * y / height);
                        re += (ranks[y * width + x] - mean) * cos(angle);
                        im += (ranks[y * width + x] - mean) * sin(angle);
                    }
                }
                double expected = (re * re + im * im) / total;
                CHECK(fabs(power[v * width + u] - expected) < 1e-6 * (1 + expected));
                sum += power[v * width + u];
            }
        }
        CHECK(power[0] == 0);
        CHECK(fabs(sum / (double)count - 1) < 1e-5);
    }
}

static void test_bad_input(void) {
    uint32_t ranks[6] = {0, 1, 2, 3, 4, 5};
    float power[6] = {-7};
    CHECK(bn_power_spectrum(ranks, 3, 2, 6, NULL, NULL, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_power_spectrum(ranks, 3, 2, 7, power, NULL, NULL) == BN_ERROR_SIZE_MISMATCH);
    ranks[0] = 5;
    CHECK(bn_power_spectrum(ranks, 3, 2, 6, power, NULL, NULL) == BN_ERROR_BAD_DATA);
    CHECK(power[0] == -7);
    ranks[0] = 0;
    CHECK(bn_power_spectrum(ranks, 1, 1, 1, power, NULL, NULL) == BN_SUCCESS && power[0] == 0);
}

int main(void) {
    test_against_definition();
    test_bad_input();
    return check_result();
}
