/* SPDX-License-Identifier: Apache-2.0
 * Domains are independent, or stratified together within a family: over random call trees, how
 * often two of them read the tables of BLUE alike, how much their samples correlate, and how well
 * products over two of them converge. Everything is seeded; false-alarm rates are for fresh seeds. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DOMAINS = 64, DOMAIN_PAIRS = DOMAINS * (DOMAINS - 1) / 2, SEED = 20 };

static uint32_t random_u32(void) {
    static uint32_t counter;
    return bn_hash32(bn_hash32(++counter) ^ 0x51ed270bu);
}

/* A path tracer's call tree: bounces chained one to the next, each with its light loop, its
 * split and a few single decisions; keys are small numbers. */
static void make_tree(uint32_t domains[DOMAINS]) {
    uint32_t path = bn_domain_child(BN_DOMAIN_ROOT, random_u32() & 1023u);
    int count = 0;
    while (count < DOMAINS) {
        uint32_t decisions = 1 + (random_u32() & 3u), lights = random_u32() & 7u;
        for (uint32_t key = 0; key < decisions && count < DOMAINS; ++key) {
            domains[count++] = bn_domain_child(path, key);
        }
        uint32_t loop = bn_domain_child(path, 100 + (random_u32() & 3u));
        for (uint32_t light = 0; light < lights && count < DOMAINS; ++light) {
            domains[count++] = bn_domain_child(loop, light);
        }
        path = bn_domain_child(path, random_u32() & 1u ? 7u : 1u << (random_u32() & 31u));
    }
}

static int compare_u64(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Two families that shift and turn over the tile alike have the same labels in every pixel.
 * 2^14 equally likely views make 123 equal pairs among the 2 million of 1000 trees, fewer as the
 * members of a family share theirs; five deviations above that has probability 1e-6. What is seen
 * are the first digits of four pixels, relative to those of a fifth. */
static void test_coincidences(void) {
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, SEED);
    int equal = 0, within = 0;
    for (int tree = 0; tree < 1000; ++tree) {
        uint32_t domains[DOMAINS];
        uint64_t looks[DOMAINS];
        make_tree(domains);
        for (int d = 0; d < DOMAINS; ++d) {
            uint64_t pairs[2] = {0, 0};
            uint32_t first[4] = {0};
            for (int pixel = 0; pixel < 5; ++pixel) {
                uint32_t u[4];
                bn_sample_4d_u32(&s, 13 * pixel, 31 * pixel * pixel, 0, domains[d], u);
                /* Relative to the first pixel, the digits that a domain adds cancel. */
                if (pixel == 0) memcpy(first, u, sizeof first);
                for (int pair = 0; pair < 2; ++pair) {
                    uint32_t v = u[2 * pair] ^ first[2 * pair];
                    uint32_t w = u[2 * pair + 1] ^ first[2 * pair + 1];
                    pairs[pair] = pairs[pair] << 16 | (v >> 24 << 8) | w >> 24;
                }
            }
            within += pairs[0] == pairs[1];
            looks[d] = pairs[0] ^ (pairs[1] << 32 | pairs[1] >> 32);
        }
        qsort(looks, DOMAINS, sizeof *looks, compare_u64);
        for (int i = 1; i < DOMAINS; ++i) equal += looks[i] == looks[i - 1];
    }
    double expected = 1000.0 * DOMAIN_PAIRS / pow(2.0, 14.0);
    printf("equal domains: %d (at most %.1f expected), %d within\n", equal, expected, within);
    CHECK(equal < expected + 5.0 * sqrt(expected) && within == 0);
}

/* |sum of products| of two domains over `count` centred values. */
static float product_sum(const float *a, const float *b, int count) {
    float sum = 0.0f;
    for (int i = 0; i < count; ++i) sum += a[i] * b[i];
    return fabsf(sum);
}

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The products of all pairs of domains of `trees` trees, sorted: the first `count` samples of one
 * pixel each, or with side > 0 the first sample of side x side pixels. */
static float *sorted_products(int32_t kind, int trees, int count, int side) {
    enum { LARGEST = 64 * 64 };
    const bn_sampler s = make_sampler(kind, 0, SEED);
    float *sums = malloc((size_t)trees * DOMAIN_PAIRS * sizeof *sums), *next = sums;
    float(*values)[LARGEST] = malloc(DOMAINS * sizeof *values);
    int values_count = side > 0 ? side * side : count;
    for (int tree = 0; tree < trees; ++tree) {
        uint32_t domains[DOMAINS];
        make_tree(domains);
        int32_t x0 = (int32_t)(random_u32() & 1023u), y0 = (int32_t)(random_u32() & 1023u);
        for (int d = 0; d < DOMAINS; ++d) {
            for (int i = 0; i < values_count; ++i) {
                float u[4];
                if (side > 0) {
                    bn_sample_4d(&s, x0 + i % side, y0 + i / side, 0, domains[d], u);
                } else {
                    bn_sample_4d(&s, x0, y0, (uint32_t)i, domains[d], u);
                }
                /* Every dimension meets every other over the trees. */
                values[d][i] = u[(d + tree * (d & 1)) & 3] - 0.5f;
            }
        }
        for (int a = 0; a < DOMAINS; ++a) {
            for (int b = 0; b < a; ++b)
                *next++ = 12.0f * product_sum(values[a], values[b], values_count) /
                          sqrtf((float)values_count);
        }
    }
    free(values);
    qsort(sums, (size_t)trees * DOMAIN_PAIRS, sizeof *sums, compare_floats);
    return sums;
}

static double share_above(const float *sorted, int count, float limit) {
    int i = count;
    while (i > 0 && sorted[i - 1] > limit) --i;
    return (double)(count - i) / count;
}

