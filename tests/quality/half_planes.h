/* SPDX-License-Identifier: Apache-2.0
 * Half-planes: integrands of the tests of quality, with known means. */
#ifndef BN_TESTS_HALF_PLANES_H
#define BN_TESTS_HALF_PLANES_H

#include <math.h>

static inline double fraction(double v) {
    return v - floor(v);
}

/* a x + b y < c, and its mean over the unit square. */
typedef struct half_plane {
    double a, b, c, mean;
} half_plane;

static inline half_plane half_plane_through(double a, double b, double x, double y) {
    enum { COLUMNS = 4096 };
    half_plane h = {a, b, a * x + b * y, 0.0};
    for (int i = 0; i < COLUMNS; ++i) {
        double height = (h.c - h.a * (i + 0.5) / COLUMNS) / h.b;
        height = height < 0.0 ? 0.0 : height > 1.0 ? 1.0 : height;
        h.mean += (h.b > 0.0 ? height : 1.0 - height) / COLUMNS;
    }
    return h;
}

static inline int is_inside(const half_plane *h, const float *u) {
    return h->a * u[0] + h->b * u[1] < h->c;
}

#endif
