/* SPDX-License-Identifier: Apache-2.0
 * Numbers of different decisions are not tied: for every kind, and for the sobol4d of the path tracer,
 * over all pairs of coordinates of a path's first rays, further numbers and splits.
 *
 * A tie is a sum modulo 2 of leading digits of two coordinates that is the same in all samples of a
 * region: half of the cells of the two numbers then stay empty, and a product over both decisions
 * converges to something else. Nothing is random but by seeds. --print prints the worst of each kind. */
#include "../../examples/pathtracer/sobol4d.h"
#include "../c/samplers.h"
#include <bn/bn_path.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SOBOL4D = KINDS, SOURCES };
static const char *const names[SOURCES] = {"blue", "sobol", "white", "zorder", "mask", "sobol4d"};

enum { DOMAINS = 16, COORDINATES = 4 * DOMAINS, DIGITS = 4, PARITIES = (1 << DIGITS) - 1 };

/* The first rays of a path, the camera's domain, two families of single numbers, pairs, fours, a loop
 * and rays of two branches. */
static void path_domains(uint32_t domain[DOMAINS], int is_single[DOMAINS]) {
    const bn_path path = bn_path_start(0, 0, 0, 0);
    bn_ray first = bn_path_ray(&path, 0), second = bn_path_ray(&path, 1);
    const bn_split split = bn_ray_split(&second, 4);
    const bn_path branch = bn_split_path(&split, 0);
    int n = 0;
    for (uint32_t ray = 0; ray < 5; ++ray) domain[n++] = bn_path_ray_domain(path, ray);
    domain[n++] = bn_path_camera_domain(path);
    domain[n++] = bn_ray_2d_domain(first.domain, 0);
    domain[n++] = bn_ray_2d_domain(second.domain, 0);
    domain[n++] = bn_ray_4d_domain(first.domain, 0);
    domain[n++] = bn_ray_4d_domain(second.domain, 0);
    domain[n++] = bn_ray_split_domain(second.domain, 1);
    domain[n++] = bn_path_ray_domain(branch, 0);
    domain[n++] = bn_path_ray_domain(branch, 1);
    memset(is_single, 0, DOMAINS * sizeof *is_single);
    for (int k = 0; k < 3; ++k) {
        is_single[n] = 1;
        domain[n++] = bn_ray_1d_domain(k < 2 ? first.domain : second.domain, 4u * (k % 2));
    }
}

static uint32_t domains[DOMAINS];
static int singles[DOMAINS];

static void draw(int source, const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, int d,
                 float out[4]) {
    if (source == SOBOL4D) {
        sobol4d_draw(7, x, y, index, domains[d], out);
    } else if (singles[d]) {
        bn_sample_pair(sampler, x, y, index, domains[d], 2, out);
        bn_sample_pair(sampler, x, y, index, domains[d], 3, out + 2);
    } else {
        bn_sample_4d(sampler, x, y, index, domains[d], out);
    }
}

static bn_sampler sampler_of_source(int source, uint32_t count, uint64_t seed) {
    return source == SOBOL4D ? bn_sampler_make(BN_SAMPLER_WHITE, seed)
                             : make_sampler(source, count, seed);
}

/* ---- Parities in small regions */

enum { REGIONS = 6, SIDE = 8, SAMPLES = 64, BITS = SIDE * SIDE * SAMPLES, WORDS = BITS / 64 };
static uint64_t parity[COORDINATES][PARITIES][WORDS];

