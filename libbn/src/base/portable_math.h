/* SPDX-License-Identifier: Apache-2.0
 * exp() and log() that are bit-identical on every machine, unlike the C library's. They use only
 * the four basic operations. The relative error is about 1e-15. */
#ifndef BN_PORTABLE_MATH_H
#define BN_PORTABLE_MATH_H

#include "base/assert.h"
#include <math.h>

#define BN_LN2_HIGH 0x1.62e42feep-1 /* the first 32 bits of ln 2, and the rest */
#define BN_LN2_LOW 0x1.a39ef35793c76p-33

/* e^x for x in [-1e9, 709], 0 below -745: 2^k times the Taylor series of the rest, at most ln 2 / 2. */
static inline double bn_portable_exp(double x) {
    BN_ASSERT(x >= -1e9 && x <= 709);
    double scaled = x / (BN_LN2_HIGH + BN_LN2_LOW);
    int whole = (int)(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
    /* The first product is exact for results above 0: 32 bits times at most 11. */
    double rest = (x - whole * BN_LN2_HIGH) - whole * BN_LN2_LOW, sum = 1;
    for (int i = 16; i >= 1; --i) sum = 1 + sum * rest / i; /* the next term is below 2^-73 */
    return ldexp(sum, whole);
}

/* ln x for finite x > 0, from the series for 2 atanh((m - 1) / (m + 1)), where m is in [0.7, 1.4]. */
static inline double bn_portable_log(double x) {
    BN_ASSERT(x > 0 && x <= 0x1.fffffffffffffp1023);
    int exponent;
    double m = frexp(x, &exponent);
    if (m < 0.70710678118654752) {
        m *= 2;
        --exponent;
    }
    double z = (m - 1) / (m + 1), square = z * z, sum = 0;
    BN_ASSERT(z > -0.172 && z < 0.172);
    for (int i = 27; i >= 1; i -= 2) sum = sum * square + 1.0 / i; /* the next is below 2^-77 */
    return exponent * BN_LN2_HIGH + (exponent * BN_LN2_LOW + 2 * z * sum);
}

#endif
