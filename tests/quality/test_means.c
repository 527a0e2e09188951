/* SPDX-License-Identifier: Apache-2.0
 * What no pixel of a picture by itself can show: the mean of a whole picture, and the errors of places
 * 64 pixels apart, for BLUE, whose pixels share a tile of that size.
 *
 * Everything is seeded; false-alarm rates are for fresh seeds. --print prints all figures. */
#include "../c/samplers.h"
#include "half_planes.h"
#include <bn/bn_draw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int print, failed;

static void check(const char *what, int size, uint32_t count, double figure, double limit) {
    const int bad = !(figure < limit);
    if (bad || print) {
        printf("%s, %dx%d pixels, %u samples: %.3f, limit %.3f%s\n", what, size, size, count,
               figure, limit, bad ? " FAILED" : "");
    }
    failed += bad;
}

/* ---- Integrands: products of half-planes, whose planes are at random */

static double random_number(void) {
    static uint64_t state = 1;
    uint64_t v = state += 0x9e3779b97f4a7c15u;
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return (double)((v ^ (v >> 31)) >> 11) * 0x1p-53;
}

enum { PAIR, BOTH_PAIRS, TWO_MEMBERS, THREE_MEMBERS, TWO_FAMILIES, SINGLE, WHATS };
static const char *const names[WHATS] = {"one pair",      "both pairs",   "two members",
                                         "three members", "two families", "a single number"};

typedef struct integrand {
    int what, count; /* of factors */
    half_plane plane[3];
    uint32_t domain[3], pair[3];
    double mean;
} integrand;

static integrand integrand_make(int what, uint32_t number) {
    const uint32_t parent = bn_domain_child(1, 4u * number), member = number % 4u;
    integrand f = {.what = what, .count = 2, .mean = 1.0};
    if (what == PAIR || what == SINGLE) f.count = 1;
    if (what == THREE_MEMBERS) f.count = 3;
    for (uint32_t i = 0; i < (uint32_t)f.count; ++i) {
        const double angle = 6.283185307179586 * random_number();
        f.plane[i] = half_plane_through(cos(angle), sin(angle), random_number(), random_number());
        if (what == SINGLE) {
            f.plane[i].c = f.plane[i].mean = random_number();
            f.plane[i].a = 1.0;
            f.plane[i].b = 0.0;
        }
        f.mean *= f.plane[i].mean;
        f.domain[i] = bn_domain_child(parent, what == BOTH_PAIRS ? member : (member + i) % 4u);
        f.pair[i] = (number + i) % 2u;
    }
    if (what == TWO_FAMILIES)
        f.domain[1] = bn_domain_child(parent, 4u * (1u + number % 3u) + number / 2u % 4u);
    if (what == SINGLE) f.pair[0] = 2u + f.pair[0];
    return f;
}

static int value_at(const integrand *f, const bn_sampler *sampler, int32_t x, int32_t y,
                    uint32_t index) {
    for (int i = 0; i < f->count; ++i) {
        float u[2];
        bn_sample_pair(sampler, x, y, index, f->domain[i], f->pair[i], u);
        if (!is_inside(&f->plane[i], u)) return 0;
    }
    return 1;
}

/* ---- Means of pictures */

/* The rms error of the mean of a picture over that of white noise, over many integrands. Each is at
 * most 1.25. With the digits of the tile alone and no others two members had 12.8 at 1024 x 1024. */
static void test_means(int size, uint32_t count, uint32_t integrands) {
    const bn_sampler sampler = bn_sampler_make(BN_SAMPLER_BLUE, 5);
    for (int what = 0; what < WHATS; ++what) {
        double squares = 0.0;
        for (uint32_t k = 0; k < integrands; ++k) {
            const integrand f = integrand_make(what, k);
            const double total = (double)size * size * count;
            double sum = 0.0;
            for (int32_t y = 0; y < size; ++y) {
                for (int32_t x = 0; x < size; ++x) {
                    for (uint32_t i = 0; i < count; ++i) sum += value_at(&f, &sampler, x, y, i);
                }
            }
            squares += pow(sum - total * f.mean, 2.0) / (total * f.mean * (1.0 - f.mean));
        }
        check(names[what], size, count, sqrt(squares / integrands), 1.25);
    }
}

/* ---- Places 64 pixels apart */

/* The correlation of errors 64 pixels apart, along rows and columns, over many integrands. */
static void test_tiles(uint32_t count) {
    enum { SIZE = 512, TILE = 64, INTEGRANDS = 24 };
    static double error[SIZE][SIZE];
    const bn_sampler sampler = bn_sampler_make(BN_SAMPLER_BLUE, 6);
    for (int what = 0; what < WHATS; ++what) {
        double products = 0.0, squares = 0.0;
        for (uint32_t k = 0; k < INTEGRANDS; ++k) {
            const integrand f = integrand_make(what, 100u + k);
            for (int32_t y = 0; y < SIZE; ++y) {
                for (int32_t x = 0; x < SIZE; ++x) {
                    int sum = 0;
                    for (uint32_t i = 0; i < count; ++i) sum += value_at(&f, &sampler, x, y, i);
                    error[y][x] = sum - count * f.mean;
                }
            }
            for (int y = 0; y < SIZE - TILE; ++y) {
                for (int x = 0; x < SIZE - TILE; ++x) {
                    products += error[y][x] * (error[y][x + TILE] + error[y + TILE][x]);
                    squares += 2.0 * error[y][x] * error[y][x];
                }
            }
        }
        char text[64];
        snprintf(text, sizeof text, "errors 64 pixels apart, %s", names[what]);
        check(text, SIZE, count, fabs(products / squares), 0.05);
    }
}

int main(int argc, char **argv) {
    print = argc > 1 && strcmp(argv[1], "--print") == 0;
    test_means(64, 1, 96);
    test_means(256, 1, 32);
    test_means(256, 16, 12);
    test_means(1024, 1, 12);
    test_tiles(1);
    printf("%d limits exceeded\n", failed);
    return failed > 0;
}
