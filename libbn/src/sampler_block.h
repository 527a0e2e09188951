/* SPDX-License-Identifier: Apache-2.0
 * What bn_sample_block() keeps in a sampler and shares with its vector code in simd/. */
#ifndef BN_SAMPLER_BLOCK_H
#define BN_SAMPLER_BLOCK_H

/* Before bn_draw.h, which then uses it. */
#if (defined(__x86_64__) || defined(_M_X64)) && !defined(_M_ARM64EC)
#include <emmintrin.h>
#endif

#include <bn/bn_draw.h>

enum { BN_RUN = 8 };

/* The fixed point set for runs of eight consecutive indices, which begin at a multiple of eight: in
 * a nested order they differ in the three upper bits of their digits alone, so that all of them
 * find their coordinates in one row of eight. */
typedef struct bn_block_rows {
    uint32_t x[256], y[256]; /* of the digits d, at (d & 31) * 8 + (d >> 5) */
    uint32_t flip[256];      /* bn_draw_flip() */
    uint32_t upper[8][8];    /* the orders of digits whose upper three bits alone are not zero */
} bn_block_rows;

/* Draws `runs` runs of a pixel from index `first` on, a multiple of BN_RUN: out[runs][BN_RUN][4].
 * The kinds BLUE, SOBOL and WHITE. */
typedef void bn_block_runs(const bn_draw_table *table, const bn_block_rows *rows, int32_t x,
                           int32_t y, uint32_t domain, uint32_t first, uint32_t runs, float *out);

bn_block_runs bn_block_runs_avx2, bn_block_runs_avx512;

/* The vector code for this machine and kind, or NULL, and its rows. */
typedef struct bn_block_plan {
    bn_block_runs *runs;
    bn_block_rows rows;
} bn_block_plan;

void bn_block_prepare(bn_block_plan *plan, const bn_draw_table *table);

#endif
