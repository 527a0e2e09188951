/* SPDX-License-Identifier: Apache-2.0
 * Masks tile without seams: the dithering error at the borders of a mask is that of its inside.
 *
 * The error of a texel is the mean, over 16 thresholds t, of the square of G * [m < t] - t with a
 * Gaussian of 1.5 texels that wraps around. Rolling a mask by half its size moves the seam to the
 * middle, where an error would show in every tiled picture. The generators give the same bits
 * everywhere, so there are no false alarms. */
#include "check.h"
#include "masks.h"
#include <math.h>

enum { MOST = 96, THRESHOLDS = 16, REACH = 6, BAND = 2 /* texels on each side of the seam */ };

typedef struct shape {
    uint32_t width, height;
} shape;

/* Adds the squared errors of all texels over the thresholds first .. last - 1 to `total`. */
static void add_errors(shape s, const uint32_t *ranks, int first, int last, double *total) {
    static double rows[MOST * MOST];
    const size_t count = (size_t)s.width * s.height;
    double kernel[2 * REACH + 1], sum = 0;
    for (int d = -REACH; d <= REACH; ++d) sum += kernel[d + REACH] = exp(-d * d / (2 * 1.5 * 1.5));
    for (int i = first; i < last; ++i) {
        const double t = (i + 0.5) / THRESHOLDS;
        for (uint32_t y = 0; y < s.height; ++y) {
            for (uint32_t x = 0; x < s.width; ++x) {
                double row = 0;
                for (int d = -REACH; d <= REACH; ++d) {
                    const uint32_t at = (x + s.width + (uint32_t)d) % s.width;
                    const uint32_t rank = ranks[(size_t)y * s.width + at];
                    if (rank + 0.5 < t * (double)count) row += kernel[d + REACH] / sum;
                }
                rows[y * s.width + x] = row;
            }
        }
        for (uint32_t y = 0; y < s.height; ++y) {
            for (uint32_t x = 0; x < s.width; ++x) {
                double value = 0;
                for (int d = -REACH; d <= REACH; ++d) {
                    const uint32_t at = (y + s.height + (uint32_t)d) % s.height;
                    value += kernel[d + REACH] / sum * rows[at * s.width + x];
                }
                total[y * s.width + x] += (value - t) * (value - t);
            }
        }
    }
}

/* The mean error near the vertical (axis 0) or horizontal seam, over that away from both seams. */
static double ratio_at_seam(shape s, const double *errors, int axis) {
    double seam = 0, inside = 0;
    int at_seam = 0, within = 0;
    for (uint32_t y = 0; y < s.height; ++y) {
        for (uint32_t x = 0; x < s.width; ++x) {
            const int near_x = x < BAND || x >= s.width - BAND;
            const int near_y = y < BAND || y >= s.height - BAND;
            const double e = errors[y * s.width + x];
            if (axis == 0 ? near_x && !near_y : near_y && !near_x) {
                seam += e;
                ++at_seam;
            } else if (!near_x && !near_y) {
                inside += e;
                ++within;
            }
        }
    }
    return seam / at_seam / (inside / within);
}

enum { VOID_AND_CLUSTER, RELAX, ANNEAL, BUILTIN, METHODS };

static bn_result make(int method, shape s, uint64_t seed, uint32_t *ranks) {
    const size_t count = (size_t)s.width * s.height;
    bn_void_and_cluster_options v = bn_void_and_cluster_options_default();
    bn_relax_options r = bn_relax_options_default();
    bn_anneal_options a = bn_anneal_options_default();
    v.seed = r.seed = a.seed = seed;
    a.sweeps = 30;
    switch (method) {
    case VOID_AND_CLUSTER:
        return bn_void_and_cluster(&v, s.width, s.height, 1, ranks, count);
    case RELAX:
        return bn_relax(&r, s.width, s.height, ranks, count);
    case ANNEAL: /* from noise, so that what there is of blue is annealing's */
        fill_white(ranks, count, (uint32_t)seed + 1);
        a.start_from_ranks = 1;
        return bn_anneal(&a, s.width, s.height, 1, ranks, count);
    default:
        return bn_builtin_mask_copy(s.width, ranks, count);
    }
}

static void check_ratios(int method, shape s, const char *part, const double *errors,
                         double limit) {
    for (int axis = 0; axis < 2; ++axis) {
        const double ratio = ratio_at_seam(s, errors, axis);
        printf("method %d, %lu x %lu, %s, axis %d: %.3f\n", method, (unsigned long)s.width,
               (unsigned long)s.height, part, axis, ratio);
        CHECK(ratio < limit && ratio > 1 / limit);
    }
}

/* The first and the last threshold, whose texels are far apart, have errors of their own. */
static void test_seams(int method, shape s, uint64_t seeds, double limit) {
    static uint32_t ranks[MOST * MOST];
    static double ends[MOST * MOST], middle[MOST * MOST];
    memset(ends, 0, sizeof ends);
    memset(middle, 0, sizeof middle);
    for (uint64_t seed = 0; seed < seeds; ++seed) {
        CHECK(make(method, s, seed, ranks) == BN_SUCCESS);
        add_errors(s, ranks, 0, 1, ends);
        add_errors(s, ranks, THRESHOLDS - 1, THRESHOLDS, ends);
        add_errors(s, ranks, 1, THRESHOLDS - 1, middle);
    }
    check_ratios(method, s, "ends", ends, limit);
    check_ratios(method, s, "middle", middle, limit);
}

int main(void) {
    static const shape shapes[] = {{64, 64}, {61, 45}, {40, 72}};
    for (int method = 0; method < BUILTIN; ++method) {
        for (int i = 0; i < 3; ++i) test_seams(method, shapes[i], 6, 1.1);
    }
    test_seams(BUILTIN, shapes[0], 1, 1.2);
    return check_result();
}
