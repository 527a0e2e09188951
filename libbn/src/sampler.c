/* SPDX-License-Identifier: Apache-2.0
 * The sampler object and its draws. BLUE, SOBOL and WHITE are the inline functions of bn_draw.h;
 * this file adds ZORDER and MASK, which need 64-bit arithmetic or memory of their own. */
#include "sampler.h"
#include "hash.h"
#include "options.h"
#include <stdlib.h>

/* The baked table of pixels, 32 bits each; see data/README.md. */
extern const uint32_t bn_data_blue_table[];
extern const size_t bn_data_blue_table_count;
#ifndef BN_SMALL_DATA
extern const uint32_t bn_data_blue_1[], bn_data_blue_4[], bn_data_blue_16[], bn_data_blue_64[];
#endif

enum { BN_MORTON_BITS = 12, BN_ZORDER_MAX_LOG2 = 16 };

/* ---- ZORDER
 * --------------------------------------------------------------------------------------- The
 * pixels of a 4096 x 4096 tile along a Morton curve with its digits scrambled own consecutive
 * blocks of 2^k points of one Owen-scrambled Sobol' sequence; indices from 2^k on continue the
 * block of a pixel with a scrambling of the pixel's own, as BLUE does. The curve is one for all
 * domains of a family, and both pairs and the members have the orders of BLUE: over neighbouring
 * pixels, too, they are stratified together. */

static uint64_t reverse_bits64(uint64_t v) {
    return (uint64_t)bn_reverse_bits((uint32_t)v) << 32 | bn_reverse_bits((uint32_t)(v >> 32));
}

static uint64_t sobol_second64(uint64_t digits) {
    digits ^= (digits << 1) & 0xaaaaaaaaaaaaaaaau;
    digits ^= (digits << 2) & 0xccccccccccccccccu;
    digits ^= (digits << 4) & 0xf0f0f0f0f0f0f0f0u;
    digits ^= (digits << 8) & 0xff00ff00ff00ff00u;
    digits ^= (digits << 16) & 0xffff0000ffff0000u;
    return digits ^ ((digits << 32) & 0xffffffff00000000u);
}

/* bn_draw_times_x(), bn_draw_second_pair() and bn_draw_member() for 64 digits. */
static uint64_t times_x64(uint64_t digits) {
    uint64_t upper = digits >> 1 & 0x5555555555555555u, lower = digits & 0x5555555555555555u;
    return lower << 1 | (upper ^ lower);
}

static uint64_t second_pair64(uint64_t digits, uint32_t form) {
    digits ^= (times_x64(digits) << 2) & 0xccccccccccccccccu;
    digits ^= (times_x64(times_x64(digits)) << 4) & 0xf0f0f0f0f0f0f0f0u;
    digits ^= (times_x64(digits) << 8) & 0xff00ff00ff00ff00u;
    digits ^= (times_x64(times_x64(digits)) << 16) & 0xffff0000ffff0000u;
    digits ^= times_x64(digits) << 32;
    return digits ^ ((digits << 1) & (form & 1u ? 0xaaaaaaaaaaaaaaaau : 0u));
}

static uint64_t member64(uint64_t digits, uint32_t member) {
    return (uint64_t)bn_draw_member((uint32_t)(digits >> 32), member) << 32 | (uint32_t)digits;
}

/* Spreads the low 16 bits to the even positions. */
static uint32_t morton_spread(uint32_t v) {
    v &= 0xffffu;
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
}

/* One dimension: the Owen scrambling of the whole picture, left for the pixel's own where the
 * digits that come from indices beyond the block begin. */
static uint32_t zorder_scramble(uint64_t block_digits, uint64_t later, uint32_t picture_key,
                                uint32_t pixel_key) {
    uint32_t first = bn_owen((uint32_t)(block_digits >> 32), picture_key);
    uint32_t shifted = (uint32_t)((block_digits ^ later) >> 32);
    return bn_draw_continue(first, shifted, (uint32_t)(later >> 32), pixel_key);
}

