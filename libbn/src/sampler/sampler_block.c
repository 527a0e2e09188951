/* SPDX-License-Identifier: Apache-2.0
 * Blocks of draws. Work that depends only on the pixel is shared by all of its indices. */
#include "sampler/sampler_object.h"

static void draw_pixel(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t first,
                       uint32_t count, uint32_t domain, float *out) {
    const bn_draw_table *table = &sampler->table;
    if (table->kind != BN_SAMPLER_BLUE) {
        for (uint32_t i = 0; i < count; ++i) {
            bn_sample_4d(sampler, x, y, first + i, domain, out + 4 * (size_t)i);
        }
        return;
    }
    const bn_blue_pixel pixel = bn_draw_blue_pixel(table->words, (uint32_t)x, (uint32_t)y, domain);
    for (uint32_t i = 0; i < count; ++i) {
        bn_draw_blue_floats(table, &pixel, first + i, out + 4 * (size_t)i);
    }
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

    for (uint32_t row = 0; row < height; ++row) {
        for (uint32_t column = 0; column < width; ++column) {
            draw_pixel(sampler, (int32_t)((uint32_t)x0 + column), (int32_t)((uint32_t)y0 + row),
                       first_index, index_count, domain, out);
            out += 4 * (size_t)index_count;
        }
    }
    return BN_SUCCESS;
}
