/* SPDX-License-Identifier: Apache-2.0
 * A two-dimensional complex FFT of any extents, in double precision. Its caller fills in an image, transforms it
 * in place as often as it likes, and reads the coefficients. */
#ifndef BN_FFT_H
#define BN_FFT_H

#include <bn/bn.h>

typedef struct bn_fft_axis bn_fft_axis;

/* One image and the scratch memory of its transform: 32 bytes per texel. Only one thread at a time may use it. */
typedef struct bn_fft {
    bn_fft_axis *axis[2]; /* along columns, then along rows */
    uint32_t width, height;
    double *re, *im; /* [height][width] */
} bn_fft;

/* Prepares transforms of width x height texels, both at least 1. Returns 0 if out of memory; call bn_fft_destroy()
 * in any case. */
int bn_fft_create(bn_fft *fft, uint32_t width, uint32_t height);
void bn_fft_destroy(bn_fft *fft);

/* Replaces re + i im by its forward transform, without a scale factor. Reports progress from `done` to `done` +
 * `share`; returns 0 if the callback cancels. */
int bn_fft_run(bn_fft *fft, bn_progress progress, void *user, double done, double share);

#endif
