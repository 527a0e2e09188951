/* SPDX-License-Identifier: Apache-2.0
 * Draws for wavefronts, one sample per lane, from arrays of arguments. simd/draws.h draws eight lanes at a time
 * where it can, and single draws do the rest. Results are drawn in place if the requested dimensions are
 * adjacent in memory, and otherwise into a buffer from which they are scattered. */
#include "base/options.h"
#include "sampler/types.h"
#include <bn/bn_path.h>
#include <string.h>

/* Draws out[lane][dimensions], one lane after another. */
static void draw_single(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                        const bn_draw_lanes *lanes, float *out) {
    for (size_t i = 0; i < lanes->count; ++i, out += dimensions) {
        const int32_t x = lanes->x[i], y = lanes->y[i];
        const uint32_t index = lanes->index[i], domain = lanes->domain[i];
        if (dimensions == 1) {
            *out = bn_sample_1d(sampler, x, y, index, domain);
        } else if (dimensions == 2) {
            bn_sample_2d(sampler, x, y, index, domain, pair, out);
        } else {
            float u[4];
            bn_sample_4d(sampler, x, y, index, domain, u);
            memcpy(out, u, dimensions * sizeof *out);
        }
    }
}

/* Draws out[lane][dimensions]: dimension 0, a pair, or the first three or four dimensions. */
static void draw_any(const bn_sampler *sampler, uint32_t pair, uint32_t dimensions,
                     const bn_draw_lanes *lanes, float *out) {
    const bn_simd *simd = bn_simd_get();
    if (simd->draw_many != NULL && bn_sampler_types[sampler->type].in_lanes) {
        simd->draw_many(sampler, pair, dimensions, lanes, out);
    } else {
        draw_single(sampler, pair, dimensions, lanes, out);
    }
}

/* ---- Wavefronts, in parts that stay in the cache */

enum { PART = 256 }; /* lanes: 8 KiB of arguments and results */

/* The lanes `first` to `first + count - 1`. `own` replaces missing arrays. */
static bn_draw_lanes part_of(const bn_wavefront *w, size_t first, size_t count,
                             uint32_t own[2][PART]) {
    bn_draw_lanes part = {count, w->x + first, w->y + first, own[0], own[1]};
    if (w->index != NULL) part.index = w->index + first;
    if (w->domain != NULL && w->depth == NULL) part.domain = w->domain + first;
    for (size_t i = 0; w->index == NULL && i < count; ++i) own[0][i] = w->shared_index;
    if (part.domain != own[1]) return part;
    for (size_t i = 0; i < count; ++i) {
        bn_path path = {0, 0, 0, w->domain != NULL ? w->domain[first + i] : w->shared_domain};
        own[1][i] = w->depth == NULL ? path.domain : bn_path_ray_domain(path, w->depth[first + i]);
    }
    return part;
}

/* The number of requested dimensions, if all of them are adjacent in memory; otherwise 0. */
static uint32_t side_by_side(float *const out[], uint32_t dimensions, size_t stride) {
    uint32_t count = 0;
    while (count < dimensions && out[count] != NULL && out[count] == out[0] + count) ++count;
    for (uint32_t d = count; d < dimensions; ++d) {
        if (out[d] != NULL) return 0;
    }
    return count == stride ? count : 0;
}

bn_result bn_sample_wavefront(const bn_sampler *sampler, const bn_wavefront *wavefront) {
    bn_wavefront w = bn_wavefront_default();
    if (sampler == NULL || wavefront == NULL) return BN_ERROR_INVALID_ARGUMENT;
    const bn_result result = bn_options_read(&w, sizeof w, wavefront);
    if (result != BN_SUCCESS) return result;
    const int first_pair = w.out[0] != NULL || w.out[1] != NULL;
    const int second_pair = w.out[2] != NULL || w.out[3] != NULL;
    if (!first_pair && !second_pair) return BN_ERROR_INVALID_ARGUMENT;
    if (w.count > 0 && (w.x == NULL || w.y == NULL)) return BN_ERROR_INVALID_ARGUMENT;

    if (w.stride == 0) return BN_ERROR_INVALID_ARGUMENT;
    const uint32_t pair = first_pair ? 0 : 1, dimensions = first_pair && second_pair ? 4 : 2;
    float *const *out = w.out + 2 * pair;
    uint32_t together = side_by_side(out, dimensions, w.stride);
    if (pair == 1 && together == 1) together = 0; /* single draws supply only dimension 0 */
    for (size_t at = 0; at < w.count; at += PART) {
        uint32_t own[2][PART];
        float u[4 * PART];
        const size_t count = w.count - at < PART ? w.count - at : PART;
        const bn_draw_lanes part = part_of(&w, at, count, own);
        if (together > 0) {
            draw_any(sampler, pair, together, &part, out[0] + at * together);
            continue;
        }
        draw_any(sampler, pair, dimensions, &part, u);
        for (uint32_t d = 0; d < dimensions; ++d) {
            for (size_t i = 0; out[d] != NULL && i < count; ++i) {
                /* draw_any() writes all of them. NOLINTNEXTLINE(*-core.uninitialized.Assign) */
                out[d][(at + i) * w.stride] = u[dimensions * i + d];
            }
        }
    }
    return BN_SUCCESS;
}