static void draw_zorder(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                        uint32_t domain, uint32_t out[4]) {
    const uint32_t coordinate_mask = (1u << BN_MORTON_BITS) - 1u, k = sampler->zorder_log2;
    const uint32_t block_mask = (1u << k) - 1u;
    /* Tiles of 4096 x 4096 pixels are pictures of their own. */
    uint32_t tile = bn_hash32(((uint32_t)x >> BN_MORTON_BITS) ^
                              bn_hash32(((uint32_t)y >> BN_MORTON_BITS) + 0x9e3779b9u));
    uint32_t keys[2] = {domain, domain << 2}; /* of the domain, and of its family */
    for (int i = 0; i < 2; ++i) {
        keys[i] = bn_hash32(tile ^ bn_hash32(keys[i] + sampler->table.seed[0]));
        keys[i] = bn_hash32(keys[i] ^ sampler->table.seed[1]);
    }
    uint32_t key = keys[0], family = keys[1];
    uint32_t morton = morton_spread((uint32_t)x & coordinate_mask) |
                      morton_spread((uint32_t)y & coordinate_mask) << 1;
    uint32_t pixel =
        bn_owen(morton << (32 - 2 * BN_MORTON_BITS), family) >> (32 - 2 * BN_MORTON_BITS);
    /* The order inside the block, and of the later blocks, is the pixel's own. */
    uint32_t order_key =
        bn_hash32(bn_hash32(pixel ^ bn_hash32(family ^ 0x5bd1e995u)) ^ (index >> k));
    uint32_t low = k == 0 ? 0 : bn_owen((index & block_mask) << (32 - k), order_key) >> (32 - k);
    uint64_t block = member64(reverse_bits64((uint64_t)pixel << k | low), domain >> 30);
    uint64_t later = reverse_bits64((uint64_t)(index & ~block_mask));
    uint64_t top = k == 0 ? 0 : ~(uint64_t)0 << (64 - k);
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        key = bn_hash32(key + 0x9e3779b9u);
        uint32_t pixel_key = bn_hash32(pixel ^ bn_hash32(key ^ 0x5bd1e995u));
        if (pair == 1) block = second_pair64(block, domain >> 29);
        uint64_t later_second = sobol_second64(later), block_second = sobol_second64(block);
        block_second ^= later_second & top;
        out[2 * pair] =
            zorder_scramble(block, later, bn_hash32(key ^ 1u), bn_hash32(pixel_key ^ 1u));
        out[2 * pair + 1] = zorder_scramble(block_second, later_second & ~top, bn_hash32(key ^ 2u),
                                            bn_hash32(pixel_key ^ 2u));
    }
}

/* ---- MASK ----------------------------------------------------------------------------------
 * A mask makes the first sample of every pixel: one look for each dimension, at a shift of its own.
 * The others follow by exchanging digits, not by adding values: in the digits of a scrambled Sobol'
 * (0,2)-sequence every pixel has the digital shift that makes its sample 0 the value of the mask.
 * So each pixel keeps its nets; a rotation on the torus (Cranley and Patterson, 1976), the usual
 * way, loses them and is worse than no mask from about 4 samples on. */

enum { BN_MASK_KEY_X = 0x51ed270b, BN_MASK_KEY_Y = 0x3c6ef372 };

static uint32_t wrap(int32_t coordinate, uint32_t shift, uint32_t extent) {
    int64_t sum = ((int64_t)coordinate + shift) % extent;
    return (uint32_t)(sum < 0 ? sum + extent : sum);
}

/* The texel of a look, as an index. */
static size_t mask_look(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t key) {
    uint32_t w = sampler->mask_width, h = sampler->mask_height;
    uint32_t shift_x = (uint32_t)((uint64_t)key * w >> 32);
    uint32_t shift_y = (uint32_t)((uint64_t)bn_hash32(key) * h >> 32);
    return (size_t)wrap(y, shift_y, h) * w + wrap(x, shift_x, w);
}

