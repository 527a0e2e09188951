/* SPDX-License-Identifier: Apache-2.0
 * What each phase of void-and-cluster promises, checked rank by rank with a Gaussian computed here:
 * the initial pattern is stable, its ranks were given from the tightest cluster down, the ranks
 * after it went to the largest void, and both ends of the scale are spread evenly. */
#include "check.h"
#include "masks.h"
#include <math.h>

enum { MOST = 4096 };

typedef struct mask {
    int width, height;
    size_t count;
    double sigma, fraction;
    uint32_t ranks[MOST];
    size_t at[MOST]; /* the texel of each rank */
    double energy[MOST];
} mask;

/* The shorter distance between two coordinates on the torus. */
static int apart(int a, int b, int extent) {
    const int d = abs(a - b);
    return d < extent - d ? d : extent - d;
}

/* The Gaussian between two texels, cut off where the library cuts it. */
static double weight(const mask *m, size_t p, size_t q) {
    const int dx = apart((int)(p % m->width), (int)(q % m->width), m->width);
    const int dy = apart((int)(p / m->width), (int)(q / m->width), m->height);
    const int radius = (int)ceil(10.0 / 3 * m->sigma), square = dx * dx + dy * dy;
    return square > radius * radius ? 0 : exp(-square / (2 * m->sigma * m->sigma));
}

static void set(mask *m, size_t texel) {
    for (size_t p = 0; p < m->count; ++p) m->energy[p] += weight(m, p, texel);
}

/* The largest energy of the texels that are set, or the lowest of the others: those of ranks from
 * `first` to `last` - 1. */
static double extreme(const mask *m, size_t first, size_t last, int sign) {
    double best = -1e30;
    for (size_t rank = first; rank < last; ++rank) best = fmax(best, sign * m->energy[m->at[rank]]);
    return sign * best;
}

/* Whether the tightest cluster of the first `ones` ranks, once removed, leaves the largest void. */
static int is_stable(const mask *m, size_t ones) {
    size_t cluster = m->at[0];
    for (size_t rank = 1; rank < ones; ++rank) {
        if (m->energy[m->at[rank]] > m->energy[cluster]) cluster = m->at[rank];
    }
    for (size_t rank = ones; rank < m->count; ++rank) {
        const size_t p = m->at[rank];
        if (m->energy[p] - weight(m, p, cluster) < m->energy[cluster] - 1 - 1e-4) return 0;
    }
    return 1;
}

/* The smallest distance between two of `points` texels, as a share of their spacing, the square
 * root of the area of each. A square grid has 1, a triangular one 1.07. */
static double evenness(const mask *m, const size_t *texels, size_t points) {
    int least = INT32_MAX;
    for (size_t i = 1; i < points; ++i) {
        for (size_t j = 0; j < i; ++j) {
            const size_t p = texels[i], q = texels[j];
            const int dx = apart((int)(p % m->width), (int)(q % m->width), m->width);
            const int dy = apart((int)(p / m->width), (int)(q / m->width), m->height);
            if (dx * dx + dy * dy < least) least = dx * dx + dy * dy;
        }
    }
    return sqrt(least * (double)points / (double)m->count);
}

static void test_phases(int width, int height, double sigma, double fraction, uint64_t seed) {
    static mask m;
    static size_t from_end[MOST];
    bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
    memset(&m, 0, sizeof m);
    m.width = width;
    m.height = height;
    m.sigma = options.sigma = sigma;
    m.count = (size_t)width * (size_t)height;
    options.initial_fraction = fraction;
    options.seed = seed;
    CHECK(bn_void_and_cluster(&options, (uint32_t)width, (uint32_t)height, 1, m.ranks, m.count) ==
          BN_SUCCESS);
    for (size_t p = 0; p < m.count; ++p) m.at[m.ranks[p]] = p;
    for (size_t p = 0; p < m.count; ++p) from_end[m.count - 1 - m.ranks[p]] = p;

    /* At both ends texels are too far apart for this Gaussian: their order has other rules. */
    const size_t initial = (size_t)((double)m.count * fraction);
    size_t sparse = (size_t)((double)m.count * (0.45 / sigma) * (0.45 / sigma));
    if (sparse > initial) sparse = initial;
    /* The library breaks ties with noise of 2^-16 of the kernel's centre. */
    const double tie = 1e-4;
    int in_cluster = 0, in_void = 0;
    for (size_t rank = 0; rank + sparse < m.count; ++rank) {
        const size_t p = m.at[rank];
        if (rank == initial) CHECK(is_stable(&m, initial));
        if (rank >= initial) in_void += m.energy[p] > extreme(&m, rank, m.count, -1) + tie;
        set(&m, p);
        if (rank >= sparse && rank < initial) {
            in_cluster += m.energy[p] < extreme(&m, 0, rank + 1, 1) - tie;
        }
    }
    CHECK(in_cluster == 0 && in_void == 0);
    double least = 2, least_from_end = 2;
    for (size_t points = 2; points <= sparse; points += 1 + points / 16) {
        least = fmin(least, evenness(&m, m.at, points));
        least_from_end = fmin(least_from_end, evenness(&m, from_end, points));
    }
    printf("%d x %d, sigma %g, from %g: evenness %.3f %.3f\n", width, height, sigma, fraction,
           least, least_from_end);
    CHECK(least > 0.5 && least_from_end > 0.5);
}

int main(void) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
        test_phases(32, 32, 1.5, 0.1, seed);
        test_phases(32, 32, 1.5, 0.3, seed);
        test_phases(37, 27, 1.5, 0.2, seed);
        test_phases(40, 24, 1.9, 0.3, seed);
    }
    return check_result();
}
