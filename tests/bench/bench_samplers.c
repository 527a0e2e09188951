/* SPDX-License-Identifier: Apache-2.0
 * What samplers draw, for scripts/bench samplers:
 *
 *     bench_samplers NAME SPP [DOMAINS]
 *
 * writes float32 [DOMAINS][128 rows][PLACES][128 pixels][SPP][4] to standard output, without a header.
 * A domain is a member of a family, the number of the domain modulo 4, and has a seed of its own.
 * Places are the four members of its family, single numbers of the first of them (pairs 2 and 3 of
 * bn_sample_pair(); of other libraries the same draws again), and a member of another family of the
 * same parent. zorder is told SPP. sobol4d is the path tracer's. OpenQMC's samplers are there in
 * builds with -DBN_OPENQMC=DIR. */
#include <bn/bn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/pathtracer/sobol4d.h"
#include "bench_openqmc.h"

enum { SIZE = 128, DOMAINS = 16, MEMBERS = 4, SINGLE = MEMBERS, OTHER_FAMILY, PLACES };
enum { KINDS = 6, MOST = 4096 };

typedef struct source {
    const char *name;
    int32_t kind;
    const bench_peer *peer; /* or null: libbn's sampler of this kind */
} source;

static void sobol4d_read_row(uint32_t seed, uint32_t parent, uint32_t key, int32_t y, int32_t width,
                             uint32_t count, float *out) {
    (void)parent; /* the key of its child is different for every parent here */
    for (int32_t x = 0; x < width; ++x) {
        for (uint32_t index = 0; index < count; ++index, out += 4)
            sobol4d_draw(seed, x, y, index, key, out);
    }
}

static const bench_peer sobol4d = {"sobol4d", NULL, sobol4d_read_row};

static bn_sampler open_sampler(const source *s, int domain, uint32_t count) {
    bn_sampler sampler;
    bn_sampler_options options = bn_sampler_options_default();
    options.kind = s->peer == NULL ? s->kind : BN_SAMPLER_WHITE;
    options.seed = (uint64_t)domain + 1u;
    if (options.kind == BN_SAMPLER_ZORDER) options.samples_per_pixel = count;
    if (bn_sampler_init(&sampler, &options) != BN_SUCCESS) exit(1);
    return sampler;
}

/* A row of the picture at a place: [SIZE][count][4]. */
static void read_row(const source *s, const bn_sampler *sampler, int domain, int place, int row,
                     uint32_t count, float *out) {
    const int member = place < MEMBERS   ? place
                       : place == SINGLE ? 0
                                         : domain % MEMBERS + 4 * DOMAINS;
    const uint32_t parent = (uint32_t)domain + 1u, key = (uint32_t)(4 * domain + member);
    if (s->peer != NULL) {
        s->peer->read_row(parent, parent, key, row, SIZE, count, out);
    } else if (place == SINGLE) {
        const uint32_t own = bn_domain_child(bn_domain_child(BN_DOMAIN_ROOT, parent), key);
        for (uint32_t i = 0; i < SIZE * count; ++i) {
            const int32_t x = (int32_t)(i / count);
            bn_sample_pair(sampler, x, row, i % count, own, 2, out + 4 * (size_t)i);
            bn_sample_pair(sampler, x, row, i % count, own, 3, out + 4 * (size_t)i + 2);
        }
    } else if (bn_sample_block(sampler, 0, row, SIZE, 1, 0, count,
                               bn_domain_child(bn_domain_child(BN_DOMAIN_ROOT, parent), key), out,
                               (size_t)SIZE * count * 4) != BN_SUCCESS) {
        exit(1);
    }
}

static int write_samples(const source *s, uint32_t count, int domains) {
    const size_t size = (size_t)SIZE * count * 4;
    float *samples = malloc(size * sizeof *samples);
    int ok = samples != NULL;
    for (int domain = 0; domain < domains && ok; ++domain) {
        const bn_sampler sampler = open_sampler(s, domain, count);
        for (int i = 0; i < SIZE * PLACES && ok; ++i) {
            read_row(s, &sampler, domain, i % PLACES, i / PLACES, count, samples);
            ok = fwrite(samples, sizeof *samples, size, stdout) == size;
        }
    }
    free(samples);
    return ok && fflush(stdout) == 0 ? 0 : 1;
}

int main(int argc, char **argv) {
    source known[KINDS + BENCH_PEERS] = {
        {"white", BN_SAMPLER_WHITE, NULL}, {"sobol", BN_SAMPLER_SOBOL, NULL},
        {"sobol4d", 0, &sobol4d},          {"zorder", BN_SAMPLER_ZORDER, NULL},
        {"mask", BN_SAMPLER_MASK, NULL},   {"blue", BN_SAMPLER_BLUE, NULL}};
    const int count = argc > 2 ? atoi(argv[2]) : 0, domains = argc > 3 ? atoi(argv[3]) : DOMAINS;
    for (int i = 0; i < bench_peer_count; ++i)
        known[KINDS + i] = (source){bench_peers[i].name, 0, &bench_peers[i]};
    for (int i = 0; i < KINDS + bench_peer_count && count > 0 && count <= MOST; ++i) {
        if (strcmp(argv[1], known[i].name) == 0)
            return write_samples(&known[i], (uint32_t)count, domains);
    }
    fputs("usage: bench_samplers NAME SPP [DOMAINS]\n", stderr);
    return 2;
}
