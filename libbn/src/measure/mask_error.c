/* SPDX-License-Identifier: Apache-2.0
 * The dithering error of a mask, computed exactly with the discrete Fourier transform.
 *
 * By Parseval's theorem, the squared error of one threshold is the sum of its pattern's power
 * spectrum times the squared transfer function, so no inverse transform is needed. Two thresholds
 * share one complex transform: because the transfer function is even, the cross terms of z = a + i b
 * cancel in the sum. Costs 32 transforms of width x height, and 32 bytes per texel. */
#include "base/check.h"
#include "base/memory.h"
#include "measure/fft.h"
#include <bn/bn.h>
#include <float.h>
#include <math.h>

enum { BN_ERROR_THRESHOLDS = 64 };

/* The squared transfer function exp(-4 pi^2 sigma^2 f^2) along one axis. */
static void fill_transfer(double *transfer, uint32_t extent, double sigma) {
    for (uint32_t k = 0; k < extent; ++k) {
        double f = (double)(k <= extent / 2 ? k : extent - k) / extent;
        double a = 2 * 3.14159265358979323846 * sigma * f;
        /* A huge sigma can make `a` infinite, and 0 times infinity is NaN. */
        transfer[k] = k == 0 ? 1 : exp(-a * a);
    }
}

/* [m < (i + 0.5) / 64] for m = (rank + 0.5) / count, computed in integers, below 2^39. */
static double below(uint32_t rank, uint32_t i, size_t count) {
    return (2 * (uint64_t)rank + 1) * BN_ERROR_THRESHOLDS < (2 * (uint64_t)i + 1) * count;
}

bn_result bn_mask_error(const bn_mask *mask, double sigma, double *error, bn_progress progress,
                        void *progress_user) {
    if (error == NULL || !bn_in_range(sigma, 0, DBL_MAX)) return BN_ERROR_INVALID_ARGUMENT;
    bn_result result = bn_check_mask(mask);
    if (result != BN_SUCCESS) return result;
    const uint32_t width = mask->width, height = mask->height;
    const size_t count = (size_t)width * height;

    result = BN_ERROR_OUT_OF_MEMORY;
    bn_fft fft;
    const int good = bn_fft_create(&fft, width, height);
    double *transfer_x = bn_allocate(width, sizeof *transfer_x);
    double *transfer_y = bn_allocate(height, sizeof *transfer_y);
    if (!good || transfer_x == NULL || transfer_y == NULL) goto done;
    double *re = fft.re, *im = fft.im;
    fill_transfer(transfer_x, width, sigma);
    fill_transfer(transfer_y, height, sigma);

    double total = 0, n = (double)count;
    for (uint32_t i = 0; i < BN_ERROR_THRESHOLDS; i += 2) {
        for (size_t p = 0; p < count; ++p) {
            const uint32_t rank = bn_mask_rank(mask, p);
            re[p] = below(rank, i, count);
            im[p] = below(rank, i + 1, count);
        }
        result = BN_ERROR_CANCELLED;
        if (!bn_fft_run(&fft, progress, progress_user, (double)i / BN_ERROR_THRESHOLDS,
                        2.0 / BN_ERROR_THRESHOLDS)) {
            goto done;
        }
        /* At frequency 0, the error is the pattern's mean minus the threshold. */
        double first = re[0] / n - (i + 0.5) / BN_ERROR_THRESHOLDS;
        double second = im[0] / n - (i + 1.5) / BN_ERROR_THRESHOLDS;
        re[0] = im[0] = 0;
        double sum = 0;
        for (uint32_t y = 0; y < height; ++y) {
            const double *r = re + (size_t)y * width, *s = im + (size_t)y * width;
            double row = 0;
            for (uint32_t x = 0; x < width; ++x) {
                row += (r[x] * r[x] + s[x] * s[x]) * transfer_x[x];
            }
            sum += row * transfer_y[y];
        }
        total += sum / n / n + first * first + second * second;
    }
    *error = sqrt(total / BN_ERROR_THRESHOLDS);
    result = BN_SUCCESS;
done:
    bn_fft_destroy(&fft);
    bn_free(transfer_x);
    bn_free(transfer_y);
    return result;
}
