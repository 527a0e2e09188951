/* SPDX-License-Identifier: Apache-2.0
 * OpenQMC's samplers for bench_draws.c. Needs a build with -DBN_OPENQMC=DIR. */
#ifndef BENCH_OPENQMC_H
#define BENCH_OPENQMC_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct bench_peer {
    const char *name; /* as in the path tracer */
    /* Makes 4-D draws as a path does: `domains` draws for each index of each pixel in the rows from
     * y0 on. Returns the sum of all numbers, so that the compiler removes none. */
    float (*draw)(int32_t y0, int32_t width, int32_t height, uint32_t indices, uint32_t domains);
} bench_peer;

enum { BENCH_PEERS = 3 };

#ifdef BN_WITH_OPENQMC
extern const bench_peer bench_peers[BENCH_PEERS];
enum { bench_peer_count = BENCH_PEERS };
#else
static const bench_peer bench_peers[BENCH_PEERS];
enum { bench_peer_count = 0 };
#endif

#ifdef __cplusplus
}
#endif

#endif
