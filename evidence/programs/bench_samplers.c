/* SPDX-License-Identifier: Apache-2.0
 * What samplers that libbn does not have draw, for scripts/bench samplers:
 *
 *     bench_samplers NAME SPP DOMAINS
 *
 * writes float32 [DOMAINS][128 rows][PLACES][128 pixels][SPP][4] to standard output, without a header.
 * Domain d has the seed d + 1. Places are children of one parent by the keys 4 d to 4 d + 3, the first
 * of them again, and one with another key. sobol4d is the path tracer's; OpenQMC's samplers are there
 * in builds with -DBN_OPENQMC=DIR. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/pathtracer/sobol4d.h"
#include "bench_openqmc.h"

enum { SIZE = 128, DOMAINS = 16, PLACES = 6, MOST = 4096 };

static void sobol4d_read_row(uint32_t seed, uint32_t parent, uint32_t key, int32_t y, int32_t width,
                             uint32_t count, float *out) {
    (void)parent; /* the key of its child is different for every parent here */
    for (int32_t x = 0; x < width; ++x) {
        for (uint32_t index = 0; index < count; ++index, out += 4)
            sobol4d_draw(seed, x, y, index, key, out);
    }
}

int main(int argc, char **argv) {
    static float samples[SIZE * MOST * 4];
    static const bench_peer sobol4d = {"sobol4d", NULL, sobol4d_read_row};
    const bench_peer *peer = &sobol4d;
    const int count = argc == 4 ? atoi(argv[2]) : 0, domains = argc == 4 ? atoi(argv[3]) : 0;
    for (int i = 0; i < bench_peer_count && argc == 4; ++i) {
        if (strcmp(argv[1], bench_peers[i].name) == 0) peer = &bench_peers[i];
    }
    if (count < 1 || count > MOST || strcmp(argv[1], peer->name) != 0) {
        fputs("usage: bench_samplers NAME SPP DOMAINS\n", stderr);
        return 2;
    }
    for (int domain = 0; domain < domains; ++domain) {
        const int keys[PLACES] = {0, 1, 2, 3, 0, domain % 4 + 4 * DOMAINS};
        for (int i = 0; i < SIZE * PLACES; ++i) {
            const uint32_t parent = (uint32_t)domain + 1u;
            const uint32_t key = (uint32_t)(4 * domain + keys[i % PLACES]);
            const size_t size = (size_t)SIZE * (size_t)count * 4;
            peer->read_row(parent, parent, key, i / PLACES, SIZE, (uint32_t)count, samples);
            if (fwrite(samples, sizeof *samples, size, stdout) != size) return 1;
        }
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