static int ones_of(uint64_t v) {
    v -= v >> 1 & 0x5555555555555555u;
    v = (v & 0x3333333333333333u) + (v >> 2 & 0x3333333333333333u);
    v = (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return (int)(v * 0x0101010101010101u >> 56);
}

static void draw_region(int source, const bn_sampler *sampler, int32_t x0, int32_t y0) {
    memset(parity, 0, sizeof parity);
    for (int bit = 0; bit < BITS; ++bit) {
        const int pixel = bit / SAMPLES;
        for (int d = 0; d < DOMAINS; ++d) {
            float u[4];
            draw(source, sampler, x0 + pixel % SIDE, y0 + pixel / SIDE, (uint32_t)(bit % SAMPLES),
                 d, u);
            for (int k = 0; k < 4; ++k) {
                uint32_t digits = (uint32_t)(u[k] * (1 << DIGITS));
                for (uint32_t mask = 1; mask <= PARITIES; ++mask) {
                    parity[4 * d + k][mask - 1][bit / 64] |= (uint64_t)(ones_of(digits & mask) & 1)
                                                             << bit % 64;
                }
            }
        }
    }
}

/* The largest correlation of two parities of different domains, rms over regions: 1 where they are
 * tied, about 1 / 64 where they are independent. */
static double worst_tie(int source) {
    static float squares[COORDINATES * PARITIES][COORDINATES * PARITIES];
    double worst = 0.0;
    memset(squares, 0, sizeof squares);
    for (int region = 0; region < REGIONS; ++region) {
        const bn_sampler sampler = sampler_of_source(source, SAMPLES, (uint64_t)region + 3u);
        draw_region(source, &sampler, 40 * region - 90, 24 * region * region - 200);
        for (int a = 0; a < COORDINATES * PARITIES; ++a) {
            const uint64_t *p = parity[a / PARITIES][a % PARITIES];
            for (int b = 0; b < a / PARITIES / 4 * 4 * PARITIES; ++b) {
                const uint64_t *q = parity[b / PARITIES][b % PARITIES];
                int ones = 0;
                for (int i = 0; i < WORDS; ++i) ones += ones_of(p[i] ^ q[i]);
                const double correlation = 1.0 - 2.0 * ones / BITS;
                squares[a][b] += (float)(correlation * correlation / REGIONS);
                if (squares[a][b] > worst) worst = squares[a][b];
            }
        }
    }
    return sqrt(worst);
}

/* ---- Cells in a large picture */

/* The smallest share of its due that any of 8 x 8 cells gets of a picture, over all pairs of
 * coordinates of different domains. */
static double emptiest_cell(int source) {
    enum { PICTURE = 256, CELLS = 64 };
    static int cells[COORDINATES][COORDINATES][CELLS];
    const bn_sampler sampler = sampler_of_source(source, 1, 9);
    int least = PICTURE * PICTURE;
    memset(cells, 0, sizeof cells);
    for (int pixel = 0; pixel < PICTURE * PICTURE; ++pixel) {
        uint32_t at[COORDINATES];
        for (int d = 0; d < DOMAINS; ++d) {
            float u[4];
            draw(source, &sampler, pixel % PICTURE, pixel / PICTURE, 0, d, u);
            for (int k = 0; k < 4; ++k) at[4 * d + k] = (uint32_t)(8.0f * u[k]);
        }
        for (int a = 0; a < COORDINATES; ++a) {
            for (int b = 0; b < a / 4 * 4; ++b) ++cells[a][b][at[a] * 8u + at[b]];
        }
    }
    for (int a = 0; a < COORDINATES; ++a) {
        for (int b = 0; b < a / 4 * 4; ++b) {
            for (int i = 0; i < CELLS; ++i) least = cells[a][b][i] < least ? cells[a][b][i] : least;
        }
    }
    return (double)least * CELLS / (PICTURE * PICTURE);
}

int main(int argc, char **argv) {
    const int print = argc > 1 && strcmp(argv[1], "--print") == 0;
    int failed = 0;
    path_domains(domains, singles);
    for (int source = 0; source < SOURCES; ++source) {
        const double tie = worst_tie(source), cell = emptiest_cell(source);
        /* The first sample of MASK is a mask, shifted for each coordinate: one pair of coordinates in
         * 4,096 has one shift. */
        const int bad = !(tie < 0.5 && (cell > 0.75 || source == BN_SAMPLER_MASK));
        if (bad || print) {
            printf("%s: correlation of two parities up to %.3f, cells with %.3f of their due or "
                   "more%s\n",
                   names[source], tie, cell, bad ? " FAILED" : "");
        }
        failed += bad;
    }
    printf("%d samplers tie numbers\n", failed);
    return failed > 0;
}
