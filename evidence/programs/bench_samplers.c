/* SPDX-License-Identifier: Apache-2.0
 * Prints the numbers of OpenQMC's samplers for scripts/bench samplers, in builds with -DBN_OPENQMC=DIR:
 *
 *     bench_samplers NAME SPP SEED
 *
 * writes float32 [MEMBERS][SIZE rows][SIZE pixels][SPP][4] to standard output, without a header. The
 * members are one parent's children with four consecutive keys. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_openqmc.h"

enum { SIZE = 64, MEMBERS = 4, MOST = 4096 };

int main(int argc, char **argv) {
    static float samples[SIZE * MOST * 4];
    const int count = argc == 4 ? atoi(argv[2]) : 0;
    const uint32_t seed = argc == 4 ? (uint32_t)atoi(argv[3]) : 0;
    for (int i = 0; i < bench_peer_count && count > 0 && count <= MOST; ++i) {
        if (strcmp(argv[1], bench_peers[i].name) != 0) continue;
        for (uint32_t row = 0; row < MEMBERS * SIZE; ++row) {
            const size_t size = (size_t)SIZE * (size_t)count * 4;
            bench_peers[i].read_row(seed, seed, 4 * seed + row / SIZE, (int32_t)(row % SIZE), SIZE,
                                    (uint32_t)count, samples);
            if (fwrite(samples, sizeof *samples, size, stdout) != size) return 1;
        }
        return fflush(stdout) == 0 ? 0 : 1;
    }
    fputs("usage: bench_samplers NAME SPP SEED, in a build with OpenQMC\n", stderr);
    return 2;
}
