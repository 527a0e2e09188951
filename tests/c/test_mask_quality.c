/* SPDX-License-Identifier: Apache-2.0
 * The masks of every method against the limits of quality/masks.csv.
 *
 * A row is a method, extents, its sigma, how many seeds (0, 1, ...) are averaged, a measure and its
 * upper limit. The generators give the same bits everywhere, so there are no false alarms.
 * Measures:
 *
 *     e_S          bn_mask_error() at sigma S
 *     low_A/B      mean power (white noise: 1) of the mask thresholded at grey level g = A/B, below
 *                  half the principal frequency sqrt(min(g, 1 - g))
 *     anisotropy   of the mean spectrum of all seeds, in dB: 10 log10 of variance over squared mean
 *                  on rings one frequency step wide, averaged over rings of at least 32 texels */
#include "check.h"
#include "masks.h"
#include <math.h>

typedef struct row {
    char method[32], measure[32];
    unsigned width, height, seeds;
    double sigma, limit;
} row;

static bn_result make(const row *r, uint64_t seed, uint32_t *ranks, size_t count) {
    if (strcmp(r->method, "void-and-cluster") == 0) {
        bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
        options.sigma = r->sigma;
        options.seed = seed;
        return bn_void_and_cluster(&options, r->width, r->height, 1, ranks, count);
    }
    if (strcmp(r->method, "relax") == 0) {
        bn_relax_options options = bn_relax_options_default();
        options.seed = seed;
        return bn_relax(&options, r->width, r->height, ranks, count);
    }
    if (strcmp(r->method, "anneal") == 0) {
        bn_anneal_options options = bn_anneal_options_default();
        options.sigma = r->sigma;
        options.seed = seed;
        options.sweeps = 4000;
        return bn_anneal(&options, r->width, r->height, 1, ranks, count);
    }
    if (strcmp(r->method, "builtin") == 0) return bn_builtin_mask_copy(r->width, ranks, count);
    return BN_ERROR_UNSUPPORTED;
}

/* The frequency of a texel of a spectrum, in cycles per texel. */
static double frequency(const row *r, uint32_t u, uint32_t v) {
    double x = (double)(u <= r->width / 2 ? u : r->width - u) / r->width;
    double y = (double)(v <= r->height / 2 ? v : r->height - v) / r->height;
    return sqrt(x * x + y * y);
}

/* The pattern's low frequencies by plain sums over its texels: there are few of them. */
static double low_power(const row *r, const uint32_t *ranks, double level) {
    const double pi = acos(-1), limit = sqrt(level < 0.5 ? level : 1 - level) / 2;
    const size_t count = (size_t)r->width * r->height, ones = (size_t)ceil(level * (double)count);
    const int most_u = (int)(limit * r->width) + 1, most_v = (int)(limit * r->height) + 1;
    /* Columns first: sums over x for every row and u. */
    double *re = calloc((size_t)r->height * (most_u + 1), sizeof *re);
    double *im = calloc((size_t)r->height * (most_u + 1), sizeof *im);
    for (uint32_t y = 0; y < r->height; ++y) {
        for (uint32_t x = 0; x < r->width; ++x) {
            if (ranks[(size_t)y * r->width + x] >= ones) continue;
            for (int u = 0; u <= most_u; ++u) {
                re[y * (most_u + 1) + u] += cos(2 * pi * u * x / r->width);
                im[y * (most_u + 1) + u] += sin(2 * pi * u * x / r->width);
            }
        }
    }
    double sum = 0;
    int texels = 0;
    for (int v = -most_v; v <= most_v; ++v) {
        for (int u = 0; u <= most_u; ++u) {
            double fx = (double)u / r->width, fy = (double)v / r->height;
            /* One of each pair of conjugates. */
            if (fx * fx + fy * fy >= limit * limit || (u == 0 && v <= 0)) continue;
            double a = 0, b = 0;
            for (uint32_t y = 0; y < r->height; ++y) {
                double c = cos(2 * pi * v * y / r->height), s = sin(2 * pi * v * y / r->height);
                a += re[y * (most_u + 1) + u] * c - im[y * (most_u + 1) + u] * s;
                b += re[y * (most_u + 1) + u] * s + im[y * (most_u + 1) + u] * c;
            }
            sum += a * a + b * b;
            ++texels;
        }
    }
    free(re);
    free(im);
    double n = (double)count, g = (double)ones / n;
    return sum / texels / (n * g * (1 - g));
}

