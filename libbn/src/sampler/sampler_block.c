/* SPDX-License-Identifier: Apache-2.0
 * Blocks of draws. BLUE does the work that depends only on the pixel once for all indices. SOBOL and
 * WHITE can share little work, so they are drawn as lanes of a wavefront where that is faster. */
#include "base/assert.h"
#include "sampler/types.h"

/* Draws `count` samples of a pixel one after another. */
static void draw_pixel(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t first,
                       uint32_t count, uint32_t domain, float *out) {
    if (sampler->type != BN_SAMPLER_BLUE) {
        for (uint32_t i = 0; i < count; ++i) {
            bn_sample_4d(sampler, x, y, first + i, domain, out + 4 * (size_t)i);
        }
        return;
    }
    const bn_blue_pixel pixel =
        bn_draw_blue_pixel(bn_tables_7, bn_draw_seed(sampler), (uint32_t)x, (uint32_t)y, domain);
    for (uint32_t i = 0; i < count; ++i) {
        bn_draw_blue_floats(&pixel, first + i, out + 4 * (size_t)i);
    }
}

/* Lanes for bn_sample_wavefront(), in groups as large as the arrays. */
typedef struct lane_buffer {
    size_t count;
    int32_t x[256], y[256];
    uint32_t index[256], domain[256];
} lane_buffer;

/* Draws the buffered lanes in order, empties the buffer, and returns the end of the output. */
static float *draw_buffer(const bn_sampler *sampler, lane_buffer *l, float *out) {
    bn_wavefront lanes = bn_wavefront_default();
    lanes.count = l->count;
    lanes.x = l->x;
    lanes.y = l->y;
    lanes.index = l->index;
    lanes.domain = l->domain;
    for (int d = 0; d < 4; ++d) lanes.out[d] = out + d;
    lanes.stride = 4;
    bn_sample_wavefront(sampler, &lanes);
    out += 4 * l->count;
    l->count = 0;
    return out;
}

/* Adds a pixel's samples to the buffer; draws it whenever it is full. */
static float *add_pixel(const bn_sampler *sampler, lane_buffer *l, int32_t x, int32_t y,
                        uint32_t first, uint32_t count, uint32_t domain, float *out) {
    const size_t most = sizeof l->x / sizeof *l->x;
    for (uint32_t i = 0; i < count;) {
        BN_ASSERT(l->count < most); /* a full buffer is drawn at once */
        const size_t end = count - i < most - l->count ? l->count + (count - i) : most;
        for (; l->count < end; ++l->count, ++i) {
            l->x[l->count] = x;
            l->y[l->count] = y;
            l->index[l->count] = first + i;
            l->domain[l->count] = domain;
        }
        if (end == most) out = draw_buffer(sampler, l, out);
    }
    return out;
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
    /* Compares products by division, which cannot overflow. */
    size_t pixels = out_count / 4u / index_count;
    if (out_count % 4u != 0 || out_count / 4u % index_count != 0 || pixels % width != 0 ||
        pixels / width != height) {
        return BN_ERROR_SIZE_MISMATCH;
    }

    const int in_lanes =
        bn_sampler_types[sampler->type].blocks_in_lanes && bn_simd_get()->draw_many != NULL;
    lane_buffer l;
    l.count = 0;
    for (uint32_t row = 0; row < height; ++row) {
        const int32_t y = (int32_t)((uint32_t)y0 + row);
        for (uint32_t column = 0; column < width; ++column) {
            const int32_t x = (int32_t)((uint32_t)x0 + column);
            if (in_lanes) {
                out = add_pixel(sampler, &l, x, y, first_index, index_count, domain, out);
            } else {
                draw_pixel(sampler, x, y, first_index, index_count, domain, out);
                out += 4 * (size_t)index_count;
            }
        }
    }
    if (l.count > 0) draw_buffer(sampler, &l, out);
    return BN_SUCCESS;
}
