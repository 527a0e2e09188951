/* SPDX-License-Identifier: Apache-2.0
 * A small complex FFT of any length, which transforms many columns at once. */
#ifndef BN_FFT_H
#define BN_FFT_H

#include <bn/bn.h>

typedef struct bn_fft bn_fft;

/* Makes a plan for length n >= 1; NULL if out of memory. */
bn_fft *bn_fft_create(size_t n);
void bn_fft_destroy(bn_fft *fft);

/* The progress callback, and the range it reports: `done` to `done` + `share`. */
typedef struct bn_fft_watch {
    bn_progress progress; /* or NULL */
    void *user;
    double done, share;
} bn_fft_watch;

/* Transforms each column of the matrix re + i im, which has n rows and `columns` columns, to a row of
 * another matrix. Applied twice, this is the two-dimensional forward transform. The plan holds the scratch
 * memory, so only one thread at a time may use it. Returns 0 if the callback in `watch` cancels. */
int bn_fft_columns(bn_fft *fft, const double *re, const double *im, size_t columns, double *to_re,
                   double *to_im, const bn_fft_watch *watch);

#endif
