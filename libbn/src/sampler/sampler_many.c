/* SPDX-License-Identifier: Apache-2.0
 * Draws for arrays of lanes. simd/draws.h draws several at a time. */
#include "sampler/sampler_object.h"

static void draw_single(const bn_sampler *sampler, uint32_t dimensions, const bn_draw_lanes *lanes,
                        float *out) {
    for (size_t i = 0; i < lanes->count; ++i, out += dimensions) {
        float u[4], *to = dimensions == 4 ? out : u;
        bn_sample_4d(sampler, lanes->x[i], lanes->y[i], lanes->index[i], lanes->domain[i], to);
        if (to == u) {
            out[0] = u[0];
            if (dimensions > 1) out[1] = u[1];
            if (dimensions > 2) out[2] = u[2];
        }
    }
}

bn_result bn_sample_many(const bn_sampler *sampler, size_t count, const int32_t *x,
                         const int32_t *y, const uint32_t *index, const uint32_t *domain,
                         uint32_t dimensions, float *out, size_t out_count) {
    const bn_draw_lanes lanes = {count, x, y, index, domain};
    if (sampler == NULL || dimensions < 1 || dimensions > 4) return BN_ERROR_INVALID_ARGUMENT;
    if (count > 0 && (x == NULL || y == NULL || index == NULL || domain == NULL || out == NULL)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    /* By division, which cannot overflow. */
    if (out_count % dimensions != 0 || out_count / dimensions != count) {
        return BN_ERROR_SIZE_MISMATCH;
    }
    if (sampler->simd->draw_many != NULL && sampler->table.kind <= BN_SAMPLER_WHITE) {
        sampler->simd->draw_many(sampler->words, sampler->table.kind, dimensions, &lanes, out);
    } else {
        draw_single(sampler, dimensions, &lanes, out);
    }
    return BN_SUCCESS;
}