static void draw_mask(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t out[4]) {
    uint32_t key = bn_hash32(bn_hash32(domain + sampler->table.seed[0]) ^ sampler->table.seed[1]);
    uint32_t pixel = bn_hash32((uint32_t)x ^ bn_hash32((uint32_t)y ^ key));
    uint32_t reversed = bn_reverse_bits(index), low = sampler->mask_low_digits;
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        /* As in BLUE: a nested shuffle that keeps power-of-two prefixes in place. */
        uint32_t digits = reversed ^ (reversed * (pixel << 1));
        uint32_t second = bn_sobol_second(digits);
        key = bn_hash32(key + 0x9e3779b9u);
        digits ^= sampler->mask_x[mask_look(sampler, x, y, key)] ^ (pixel & low);
        pixel = bn_hash32(pixel + 0x9e3779b9u);
        key = bn_hash32(key + 0x9e3779b9u);
        second ^= sampler->mask_y[mask_look(sampler, x, y, key)] ^ (pixel & low);
        pixel = bn_hash32(pixel + 0x9e3779b9u);
        out[2 * pair] = bn_owen(digits, BN_MASK_KEY_X);
        out[2 * pair + 1] = bn_owen(second, BN_MASK_KEY_Y);
    }
}

/* ---- Draws
 * ---------------------------------------------------------------------------------------- */

void bn_sample_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                      uint32_t domain, uint32_t out[4]) {
    const bn_draw_table *table = &sampler->table;
    switch (table->kind) {
    case BN_SAMPLER_BLUE:
        bn_draw_blue(table, x, y, index, domain, out);
        break;
    case BN_SAMPLER_SOBOL:
        bn_draw_sobol(table, x, y, index, domain, out);
        break;
    case BN_SAMPLER_WHITE:
        bn_draw_white(table, x, y, index, domain, out);
        break;
    case BN_SAMPLER_ZORDER:
        draw_zorder(sampler, x, y, index, domain, out);
        break;
    default:
        draw_mask(sampler, x, y, index, domain, out);
        break;
    }
}

void bn_sample_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[4]) {
    bn_draw_4d(&sampler->table, x, y, index, domain, out);
}

void bn_sample_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  float out[2]) {
    uint32_t bits[4];
    bn_sample_4d_u32(sampler, x, y, index, domain, bits);
    for (int i = 0; i < 2; ++i) out[i] = bn_draw_float(bits[i]);
}

float bn_sample_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                   uint32_t domain) {
    uint32_t bits[4];
    bn_sample_4d_u32(sampler, x, y, index, domain, bits);
    return bn_draw_float(bits[0]);
}

/* ---- Life of a sampler
 * ---------------------------------------------------------------------------- */

/* The digits that bn_owen() scrambles to `value`. Digit by digit from the first: each is flipped or
 * not whatever the later ones are. */
static uint32_t owen_inverse(uint32_t value, uint32_t seed) {
    uint32_t digits = 0;
    for (uint32_t bit = 1u << 31; bit != 0; bit >>= 1) {
        digits |= (bn_owen(digits, seed) ^ value) & bit;
    }
    return digits;
}

/* Fills the two tables of digits from ranks; checks that they are a permutation. */
static bn_result mask_digits(const uint32_t *ranks, size_t count, bn_sampler *sampler) {
    bn_result result = BN_SUCCESS;
    unsigned char *seen = calloc(count, 1);
    if (seen == NULL) return BN_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        if (ranks[i] >= count || seen[ranks[i]]) {
            result = BN_ERROR_BAD_DATA;
            break;
        }
        seen[ranks[i]] = 1;
        uint32_t value = (uint32_t)((((uint64_t)ranks[i] * 2u + 1u) << 31) / count);
        sampler->mask_x[i] = owen_inverse(value, BN_MASK_KEY_X);
        sampler->mask_y[i] = owen_inverse(value, BN_MASK_KEY_Y);
    }
    free(seen);
    /* Digits finer than the ranks are random. */
    sampler->mask_low_digits = UINT32_MAX;
    for (size_t cells = 1; cells < count; cells *= 2) sampler->mask_low_digits >>= 1;
    return result;
}

