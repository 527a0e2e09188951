/* SPDX-License-Identifier: Apache-2.0
 * Fast Fourier transform of any length.
 *
 * Powers of two use Stockham's self-sorting radix-2 passes, in O(n log n). Other lengths use
 * Bluestein's algorithm ("A linear filtering approach to the computation of discrete Fourier
 * transform", 1970), which turns the transform into a convolution of power-of-two length. Each pass
 * transforms eight columns side by side, so that the inner loops vectorise. */
#include "measure/fft.h"
#include "base/assert.h"
#include "base/memory.h"
#include <math.h>
#include <string.h>

enum { BN_FFT_LANES = 8 }; /* columns: a cache line of doubles */

/* A plan for one axis. */
struct bn_fft_axis {
    size_t n, m;                   /* the length; the power of two that is transformed */
    double *cosine, *sine;         /* cosine and sine of -2 pi k / m, m / 2 values */
    double *chirp_re, *chirp_im;   /* Bluestein: exp(-i pi k^2 / n), n values */
    double *filter_re, *filter_im; /* the conjugate chirp's transform divided by m, m values */
    double *scratch[4];            /* re, im, re, im: m rows of BN_FFT_LANES */
};

static const double BN_PI = 3.14159265358979323846;

static void axis_destroy(bn_fft_axis *fft) {
    if (fft == NULL) return;
    bn_free(fft->cosine);
    bn_free(fft->sine);
    bn_free(fft->chirp_re);
    bn_free(fft->chirp_im);
    bn_free(fft->filter_re);
    bn_free(fft->filter_im);
    for (int i = 0; i < 4; ++i) bn_free(fft->scratch[i]);
    bn_free(fft);
}

/* One Stockham pass: groups of `half` butterflies at distance `half` become interleaved pairs. */
static void pass(const bn_fft_axis *fft, const double *re, const double *im, double *to_re,
                 double *to_im, size_t stride) {
    const size_t half = fft->m / 2;
    for (size_t k = 0; k < half; ++k) {
        const size_t twiddle = k / stride * stride;
        const double c = fft->cosine[twiddle], s = fft->sine[twiddle];
        const double *ar = re + k * BN_FFT_LANES, *ai = im + k * BN_FFT_LANES;
        const double *br = ar + half * BN_FFT_LANES, *bi = ai + half * BN_FFT_LANES;
        double *pr = to_re + (k + twiddle) * BN_FFT_LANES,
               *pi = to_im + (k + twiddle) * BN_FFT_LANES;
        double *qr = pr + stride * BN_FFT_LANES, *qi = pi + stride * BN_FFT_LANES;
        for (int lane = 0; lane < BN_FFT_LANES; ++lane) {
            double dr = ar[lane] - br[lane], di = ai[lane] - bi[lane];
            pr[lane] = ar[lane] + br[lane];
            pi[lane] = ai[lane] + bi[lane];
            qr[lane] = dr * c - di * s;
            qi[lane] = dr * s + di * c;
        }
    }
}

/* Transforms scratch buffers 0 and 1 into the returned pair of scratch buffers. */
static int transform(bn_fft_axis *fft) {
    int at = 0;
    for (size_t stride = 1; stride < fft->m; stride *= 2) {
        pass(fft, fft->scratch[at], fft->scratch[at + 1], fft->scratch[2 - at],
             fft->scratch[3 - at], stride);
        at = 2 - at;
    }
    return at;
}

/* Makes the plan for length n >= 1; NULL if out of memory. */
static bn_fft_axis *axis_create(size_t n) {
    bn_fft_axis *fft = bn_allocate_zero(1, sizeof *fft);
    if (fft == NULL) return NULL;
    BN_ASSERT(n > 0);
    int direct = (n & (n - 1)) == 0;
    fft->n = n;
    fft->m = 1;
    /* Long enough for a convolution of n values with 2 n - 1 that does not wrap into the first n results. */
    while (fft->m < (direct ? n : 2 * n - 1)) fft->m *= 2;
    const size_t half = (fft->m + 1) / 2; /* 1 for length 1, whose transform reads none */
    fft->cosine = bn_allocate(half, sizeof(double));
    fft->sine = bn_allocate(half, sizeof(double));
    int good = fft->cosine != NULL && fft->sine != NULL;
    for (int i = 0; i < 4; ++i) {
        fft->scratch[i] = bn_allocate(fft->m * BN_FFT_LANES, sizeof(double));
        good = good && fft->scratch[i] != NULL;
    }
    if (!direct) {
        fft->chirp_re = bn_allocate(n, sizeof(double));
        fft->chirp_im = bn_allocate(n, sizeof(double));
        fft->filter_re = bn_allocate(fft->m, sizeof(double));
        fft->filter_im = bn_allocate(fft->m, sizeof(double));
        good = good && fft->chirp_re && fft->chirp_im && fft->filter_re && fft->filter_im;
    }
    if (!good) {
        axis_destroy(fft);
        return NULL;
    }
    for (size_t k = 0; k < half; ++k) {
        fft->cosine[k] = cos(2 * BN_PI * (double)k / (double)fft->m);
        fft->sine[k] = -sin(2 * BN_PI * (double)k / (double)fft->m);
    }
    if (direct) return fft;

    memset(fft->scratch[0], 0, fft->m * BN_FFT_LANES * sizeof(double));
    memset(fft->scratch[1], 0, fft->m * BN_FFT_LANES * sizeof(double));
    for (size_t k = 0; k < n; ++k) {
        /* Reducing k^2 modulo 2 n keeps the angle small and therefore exact. */
        double angle = BN_PI * (double)((uint64_t)k * k % (2 * (uint64_t)n)) / (double)n;
        fft->chirp_re[k] = cos(angle);
        fft->chirp_im[k] = -sin(angle);
        size_t mirror = k == 0 ? 0 : fft->m - k;
        fft->scratch[0][k * BN_FFT_LANES] = fft->scratch[0][mirror * BN_FFT_LANES] = cos(angle);
        fft->scratch[1][k * BN_FFT_LANES] = fft->scratch[1][mirror * BN_FFT_LANES] = sin(angle);
    }
    int at = transform(fft);
    for (size_t k = 0; k < fft->m; ++k) {
        fft->filter_re[k] = fft->scratch[at][k * BN_FFT_LANES] / (double)fft->m;
        fft->filter_im[k] = fft->scratch[at + 1][k * BN_FFT_LANES] / (double)fft->m;
    }
    return fft;
}

