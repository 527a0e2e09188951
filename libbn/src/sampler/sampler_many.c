/* SPDX-License-Identifier: Apache-2.0
 * Draws for arrays of lanes. simd/draws.h draws several at a time. */
#include "sampler/kinds.h"
#include <string.h>

static void draw_single(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                        const bn_draw_lanes *lanes, float *out) {
    for (size_t i = 0; i < lanes->count; ++i, out += dimensions) {
        const int32_t x = lanes->x[i], y = lanes->y[i];
        const uint32_t index = lanes->index[i], domain = lanes->domain[i];
        if (dimensions == 1) {
            *out = bn_sample_1d(sampler, x, y, index, domain);
        } else if (dimensions == 2) {
            bn_sample_pair(sampler, x, y, index, domain, pair, out);
        } else {
            float u[4];
            bn_sample_4d(sampler, x, y, index, domain, u);
            memcpy(out, u, dimensions * sizeof *out);
        }
    }
}

static bn_result draw_lanes(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                            const bn_draw_lanes *lanes, float *out, size_t out_count) {
    if (lanes->count > 0 && (lanes->x == NULL || lanes->y == NULL || lanes->index == NULL ||
                             lanes->domain == NULL || out == NULL)) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    /* By division, which cannot overflow. */
    if (out_count % dimensions != 0 || out_count / dimensions != lanes->count) {
        return BN_ERROR_SIZE_MISMATCH;
    }
    const bn_simd *simd = bn_simd_get();
    if (simd->draw_many != NULL && bn_kinds[sampler->kind].in_lanes) {
        simd->draw_many(sampler, pair, dimensions, lanes, out);
    } else {
        draw_single(sampler, pair, dimensions, lanes, out);
    }
    return BN_SUCCESS;
}

bn_result bn_sample_many(const bn_sampler *sampler, size_t count, const int32_t *x,
                         const int32_t *y, const uint32_t *index, const uint32_t *domain,
                         uint32_t dimensions, float *out, size_t out_count) {
    const bn_draw_lanes lanes = {count, x, y, index, domain};
    if (sampler == NULL || dimensions < 1 || dimensions > 4) return BN_ERROR_INVALID_ARGUMENT;
    return draw_lanes(sampler, 0, dimensions, &lanes, out, out_count);
}

bn_result bn_sample_many_pair(const bn_sampler *sampler, size_t count, const int32_t *x,
                              const int32_t *y, const uint32_t *index, const uint32_t *domain,
                              uint32_t pair, float *out, size_t out_count) {
    const bn_draw_lanes lanes = {count, x, y, index, domain};
    if (sampler == NULL || pair > 3) return BN_ERROR_INVALID_ARGUMENT;
    return draw_lanes(sampler, pair, 2, &lanes, out, out_count);
}
