/* SPDX-License-Identifier: Apache-2.0
 * A small complex FFT of any length, over many columns at once. */
#ifndef BN_FFT_H
#define BN_FFT_H

#include <bn/bn.h>

typedef struct bn_fft bn_fft;

/* Makes a plan for length n >= 1; NULL if out of memory. */
bn_fft *bn_fft_create(size_t n);
void bn_fft_destroy(bn_fft *fft);

/* The progress callback, and the range that it reports: `done` to `done` + `share`. */
typedef struct bn_fft_watch {
    bn_progress progress; /* or NULL */
    void *user;
    double done, share;
} bn_fft_watch;

/* Forward transform, in place, along the rows of a matrix re + i im of n rows and `columns` columns:
 * every column is replaced by its discrete Fourier transform. The plan holds the scratch memory, so
 * only one thread at a time may use it. Returns 0 if the callback of `watch` cancels. */
int bn_fft_columns(bn_fft *fft, double *re, double *im, size_t columns, const bn_fft_watch *watch);

/* to[x][y] = from[y][x] for a matrix of height rows and width columns. */
void bn_transpose(const double *from, size_t height, size_t width, double *to);

#endif