static bn_result copy_mask(const bn_sampler_options *options, bn_sampler *sampler) {
    enum { builtin_size = 64 };
    uint32_t w = builtin_size, h = builtin_size, *builtin = NULL;
    const uint32_t *ranks = options->mask_ranks;
    if (ranks != NULL) {
        w = options->mask_width;
        h = options->mask_height;
    }
    size_t count = (size_t)w * h;
    bn_result result = BN_ERROR_OUT_OF_MEMORY;
    sampler->mask_x = malloc(2 * count * sizeof *sampler->mask_x);
    if (ranks == NULL) ranks = builtin = malloc(count * sizeof *builtin);
    if (sampler->mask_x != NULL && ranks != NULL) {
        sampler->mask_y = sampler->mask_x + count;
        result = builtin != NULL ? bn_builtin_mask_copy(builtin_size, builtin, count) : BN_SUCCESS;
        if (result == BN_SUCCESS) result = mask_digits(ranks, count, sampler);
    }
    sampler->mask_width = w;
    sampler->mask_height = h;
    free(builtin);
    return result;
}

/* The table of pixels: one made for the count declared, else the progressive one. */
static void choose_table(bn_draw_table *table, uint32_t samples_per_pixel) {
#ifndef BN_SMALL_DATA
    static const struct {
        uint32_t count;
        const uint32_t *pixels; /* 64 x 64 */
    } declared[] = {
        {1, bn_data_blue_1}, {4, bn_data_blue_4}, {16, bn_data_blue_16}, {64, bn_data_blue_64}};
    for (size_t i = 0; i < sizeof declared / sizeof *declared; ++i) {
        if (declared[i].count == samples_per_pixel) {
            table->pixels = declared[i].pixels;
            table->size_log2 = 6;
            return;
        }
    }
#else
    (void)samples_per_pixel;
#endif
    table->pixels = bn_data_blue_table;
    while ((size_t)1 << (2 * table->size_log2) < bn_data_blue_table_count) ++table->size_log2;
}

static bn_result check_options(const bn_sampler_options *options) {
    if (options->kind < BN_SAMPLER_BLUE || options->kind > BN_SAMPLER_MASK) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    if (options->mask_ranks == NULL) {
        return options->mask_width == 0 && options->mask_height == 0 ? BN_SUCCESS
                                                                     : BN_ERROR_INVALID_ARGUMENT;
    }
    uint64_t texels = (uint64_t)options->mask_width * options->mask_height;
    if (options->kind != BN_SAMPLER_MASK || texels == 0 || texels > 1u << 24) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    return BN_SUCCESS;
}

bn_result bn_sampler_create(const bn_sampler_options *options, bn_sampler **sampler) {
    bn_sampler_options o = bn_sampler_options_default();
    if (sampler == NULL) return BN_ERROR_INVALID_ARGUMENT;
    *sampler = NULL;
    bn_result result = bn_options_read(&o, sizeof o, options);
    if (result == BN_SUCCESS) result = check_options(&o);
    if (result != BN_SUCCESS) return result;

    bn_sampler *s = calloc(1, sizeof *s);
    if (s == NULL) return BN_ERROR_OUT_OF_MEMORY;
    uint64_t key = bn_mix64(o.seed + 0x9e3779b97f4a7c15u);
    s->table.kind = o.kind;
    s->table.seed[0] = (uint32_t)key;
    s->table.seed[1] = (uint32_t)(key >> 32);
    choose_table(&s->table, o.kind == BN_SAMPLER_BLUE ? o.samples_per_pixel : 0);
    s->table.sampler = s;
    bn_draw_table_fill(&s->table);
    bn_block_prepare(&s->block, &s->table);
    if (o.kind == BN_SAMPLER_ZORDER) {
        uint32_t spp = o.samples_per_pixel == 0 ? 256 : o.samples_per_pixel;
        while (s->zorder_log2 < BN_ZORDER_MAX_LOG2 && 1u << s->zorder_log2 < spp) ++s->zorder_log2;
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
    free(sampler->mask_x);
    free(sampler);
}

const bn_draw_table *bn_sampler_table(const bn_sampler *sampler) {
    return &sampler->table;
}
