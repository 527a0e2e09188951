/* SPDX-License-Identifier: Apache-2.0
 * A mask's power spectrum: one transform of the ranks, minus their mean, along columns and then along rows,
 * in O(n log n) time and 32 bytes per texel. By Parseval's theorem, the sum of |DFT|^2 over all frequencies is
 * n times the sum of squares, so the mean power is 1. */
#include "base/check.h"
#include "measure/fft.h"
#include <bn/bn.h>

bn_result bn_power_spectrum(const bn_mask *mask, float *power, size_t count, bn_progress progress,
                            void *progress_user) {
    if (power == NULL || mask == NULL) return BN_ERROR_INVALID_ARGUMENT;
    const uint32_t width = mask->width, height = mask->height;
    bn_result result = bn_check_extents(width, height, 1, 1, count);
    if (result == BN_SUCCESS) result = bn_check_mask(mask);
    if (result != BN_SUCCESS) return result;

    result = BN_ERROR_OUT_OF_MEMORY;
    bn_fft fft;
    if (!bn_fft_create(&fft, width, height)) goto done;
    double *re = fft.re, *im = fft.im;
    const double n = (double)count;
    for (size_t i = 0; i < count; ++i) {
        re[i] = bn_mask_rank(mask, i) - (n - 1) / 2;
        im[i] = 0;
    }
    result = BN_ERROR_CANCELLED;
    if (!bn_fft_run(&fft, progress, progress_user, 0, 1)) goto done;
    /* The sum of squared deviations of 0 .. n - 1 from their mean. */
    const double total = n * (n * n - 1) / 12;
    for (size_t i = 0; i < count; ++i) {
        power[i] = total > 0 ? (float)((re[i] * re[i] + im[i] * im[i]) / total) : 0;
    }
    power[0] = 0;
    result = BN_SUCCESS;
done:
    bn_fft_destroy(&fft);
    return result;
}
