/* SPDX-License-Identifier: Apache-2.0
 * The sampler object and its draws. BLUE, SOBOL and WHITE are inline functions of bn_draw.h, ZORDER
 * is in zorder.c, and MASK, which needs memory of its own, is here. */
#include "base/check.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/options.h"
#include "sampler/blue_tables.h"
#include "sampler/zorder.h"
#include <string.h>

/* ---- MASK */

/* The mask gives the first sample of every pixel, with one lookup per dimension, each at a
 * different shift. The other samples come from an Owen-scrambled Sobol' (0, 2)-sequence that begins
 * at zero, with the mask's value added as a digital shift (XOR), which preserves the nets of a pixel.
 * The usual Cranley-Patterson rotation (1976) destroys them, and is worse than no mask from about 4
 * samples on. */

enum { BN_MASK_KEY_X = 0x51ed270b, BN_MASK_KEY_Y = 0x3c6ef372 };

static uint32_t wrap(int32_t coordinate, uint32_t shift, uint32_t extent) {
    int64_t sum = ((int64_t)coordinate + shift) % extent;
    return (uint32_t)(sum < 0 ? sum + extent : sum);
}

/* The value of the texel that a lookup reads, in 32 digits. */
static uint32_t mask_lookup(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t key) {
    uint32_t w = sampler->mask_width, h = sampler->mask_height;
    uint32_t shift_x = (uint32_t)((uint64_t)key * w >> 32);
    uint32_t shift_y = (uint32_t)((uint64_t)bn_hash32(key) * h >> 32);
    uint64_t rank = sampler->mask_ranks[(size_t)wrap(y, shift_y, h) * w + wrap(x, shift_x, w)];
    return (uint32_t)((2u * rank + 1u) * sampler->mask_scale >> 32);
}

/* Owen scrambling that maps zero to itself. */
static uint32_t mask_scramble(uint32_t digits, uint32_t key) {
    return bn_owen(digits, key) ^ bn_owen(0, key);
}

static void draw_mask(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t pairs, uint32_t out[4]) {
    uint32_t key =
        bn_hash32(bn_hash32(domain + sampler->words[BN_SEED_AT]) ^ sampler->words[BN_SEED_AT + 1u]);
    uint32_t pixel = bn_hash32((uint32_t)x ^ bn_hash32((uint32_t)y ^ key));
    uint32_t reversed = bn_reverse_bits(index), low = sampler->mask_low_digits;
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        const uint32_t key_x = bn_hash32(key + 0x9e3779b9u), key_y = bn_hash32(key_x + 0x9e3779b9u);
        const uint32_t pixel_x = pixel, pixel_y = bn_hash32(pixel + 0x9e3779b9u);
        key = key_y;
        pixel = bn_hash32(pixel_y + 0x9e3779b9u);
        if (!(pairs >> pair & 1u)) continue;
        /* A nested shuffle that maps each power-of-two prefix to itself. */
        uint32_t digits = reversed ^ (reversed * (pixel_x << 1));
        uint32_t second = bn_sobol_second(digits);
        out[2 * pair] = mask_scramble(digits, BN_MASK_KEY_X) ^ mask_lookup(sampler, x, y, key_x) ^
                        (pixel_x & low);
        out[2 * pair + 1] = mask_scramble(second, BN_MASK_KEY_Y) ^
                            mask_lookup(sampler, x, y, key_y) ^ (pixel_y & low);
    }
}

/* ---- Draws */

/* ZORDER and MASK: the pairs of the bits of `pairs`; the rest of `out` is left alone. */
static void draw_by_call(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                         uint32_t domain, uint32_t pairs, uint32_t out[4]) {
    if (sampler->table.kind == BN_SAMPLER_ZORDER) {
        bn_draw_zorder(sampler, x, y, index, domain, pairs, out);
    } else {
        draw_mask(sampler, x, y, index, domain, pairs, out);
    }
}

void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t out[4]) {
    if (sampler->table.kind > BN_SAMPLER_WHITE) {
        draw_by_call(sampler, x, y, index, domain, 3, out);
    } else {
        bn_draw_4d_u32(&sampler->table, x, y, index, domain, out);
    }
}

void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]) {
    if (sampler->table.kind > BN_SAMPLER_WHITE) {
        uint32_t bits[4];
        draw_by_call(sampler, x, y, index, domain, 3, bits);
        for (int d = 0; d < 4; ++d) out[d] = bn_draw_float(bits[d]);
    } else {
        bn_draw_4d(&sampler->table, x, y, index, domain, out);
    }
}

