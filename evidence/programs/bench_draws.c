/* SPDX-License-Identifier: Apache-2.0
 * Nanoseconds per draw on one core, as CSV on standard output:
 *
 *     sampler,form,nanoseconds
 *
 * All forms make four-dimensional draws as a path does: pixel by pixel, with 16 indices per pixel and
 * six domains per index, which are the root's children with keys 0 to 5. `single` calls the library's
 * bn_sample_4d(), `inline` calls the inline function in bn_draw.h, and `peer` calls another library as
 * its documentation recommends (bench_openqmc.cpp, with -DBN_OPENQMC=DIR). `block` uses no domains: it
 * calls bn_sample_block() for 16 indices of 64 x 24 pixels.
 *
 * Two forms make the same draws for the lanes of a wavefront, whose arguments and results are arrays:
 * `lanes` calls the library's bn_sample_4d() for each lane, and `many` calls bn_sample_wavefront() once
 * for all lanes. BN_SIMD selects the instruction set.
 *
 * Each time is the minimum of ROUNDS short, interleaved measurements, so that other jobs have no effect. In
 * each round, a form runs twice, and its first run warms the caches. */
#include <bn/bn.h>

/* Calls the library's function, before bn_path.h replaces it with an inline function. */
static inline void call_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                           uint32_t domain, float out[4]) {
    bn_sample_4d(sampler, x, y, index, domain, out);
}

#include <bn/bn_path.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bench_openqmc.h"

enum { WIDTH = 64, HEIGHT = 4, INDICES = 16, DOMAINS = 6, KINDS = 5 };
enum { DRAWS = WIDTH * HEIGHT * INDICES * DOMAINS, ROUNDS = 400 };

static const char *const kind_names[KINDS] = {"blue", "sobol", "white", "zorder", "mask"};
static volatile float sink;

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

/* Each loop is a separate function, so that its machine code does not depend on the others. */
typedef float form(const bn_sampler *sampler, int32_t y0, float *block);

/* One draw for each domain of each index of each pixel. */
#define FOR_DRAWS                                                                                  \
    for (int32_t y = y0; y < y0 + HEIGHT; ++y)                                                     \
        for (int32_t x = 0; x < WIDTH; ++x)                                                        \
            for (uint32_t index = 0; index < INDICES; ++index)                                     \
                for (uint32_t key = 0; key < DOMAINS; ++key)

#define FORM(name, draw)                                                                           \
    static float name(const bn_sampler *sampler, int32_t y0, float *block) {                       \
        float sum = 0.0f;                                                                          \
        (void)block;                                                                               \
        FOR_DRAWS {                                                                                \
            float u[4] = {0.0f};                                                                   \
            draw;                                                                                  \
            sum += u[0] + u[1] + u[2] + u[3];                                                      \
        }                                                                                          \
        return sum;                                                                                \
    }

#define CHILD bn_domain_child(BN_DOMAIN_ROOT, key)
#define INLINE_CHILD bn_draw_domain_child(BN_DOMAIN_ROOT, key)

FORM(draw_single, call_4d(sampler, x, y, index, CHILD, u))
FORM(draw_inline, bn_draw_4d(sampler, x, y, index, INLINE_CHILD, u))

static float draw_block(const bn_sampler *sampler, int32_t y0, float *block) {
    if (bn_sample_block(sampler, 0, y0, WIDTH, HEIGHT * DOMAINS, 0, INDICES, 1, block, 4 * DRAWS) !=
        BN_SUCCESS) {
        exit(1);
    }
    return block[0] + block[4 * DRAWS - 1];
}

/* The arguments of all draws as arrays. */
static struct {
    int32_t x[DRAWS], y[DRAWS];
    uint32_t index[DRAWS], domain[DRAWS];
} lanes;

static void fill_lanes(void) {
    for (uint32_t i = 0; i < DRAWS; ++i) {
        const uint32_t pixel = i / DOMAINS / INDICES;
        lanes.x[i] = (int32_t)(pixel % WIDTH);
        lanes.y[i] = (int32_t)(pixel / WIDTH);
        lanes.index[i] = i / DOMAINS % INDICES;
        lanes.domain[i] = bn_domain_child(BN_DOMAIN_ROOT, i % DOMAINS);
    }
}

static float draw_lanes(const bn_sampler *sampler, int32_t y0, float *block) {
    (void)y0;
    for (size_t i = 0; i < DRAWS; ++i) {
        call_4d(sampler, lanes.x[i], lanes.y[i], lanes.index[i], lanes.domain[i], block + 4 * i);
    }
    return block[0] + block[4 * DRAWS - 1];
}

static float draw_many(const bn_sampler *sampler, int32_t y0, float *block) {
    bn_wavefront all = bn_wavefront_default();
    (void)y0;
    all.count = DRAWS;
    all.x = lanes.x;
    all.y = lanes.y;
    all.index = lanes.index;
    all.domain = lanes.domain;
    for (int d = 0; d < 4; ++d) all.out[d] = block + d;
    all.stride = 4;
    if (bn_sample_wavefront(sampler, &all) != BN_SUCCESS) exit(1);
    return block[0] + block[4 * DRAWS - 1];
}

typedef struct row {
    const char *sampler, *form_name;
    form *draw; /* or null: */
    const bn_sampler *instance;
    const bench_peer *peer;
    double best;
} row;

static void measure(row *r, unsigned round, float *block) {
    int32_t y0 = (int32_t)(round % 16u * HEIGHT);
    double start = now(), elapsed;
    sink = r->draw != NULL ? r->draw(r->instance, y0, block)
                           : r->peer->draw(y0, WIDTH, HEIGHT, INDICES, DOMAINS);
    elapsed = (now() - start) / DRAWS;
    if (elapsed < r->best) r->best = elapsed;
}

int main(void) {
    static const struct {
        const char *name;
        form *draw;
    } forms[] = {{"single", draw_single},
                 {"block", draw_block},
                 {"lanes", draw_lanes},
                 {"many", draw_many},
                 /* For the other sampler types, these call the library. */
                 {"inline", draw_inline}};
    enum { FORMS = sizeof forms / sizeof *forms, CALLS = FORMS - 1 };
    static row rows[FORMS * KINDS + BENCH_PEERS];
    bn_sampler samplers[KINDS];
    int count = 0;
    static float block[4 * DRAWS];
    fill_lanes();
    for (int32_t kind = 0; kind < KINDS; ++kind) {
        bn_sampler_init(&samplers[kind], kind, 0);
        for (int i = 0; i < (kind <= BN_SAMPLER_WHITE ? FORMS : CALLS); ++i) {
            rows[count++] = (row){.sampler = kind_names[kind],
                                  .form_name = forms[i].name,
                                  .draw = forms[i].draw,
                                  .instance = &samplers[kind],
                                  .best = 1e30};
        }
    }
    for (int i = 0; i < bench_peer_count; ++i) {
        rows[count++] = (row){bench_peers[i].name, "peer", NULL, NULL, &bench_peers[i], 1e30};
        sink = bench_peers[i].draw(0, 1, 1, 1, 1); /* fills its tables */
    }
    for (unsigned round = 0; round < ROUNDS; ++round) {
        for (int i = 0; i < 2 * count; ++i) measure(&rows[i / 2], round, block);
    }
    printf("sampler,form,nanoseconds\n");
    for (int i = 0; i < count; ++i)
        printf("%s,%s,%.2f\n", rows[i].sampler, rows[i].form_name, rows[i].best);
    return 0;
}
