/* SPDX-License-Identifier: Apache-2.0
 * Samplers and single draws. bn_draw.glsl implements BLUE, SOBOL and WHITE; zorder.c and mask_sampler.c the
 * others. A sampler is a plain value, and a draw is a function of it and the draw's arguments, so nothing is
 * stored from one draw to the next. Draws that need one pair compute only that pair, except for WHITE. */
#include "base/check.h"
#include "sampler/types.h"

static void draw_sobol(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                       uint32_t domain, uint32_t pairs, uint32_t out[4]) {
    uint32_t key = bn_draw_sobol_key(bn_draw_seed(sampler), (uint32_t)x, (uint32_t)y, domain);
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        if (pair == 1 && pairs >> 1 != 0) key = bn_draw_sobol_second_key(key);
        if (!(pairs >> pair & 1u)) continue;
        const bn_uint2 v = bn_draw_sobol_two(key, index);
        out[2 * pair] = v.x;
        out[2 * pair + 1] = v.y;
    }
}

static void draw_white(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                       uint32_t domain, uint32_t pairs, uint32_t out[4]) {
    const bn_uint4 v =
        bn_draw_white_bits(bn_draw_seed(sampler), (uint32_t)x, (uint32_t)y, index, domain);
    (void)pairs;
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
    out[3] = v.w;
}

const bn_sampler_row bn_sampler_types[] = {
    [BN_SAMPLER_BLUE] = {NULL, 1, 0},         [BN_SAMPLER_SOBOL] = {draw_sobol, 1, 1},
    [BN_SAMPLER_WHITE] = {draw_white, 1, 1},  [BN_SAMPLER_ZORDER] = {bn_draw_zorder, 0, 0},
    [BN_SAMPLER_MASK] = {bn_draw_mask, 0, 0},
};

enum { TYPES = sizeof bn_sampler_types / sizeof *bn_sampler_types };

/* ---- Draws. The inline functions call these for all types but BLUE. */

void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t out[4]) {
    const bn_draw_bits draw = bn_sampler_types[sampler->type].draw;
    if (draw != NULL) {
        draw(sampler, x, y, index, domain, 3, out);
    } else {
        bn_draw_4d_u32(sampler, x, y, index, domain, out);
    }
}

void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]) {
    const bn_draw_bits draw = bn_sampler_types[sampler->type].draw;
    if (draw != NULL) {
        uint32_t bits[4];
        draw(sampler, x, y, index, domain, 3, bits);
        for (int d = 0; d < 4; ++d) out[d] = bn_draw_float(bits[d]);
    } else {
        bn_draw_4d(sampler, x, y, index, domain, out);
    }
}

void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  uint32_t pair, float out[2]) {
    const bn_draw_bits draw = bn_sampler_types[sampler->type].draw;
    if (draw != NULL) {
        uint32_t bits[4];
        pair &= 1u;
        draw(sampler, x, y, index, domain, 1u << pair, bits);
        for (uint32_t i = 0; i < 2u; ++i) out[i] = bn_draw_float(bits[2u * pair + i]);
    } else {
        bn_draw_2d(sampler, x, y, index, domain, pair, out);
    }
}

float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                   uint32_t domain) {
    float out[2];
    bn_sample_2d(sampler, x, y, index, domain, 0, out);
    return out[0];
}

/* ---- Samplers */

_Static_assert(sizeof(bn_sampler) <= 48, "bn.h says: at most 48 bytes");

bn_result bn_sampler_init(bn_sampler *sampler, bn_sampler_type type, uint64_t seed) {
    if (sampler == NULL || type < 0 || type >= TYPES) return BN_ERROR_INVALID_ARGUMENT;
    *sampler = bn_sampler_make(seed);
    sampler->type = type;
    return BN_SUCCESS;
}

enum { ZORDER_MOST_LOG2 = 16 };

bn_result bn_sampler_init_zorder(bn_sampler *sampler, uint32_t samples_per_pixel, uint64_t seed) {
    const bn_result result = bn_sampler_init(sampler, BN_SAMPLER_ZORDER, seed);
    if (result != BN_SUCCESS || samples_per_pixel == 0) return result;
    uint32_t log2 = 0;
    while (log2 < ZORDER_MOST_LOG2 && 1u << log2 < samples_per_pixel) ++log2;
    sampler->log2_samples = log2;
    return BN_SUCCESS;
}

bn_result bn_sampler_init_mask(bn_sampler *sampler, const bn_mask *mask, uint64_t seed) {
    if (sampler == NULL) return BN_ERROR_INVALID_ARGUMENT;
    const bn_result result = bn_check_mask(mask);
    if (result != BN_SUCCESS) return result;
    bn_sampler s = bn_sampler_make(seed);
    const uint64_t count = (uint64_t)mask->width * mask->height;
    s.type = BN_SAMPLER_MASK;
    s.mask = mask->ranks;
    s.mask_rank_bits = mask->rank_bits;
    s.mask_width = mask->width;
    s.mask_height = mask->height;
    s.mask_scale = (((uint64_t)1 << 63) + count - 1u) / count;
    /* Digits finer than the ranks are filled with random bits. */
    s.mask_low_digits = UINT32_MAX;
    for (uint64_t cells = 1; cells < count; cells *= 2) s.mask_low_digits >>= 1;
    *sampler = s;
    return BN_SUCCESS;
}