static double anisotropy(const row *r, const double *power) {
    const uint32_t rings = r->width > r->height ? r->width : r->height;
    double *sum = calloc(rings, sizeof *sum), *square = calloc(rings, sizeof *square);
    int *texels = calloc(rings, sizeof *texels), used = 0;
    double total = 0;
    for (uint32_t v = 0; v < r->height; ++v) {
        for (uint32_t u = 0; u < r->width; ++u) {
            uint32_t ring = (uint32_t)(frequency(r, u, v) * rings + 0.5);
            double p = power[(size_t)v * r->width + u];
            sum[ring] += p;
            square[ring] += p * p;
            ++texels[ring];
        }
    }
    for (uint32_t ring = 1; ring < rings; ++ring) {
        if (texels[ring] < 32) continue;
        double mean = sum[ring] / texels[ring];
        double variance = (square[ring] - sum[ring] * mean) / (texels[ring] - 1);
        total += 10 * log10(variance / (mean * mean));
        ++used;
    }
    free(sum);
    free(square);
    free(texels);
    return total / used;
}

/* Rows of the same masks, in the order of the file, share them: a mask is made once. */
typedef struct mask_set {
    row of;
    uint32_t *ranks; /* [seed][height][width] */
} mask_set;

static int same_masks(const row *a, const row *b) {
    return strcmp(a->method, b->method) == 0 && a->width == b->width && a->height == b->height &&
           a->sigma == b->sigma;
}

/* The masks of a row; those of an earlier row are kept until another asks for other ones. */
static const uint32_t *masks_of(mask_set *made, const row *r) {
    const size_t count = (size_t)r->width * r->height;
    if (made->ranks != NULL && same_masks(&made->of, r) && r->seeds <= made->of.seeds) {
        return made->ranks;
    }
    free(made->ranks);
    made->of = *r;
    made->ranks = malloc(r->seeds * count * sizeof *made->ranks);
    for (unsigned seed = 0; seed < r->seeds; ++seed) {
        CHECK(make(r, seed, made->ranks + seed * count, count) == BN_SUCCESS);
        CHECK(is_permutation(made->ranks + seed * count, count));
    }
    return made->ranks;
}

static double measure(const row *r, const uint32_t *masks) {
    const size_t count = (size_t)r->width * r->height;
    float *power = malloc(count * sizeof *power);
    double *powers = calloc(count, sizeof *powers), total = 0;
    int numerator, denominator;
    for (unsigned seed = 0; seed < r->seeds; ++seed) {
        const uint32_t *ranks = masks + seed * count;
        double value = 0;
        if (strncmp(r->measure, "e_", 2) == 0) {
            CHECK(bn_mask_error(ranks, r->width, r->height, count, atof(r->measure + 2), &value,
                                NULL, NULL) == BN_SUCCESS);
        } else if (sscanf(r->measure, "low_%d/%d", &numerator, &denominator) == 2) {
            value = low_power(r, ranks, (double)numerator / denominator);
        } else {
            CHECK(strcmp(r->measure, "anisotropy") == 0);
            CHECK(bn_power_spectrum(ranks, r->width, r->height, count, power, NULL, NULL) ==
                  BN_SUCCESS);
            for (size_t i = 0; i < count; ++i) powers[i] += power[i];
        }
        total += value / r->seeds;
    }
    if (strcmp(r->measure, "anisotropy") == 0) total = anisotropy(r, powers);
    free(power);
    free(powers);
    return total;
}

int main(void) {
    FILE *file = fopen(BN_TESTS_DIR "/quality/masks.csv", "r");
    char line[256];
    int rows = 0;
    mask_set made = {0};
    CHECK(file != NULL && fgets(line, sizeof line, file) != NULL);
    while (file != NULL && fgets(line, sizeof line, file) != NULL) {
        row r;
        CHECK(sscanf(line, "%31[^,],%u,%u,%lf,%u,%31[^,],%lf", r.method, &r.width, &r.height,
                     &r.sigma, &r.seeds, r.measure, &r.limit) == 7);
        if (strcmp(r.method, "builtin") == 0 && bn_builtin_mask(r.width) == NULL) continue;
        double value = measure(&r, masks_of(&made, &r));
        printf("%s %ux%u sigma %g, %u seeds: %s %.4f, limit %.4f%s\n", r.method, r.width, r.height,
               r.sigma, r.seeds, r.measure, value, r.limit, value <= r.limit ? "" : " EXCEEDED");
        CHECK(value <= r.limit);
        ++rows;
    }
    free(made.ranks);
    CHECK(rows >= 20);
    if (file != NULL) fclose(file);
    return check_result();
}
