/* SPDX-License-Identifier: Apache-2.0
 * Many draws at once. What depends on the pixel alone is done once for all its indices; runs of
 * eight indices are drawn by the vector code of simd/ where the machine has it. */
#include "sampler.h"
#include "simd/simd.h"
#include <string.h>

/* Symmetries are loaded as aligned registers; see bn_draw.h. */
_Static_assert(offsetof(bn_sampler, table) % 16 == 0, "alignment");
_Static_assert(offsetof(bn_draw_table, symmetry) % 16 == 0, "alignment");

static bn_block_runs *vector_code(int32_t kind) {
    if (kind != BN_SAMPLER_BLUE && kind != BN_SAMPLER_SOBOL && kind != BN_SAMPLER_WHITE) {
        return NULL;
    }
#if defined(BN_SIMD_X86)
    const char *set = bn_simd_get()->name;
    if (strcmp(set, "avx512") == 0) return bn_block_runs_avx512;
    if (strcmp(set, "avx2") == 0) return bn_block_runs_avx2;
#endif
    return NULL;
}

void bn_block_prepare(bn_block_plan *plan, const bn_draw_table *table) {
    plan->runs = vector_code(table->kind);
    for (uint32_t d = 0; d < 256u; ++d) {
        uint32_t at = (d & 31u) * 8u + (d >> 5);
        plan->rows.x[at] = table->digits.x[d];
        plan->rows.y[at] = table->digits.y[d];
        plan->rows.flip[d] = bn_draw_flip(d);
        if (d % 32u == 0) {
            for (uint32_t k = 0; k < 8u; ++k) plan->rows.upper[k][d / 32u] = table->order[k][d];
        }
    }
}

/* Some indices of one pixel, one by one. */
static void draw_singly(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t first,
                        uint32_t count, uint32_t domain, float *out) {
    const bn_draw_table *table = &sampler->table;
    if (table->kind == BN_SAMPLER_BLUE) {
        const bn_blue_pixel pixel = bn_draw_blue_pixel(table, x, y, domain);
        for (uint32_t i = 0; i < count; ++i, out += 4) {
            uint32_t bits[4];
            bn_draw_blue_at(table, &pixel, first + i, bits);
            for (int d = 0; d < 4; ++d) out[d] = bn_draw_float(bits[d]);
        }
    } else {
        for (uint32_t i = 0; i < count; ++i, out += 4) {
            bn_sample_4d(sampler, x, y, first + i, domain, out);
        }
    }
}

/* Part of a run: as a whole aside when it is worth it. */
static void draw_part(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t first,
                      uint32_t count, uint32_t domain, float *out) {
    enum { SINGLY = 3 };
    float aside[4 * BN_RUN];
    if (count == 0) return;
    if (count < SINGLY) {
        draw_singly(sampler, x, y, first, count, domain, out);
        return;
    }
    uint32_t skipped = first % BN_RUN;
    sampler->block.runs(&sampler->table, &sampler->block.rows, x, y, domain, first - skipped, 1,
                        aside);
    memcpy(out, aside + 4 * skipped, 4 * (size_t)count * sizeof *out);
}

bn_result bn_sample_block(const bn_sampler *sampler, int32_t x0, int32_t y0, uint32_t width,
                          uint32_t height, uint32_t first_index, uint32_t index_count,
                          uint32_t domain, float *out, size_t out_count) {
    if (sampler == NULL || out == NULL || width == 0 || height == 0 || index_count == 0) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    if (width - 1u > (uint32_t)INT32_MAX - (uint32_t)x0 ||
        height - 1u > (uint32_t)INT32_MAX - (uint32_t)y0 ||
        index_count - 1u > UINT32_MAX - first_index) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    /* The product without overflow: three divisions instead of one multiplication. */
    size_t pixels = out_count / 4u / index_count;
    if (out_count % 4u != 0 || out_count / 4u % index_count != 0 || pixels % width != 0 ||
        pixels / width != height) {
        return BN_ERROR_SIZE_MISMATCH;
    }

    /* The indices before the first whole run, and those after the last. */
    uint32_t before = (0u - first_index) % BN_RUN;
    if (before > index_count) before = index_count;
    const uint32_t run_count = (index_count - before) / BN_RUN;
    const uint32_t after = index_count - before - run_count * BN_RUN;
    bn_block_runs *const runs = sampler->block.runs;

    for (uint32_t row = 0; row < height; ++row) {
        for (uint32_t column = 0; column < width; ++column) {
            int32_t x = (int32_t)((uint32_t)x0 + column), y = (int32_t)((uint32_t)y0 + row);
            if (runs == NULL || index_count == 1) {
                draw_singly(sampler, x, y, first_index, index_count, domain, out);
            } else {
                draw_part(sampler, x, y, first_index, before, domain, out);
                if (run_count > 0) {
                    runs(&sampler->table, &sampler->block.rows, x, y, domain, first_index + before,
                         run_count, out + 4 * (size_t)before);
                }
                draw_part(sampler, x, y, first_index + before + run_count * BN_RUN, after, domain,
                          out + 4 * ((size_t)before + (size_t)run_count * BN_RUN));
            }
            out += 4 * (size_t)index_count;
        }
    }
    return BN_SUCCESS;
}