/* Transforms the data in scratch buffers 0 and 1 (n rows, then zeros); see the top of this file. */
static int bluestein(bn_fft_axis *fft) {
    double *re = fft->scratch[0], *im = fft->scratch[1];
    for (size_t k = 0; k < fft->n; ++k) { /* times the chirp */
        const double c = fft->chirp_re[k], s = fft->chirp_im[k];
        double *r = re + k * BN_FFT_LANES, *i = im + k * BN_FFT_LANES;
        for (int lane = 0; lane < BN_FFT_LANES; ++lane) {
            double t = r[lane] * c - i[lane] * s;
            i[lane] = r[lane] * s + i[lane] * c;
            r[lane] = t;
        }
    }
    int at = transform(fft);
    /* Convolve with the filter. The inverse transform is the conjugate of the forward transform of the conjugate. */
    for (size_t k = 0; k < fft->m; ++k) {
        const double c = fft->filter_re[k], s = fft->filter_im[k];
        const double *r = fft->scratch[at] + k * BN_FFT_LANES;
        const double *i = fft->scratch[at + 1] + k * BN_FFT_LANES;
        for (size_t lane = 0; lane < BN_FFT_LANES; ++lane) {
            double t = r[lane] * c - i[lane] * s;
            im[k * BN_FFT_LANES + lane] = -(r[lane] * s + i[lane] * c);
            re[k * BN_FFT_LANES + lane] = t;
        }
    }
    at = transform(fft);
    for (size_t k = 0; k < fft->n; ++k) { /* times the chirp, after the conjugation */
        const double c = fft->chirp_re[k], s = fft->chirp_im[k];
        double *r = fft->scratch[at] + k * BN_FFT_LANES;
        double *i = fft->scratch[at + 1] + k * BN_FFT_LANES;
        for (int lane = 0; lane < BN_FFT_LANES; ++lane) {
            double t = r[lane] * c + i[lane] * s;
            i[lane] = r[lane] * s - i[lane] * c;
            r[lane] = t;
        }
    }
    return at;
}

/* Transforms each column of a matrix with n rows to a row of another matrix, so that a second call transforms the
 * rows and restores the order. Returns 0 if cancelled. */
static int transform_columns(bn_fft_axis *fft, const double *re, const double *im, size_t columns,
                             double *to_re, double *to_im, bn_progress progress, void *user,
                             double from, double share) {
    const size_t used = fft->n * BN_FFT_LANES;
    for (size_t first = 0; first < columns; first += BN_FFT_LANES) {
        const double done = from + share * (double)first / (double)columns;
        if (progress != NULL && progress(user, done) != 0) return 0;
        const size_t lanes = columns - first < BN_FFT_LANES ? columns - first : BN_FFT_LANES;
        for (size_t part = 0; part < 2; ++part) {
            const double *source = (part == 0 ? re : im) + first;
            double *to = fft->scratch[part];
            if (lanes < BN_FFT_LANES) memset(to, 0, used * sizeof *to);
            for (size_t k = 0; k < fft->n; ++k) {
                memcpy(to + k * BN_FFT_LANES, source + k * columns, lanes * sizeof *to);
            }
            memset(to + used, 0, (fft->m * BN_FFT_LANES - used) * sizeof *to);
        }
        const int at = fft->chirp_re == NULL ? transform(fft) : bluestein(fft);
        for (size_t part = 0; part < 2; ++part) {
            double *to = (part == 0 ? to_re : to_im) + first * fft->n;
            const double *result = fft->scratch[at + (int)part];
            for (size_t k = 0; k < fft->n; ++k) {
                for (size_t lane = 0; lane < lanes; ++lane)
                    to[lane * fft->n + k] = result[k * BN_FFT_LANES + lane];
            }
        }
    }
    return 1;
}

int bn_fft_create(bn_fft *fft, uint32_t width, uint32_t height) {
    const size_t count = (size_t)width * height;
    fft->width = width;
    fft->height = height;
    fft->axis[0] = axis_create(height);
    fft->axis[1] = axis_create(width);
    fft->re = bn_allocate(count, 4 * sizeof *fft->re); /* with the transposed image after `im` */
    fft->im = fft->re != NULL ? fft->re + count : NULL;
    return fft->axis[0] != NULL && fft->axis[1] != NULL && fft->re != NULL;
}

void bn_fft_destroy(bn_fft *fft) {
    axis_destroy(fft->axis[0]);
    axis_destroy(fft->axis[1]);
    bn_free(fft->re);
}

int bn_fft_run(bn_fft *fft, bn_progress progress, void *user, double done, double share) {
    const size_t count = (size_t)fft->width * fft->height;
    double *turned_re = fft->im + count, *turned_im = turned_re + count;
    return transform_columns(fft->axis[0], fft->re, fft->im, fft->width, turned_re, turned_im,
                             progress, user, done, share / 2) &&
           transform_columns(fft->axis[1], turned_re, turned_im, fft->height, fft->re, fft->im,
                             progress, user, done + share / 2, share / 2);
}
