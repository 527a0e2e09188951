/* SPDX-License-Identifier: Apache-2.0
 * The mask error against a plain discrete Fourier transform, and bad input. */
#include "check.h"
#include "masks.h"
#include <math.h>

/* The definition, word by word: the transfer function on the centred pattern, by the plain sum. */
static double slow_error(const uint32_t *ranks, uint32_t width, uint32_t height, double sigma) {
    const double pi = acos(-1);
    size_t count = (size_t)width * height;
    double total = 0;
    for (int i = 0; i < 64; ++i) {
        double t = (i + 0.5) / 64, sum = 0;
        for (uint32_t v = 0; v < height; ++v) {
            for (uint32_t u = 0; u < width; ++u) {
                double re = 0, im = 0;
                for (uint32_t y = 0; y < height; ++y) {
                    for (uint32_t x = 0; x < width; ++x) {
                        double m = (ranks[y * width + x] + 0.5) / (double)count;
                        double angle = -2 * pi * ((double)u * x / width + (double)v * y / height);
                        double centred = (m < t ? 1 : 0) - t;
                        re += centred * cos(angle);
                        im += centred * sin(angle);
                    }
                }
                double fx = fmin(u, width - u) / width, fy = fmin(v, height - v) / height;
                double transfer = exp(-2 * pi * pi * sigma * sigma * (fx * fx + fy * fy));
                sum += (re * re + im * im) * transfer * transfer;
            }
        }
        total += sum / (double)count / (double)count;
    }
    return sqrt(total / 64);
}

static void test_against_definition(void) {
    static const uint32_t extents[][2] = {{1, 1}, {1, 7},  {8, 1},   {5, 3},
                                          {8, 8}, {7, 11}, {12, 10}, {16, 9}};
    for (size_t i = 0; i < sizeof extents / sizeof *extents; ++i) {
        uint32_t width = extents[i][0], height = extents[i][1], ranks[160];
        size_t count = (size_t)width * height;
        fill_white(ranks, count, (uint32_t)i);
        static const double sigmas[] = {0, 0.75, 1.5};
        for (size_t s = 0; s < 3; ++s) {
            const double error = error_of(ranks, width, height, sigmas[s]);
            CHECK(fabs(error - slow_error(ranks, width, height, sigmas[s])) < 1e-9);
        }
    }
}

static void test_bad_input(void) {
    uint32_t ranks[6] = {0, 1, 2, 3, 4, 5};
    double error = -7;
    CHECK(bn_mask_error(ranks, 3, 2, 6, 1, NULL, NULL, NULL) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_mask_error(ranks, 3, 2, 5, 1, &error, NULL, NULL) == BN_ERROR_SIZE_MISMATCH);
    ranks[3] = 6;
    CHECK(bn_mask_error(ranks, 3, 2, 6, 1, &error, NULL, NULL) == BN_ERROR_BAD_DATA);
    CHECK(error == -7);
}

int main(void) {
    test_against_definition();
    test_bad_input();
    return check_result();
}