/* In a pixel: the limit is the one that 99.9 % of the pairs of SOBOL's domains keep, which are
 * independent Owen-scrambled sequences. Over as few as 120 trees the share, .12 % at 16 samples,
 * scatters by a twelfth of it. The built-in data has at most .16 %. */
static void test_pixel_correlation(void) {
    enum { TREES = 480, PAIRS = TREES * DOMAIN_PAIRS };
    for (int count = 16; count <= 64; count *= 2) {
        float *sobol = sorted_products(BN_SAMPLER_SOBOL, TREES, count, 0);
        float *blue = sorted_products(BN_SAMPLER_BLUE, TREES, count, 0);
        double share = share_above(blue, PAIRS, sobol[PAIRS - PAIRS / 1000]);
        printf("%d samples of a pixel: %.3f %% of the pairs of domains beyond the 99.9 %% limit\n",
               count, 100.0 * share);
        CHECK(share <= 0.0018);
        free(sobol);
        free(blue);
    }
}

/* Over the screen: blue pictures correlate a little more widely than white ones, with a variance
 * that is the mean product of their power spectra; the limit is that of the normal distribution
 * with the scale of the middle half of all pairs. Families at places of the tile near one another
 * add to it: one in 2^12 pairs lies within a pixel of another. The built-in data has .16 %. */
static void test_screen_correlation(void) {
    enum { TREES = 200, PAIRS = TREES * DOMAIN_PAIRS };
    float *blue = sorted_products(BN_SAMPLER_BLUE, TREES, 1, 64);
    double scale = blue[PAIRS / 2] / 0.67449;
    double share = share_above(blue, PAIRS, (float)(3.2905 * scale));
    printf("screen: scale %.3f, %.3f %% beyond the 99.9 %% limit\n", scale, 100.0 * share);
    CHECK(scale < 1.25);
    CHECK(share <= 0.0018);
    free(blue);
}

/* Products of two half-planes: in the two pairs of one domain, in two domains of a family, or in
 * domains of two families. The error of BLUE against that of SOBOL, whose sequences are
 * independent. The ratios vary by 1 % from seed to seed, as all pixels lie in blocks with orders
 * of their own. (In 48 x 48 pixels side by side those of two families vary by 2.5 %.) */
typedef enum relation { ONE_DOMAIN, ONE_FAMILY, TWO_FAMILIES } relation;

static double product_error(const bn_sampler *s, int function, uint32_t count, relation where) {
    double angle = 2.4 * function, square = 0.0, mean[2] = {0.0, 0.0};
    double normal[2][3] = {{cos(angle), sin(angle), 0.0}, {cos(3 * angle), -sin(3 * angle), 0.0}};
    enum { GRID = 256, SIDE = 48 };
    uint32_t parent = bn_domain_child(1, (uint32_t)function), pair = (uint32_t)function % 6u;
    /* The six pairs of the four. */
    uint32_t first = pair < 3 ? 0 : pair < 5 ? 1 : 2;
    uint32_t second = pair < 3 ? pair + 1 : pair < 5 ? pair - 1 : 3;
    uint32_t a = bn_domain_child(parent, first);
    uint32_t b = bn_domain_child(where == TWO_FAMILIES ? a : parent, second);
    for (int k = 0; k < 2; ++k) {
        normal[k][2] = 0.5 * (normal[k][0] + normal[k][1]) + 0.1 * sin(5.0 * angle + k);
        for (int i = 0; i < GRID * GRID; ++i) {
            mean[k] +=
                normal[k][0] * (i % GRID + 0.5) / GRID + normal[k][1] * (i / GRID + 0.5) / GRID <
                normal[k][2];
        }
        mean[k] /= GRID * GRID;
    }
    for (int32_t pixel = 0; pixel < SIDE * SIDE; ++pixel) {
        const int32_t x = 33 * (pixel % SIDE), y = 33 * (pixel / SIDE);
        double sum = 0.0;
        for (uint32_t i = 0; i < count; ++i) {
            float u[4], v[4];
            bn_sample_4d(s, x, y, i, a, u);
            bn_sample_4d(s, x, y, i, b, v);
            const float *w = where == ONE_DOMAIN ? u + 2 : v;
            sum += normal[0][0] * u[0] + normal[0][1] * u[1] < normal[0][2] &&
                   normal[1][0] * w[0] + normal[1][1] * w[1] < normal[1][2];
        }
        square += pow(sum / count - mean[0] * mean[1], 2.0);
    }
    return square / (SIDE * SIDE);
}

static void test_products(void) {
    enum { FUNCTIONS = 48 };
    static const char *const names[] = {"a domain", "a family", "two families"};
    /* At 4, 16 and 64 samples. */
    static const double limits[3][3] = {{1.04, 0.80, 0.66}, {1.04, 0.97, 0.74}, {1.04, 1.04, 1.04}};
    const bn_sampler blue = make_sampler(BN_SAMPLER_BLUE, 0, SEED),
                     sobol = make_sampler(BN_SAMPLER_SOBOL, 0, SEED);
    for (int where = ONE_DOMAIN; where <= TWO_FAMILIES; ++where) {
        for (int power = 0; power < 3; ++power) {
            double b = 0.0, s = 0.0;
            for (int f = 0; f < FUNCTIONS; ++f) {
                b += product_error(&blue, f, 4u << 2 * power, (relation)where);
                s += product_error(&sobol, f, 4u << 2 * power, (relation)where);
            }
            printf("products in %s, %u samples: error %.3f of SOBOL's\n", names[where],
                   4u << 2 * power, sqrt(b / s));
            CHECK(sqrt(b / s) < limits[where][power]);
        }
    }
}

int main(void) {
    test_coincidences();
    test_pixel_correlation();
    test_screen_correlation();
    test_products();
    return check_result();
}