void bn_sample_pair(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pair, float out[2]) {
    if (sampler->table.kind > BN_SAMPLER_WHITE) {
        uint32_t bits[4];
        pair &= 1u;
        draw_by_call(sampler, x, y, index, domain, 1u << pair, bits);
        for (uint32_t i = 0; i < 2u; ++i) out[i] = bn_draw_float(bits[2u * pair + i]);
    } else {
        bn_draw_pair(&sampler->table, x, y, index, domain, pair, out);
    }
}

void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[2]) {
    bn_draw_2d(&sampler->table, x, y, index, domain, out);
}

float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                   uint32_t domain) {
    return bn_draw_1d(&sampler->table, x, y, index, domain);
}

/* ---- Creating and destroying */

/* Named here, and not asked of bn_builtin_mask(), so that a program that draws has no other mask in
 * it. */
extern const uint16_t bn_data_mask_64[];

static bn_result copy_mask(const bn_sampler_options *options, bn_sampler *sampler) {
    enum { builtin_size = 64, builtin_count = builtin_size * builtin_size };
    uint32_t w = options->mask_width, h = options->mask_height, builtin[builtin_count];
    const uint32_t *ranks = options->mask_ranks;
    if (ranks == NULL) {
        w = h = builtin_size;
        for (uint32_t i = 0; i < builtin_count; ++i) builtin[i] = bn_data_mask_64[i];
        ranks = builtin;
    }
    const size_t count = (size_t)w * h;
    const bn_result result = bn_check_mask(ranks, w, h, count);
    if (result != BN_SUCCESS) return result;
    sampler->mask_ranks = bn_allocate(count, sizeof *sampler->mask_ranks);
    if (sampler->mask_ranks == NULL) return BN_ERROR_OUT_OF_MEMORY;
    memcpy(sampler->mask_ranks, ranks, count * sizeof *ranks);
    sampler->mask_width = w;
    sampler->mask_height = h;
    sampler->mask_scale = (((uint64_t)1 << 63) + count - 1u) / count;
    /* Digits finer than the ranks are filled with random bits. */
    sampler->mask_low_digits = UINT32_MAX;
    for (size_t cells = 1; cells < count; cells *= 2) sampler->mask_low_digits >>= 1;
    return BN_SUCCESS;
}

static bn_result check_options(const bn_sampler_options *options) {
    if (options->kind < BN_SAMPLER_BLUE || options->kind > BN_SAMPLER_MASK) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    if (options->mask_ranks == NULL ? options->mask_width != 0 || options->mask_height != 0
                                    : options->kind != BN_SAMPLER_MASK) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    return BN_SUCCESS;
}

enum { ZORDER_MAX_LOG2 = 16 };

bn_result bn_sampler_create(const bn_sampler_options *options, bn_sampler **sampler) {
    bn_sampler_options o = bn_sampler_options_default();
    if (sampler == NULL) return BN_ERROR_INVALID_ARGUMENT;
    *sampler = NULL;
    bn_result result = bn_options_read(&o, sizeof o, options);
    if (result == BN_SUCCESS) result = check_options(&o);
    if (result != BN_SUCCESS) return result;

    bn_sampler *s = bn_allocate_zero(1, sizeof *s);
    if (s == NULL) return BN_ERROR_OUT_OF_MEMORY;
    uint64_t key = bn_mix64(o.seed + 0x9e3779b97f4a7c15u);
    bn_blue_tables_fill(s, o.kind, key);
    s->simd = bn_simd_get();
    if (o.kind == BN_SAMPLER_ZORDER) {
        uint32_t spp = o.samples_per_pixel == 0 ? 256 : o.samples_per_pixel;
        while (s->zorder_log2 < ZORDER_MAX_LOG2 && 1u << s->zorder_log2 < spp) ++s->zorder_log2;
    } else if (o.kind == BN_SAMPLER_MASK) {
        result = copy_mask(&o, s);
        if (result != BN_SUCCESS) {
            bn_sampler_destroy(s);
            return result;
        }
    }
    *sampler = s;
    return BN_SUCCESS;
}

void bn_sampler_destroy(bn_sampler *sampler) {
    if (sampler == NULL) return;
    bn_free(sampler->mask_ranks);
    bn_free(sampler);
}

const bn_draw_table *bn_sampler_table(const bn_sampler *sampler) {
    return &sampler->table;
}

bn_result bn_sampler_table_words(const bn_sampler *sampler, uint32_t *words, size_t count,
                                 size_t *needed) {
    if (sampler == NULL) return BN_ERROR_INVALID_ARGUMENT;
    if (needed != NULL) *needed = BN_WORD_COUNT;
    if (words == NULL) return needed != NULL ? BN_SUCCESS : BN_ERROR_INVALID_ARGUMENT;
    if (count != BN_WORD_COUNT) return BN_ERROR_SIZE_MISMATCH;
    memcpy(words, sampler->words, sizeof sampler->words);
    return BN_SUCCESS;
}
