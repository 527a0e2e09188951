/* SPDX-License-Identifier: Apache-2.0
 * Samplers, and their draws one by one. BLUE, SOBOL and WHITE are inline functions of bn_draw.h. */
#include "base/check.h"
#include "base/options.h"
#include "sampler/kinds.h"

const bn_kind bn_kinds[] = {
    [BN_SAMPLER_BLUE] = {NULL, 1, 0},         [BN_SAMPLER_SOBOL] = {NULL, 1, 1},
    [BN_SAMPLER_WHITE] = {NULL, 1, 1},        [BN_SAMPLER_ZORDER] = {bn_draw_zorder, 0, 0},
    [BN_SAMPLER_MASK] = {bn_draw_mask, 0, 0},
};

enum { KINDS = sizeof bn_kinds / sizeof *bn_kinds };

/* ---- Draws. The inline ones call these for the kinds that have a function. */

void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t out[4]) {
    const bn_draw_bits draw = bn_kinds[sampler->kind].draw;
    if (draw != NULL) {
        draw(sampler, x, y, index, domain, 3, out);
    } else {
        bn_inline_sample_4d_u32(sampler, x, y, index, domain, out);
    }
}

void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]) {
    const bn_draw_bits draw = bn_kinds[sampler->kind].draw;
    if (draw != NULL) {
        uint32_t bits[4];
        draw(sampler, x, y, index, domain, 3, bits);
        for (int d = 0; d < 4; ++d) out[d] = bn_draw_float(bits[d]);
    } else {
        bn_inline_sample_4d(sampler, x, y, index, domain, out);
    }
}

void bn_sample_pair(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pair, float out[2]) {
    const bn_draw_bits draw = bn_kinds[sampler->kind].draw;
    if (draw != NULL) {
        uint32_t bits[4];
        pair &= 1u;
        draw(sampler, x, y, index, domain, 1u << pair, bits);
        for (uint32_t i = 0; i < 2u; ++i) out[i] = bn_draw_float(bits[2u * pair + i]);
    } else {
        bn_inline_sample_pair(sampler, x, y, index, domain, pair, out);
    }
}

void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[2]) {
    bn_sample_pair(sampler, x, y, index, domain, 0, out);
}

float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                   uint32_t domain) {
    float out[2];
    bn_sample_pair(sampler, x, y, index, domain, 0, out);
    return out[0];
}

/* ---- Samplers */

static bn_result check_options(const bn_sampler_options *o) {
    if (o->kind < 0 || o->kind >= KINDS) return BN_ERROR_INVALID_ARGUMENT;
    if (o->mask_ranks == NULL) {
        return o->mask_width == 0 && o->mask_height == 0 ? BN_SUCCESS : BN_ERROR_INVALID_ARGUMENT;
    }
    if (o->kind != BN_SAMPLER_MASK) return BN_ERROR_INVALID_ARGUMENT;
    return bn_check_mask(o->mask_ranks, o->mask_width, o->mask_height,
                         (size_t)o->mask_width * o->mask_height);
}

enum { ZORDER_MOST_LOG2 = 16 };

bn_result bn_sampler_init(bn_sampler *sampler, const bn_sampler_options *options) {
    bn_sampler_options o = bn_sampler_options_default();
    if (sampler == NULL) return BN_ERROR_INVALID_ARGUMENT;
    bn_result result = bn_options_read(&o, sizeof o, options);
    if (result == BN_SUCCESS) result = check_options(&o);
    if (result != BN_SUCCESS) return result;

    bn_sampler s = bn_sampler_make(o.kind, o.seed);
    if (o.samples_per_pixel != 0) {
        s.log2_samples = 0;
        while (s.log2_samples < ZORDER_MOST_LOG2 && 1u << s.log2_samples < o.samples_per_pixel) {
            ++s.log2_samples;
        }
    }
    if (o.mask_ranks != NULL) {
        const uint64_t count = (uint64_t)o.mask_width * o.mask_height;
        s.mask = o.mask_ranks;
        s.mask_width = o.mask_width;
        s.mask_height = o.mask_height;
        s.mask_scale = (((uint64_t)1 << 63) + count - 1u) / count;
        /* Digits finer than the ranks are filled with random bits. */
        s.mask_low_digits = UINT32_MAX;
        for (uint64_t cells = 1; cells < count; cells *= 2) s.mask_low_digits >>= 1;
    }
    *sampler = s;
    return BN_SUCCESS;
}
