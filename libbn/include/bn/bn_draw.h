/* SPDX-License-Identifier: Apache-2.0
 * The draws of bn.h as inline functions, for renderers that want them inside their own loops.
 * Bit-equal to bn_sample_4d_u32() and its relatives:
 *
 *     const bn_draw_table *table = bn_sampler_table(sampler);
 *     float u[4];
 *     bn_draw_4d(table, x, y, index, domain, u);
 *
 * The table lives as long as its sampler. Kinds BLUE, SOBOL and WHITE are drawn inline; for ZORDER
 * and MASK the inline form calls the library. Everything is 32-bit unsigned arithmetic, so that the
 * same text can be written for a graphics processor.
 *
 * HOW BLUE WORKS. Dimensions (0, 1) and (2, 3) are two looks at one toroidal table of pixels, with
 * shifts and symmetries of the table and of the unit square chosen by a hash of the domain. An
 * entry gives the pixel its set of 256 points: digital shifts (sx, sy) of the two coordinates of
 * one fixed scrambled Sobol' (0,8,2)-net, which also decide the order of the points, and the next
 * eight digits (fx, fy). An offline search chose the entries so that the errors of every
 * power-of-two prefix are blue over the screen (libbn/tools/bn_bake_sampler.c). A nested shuffle
 * that keeps power-of-two prefixes in place decorrelates domains. Sample 256 and later ones
 * continue every pixel's set as an Owen-scrambled (0,2)-sequence of its own. */
#ifndef BN_BN_DRAW_H
#define BN_BN_DRAW_H

#include <bn/bn.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Changes whenever the layout of bn_draw_table or the values drawn from it change. */
#define BN_DRAW_TABLE_VERSION 1u

/* The fixed point set: x[d] and y[d] are the scrambled coordinates of the point whose bit-reversed
 * index is d, 32 bits each with the scrambling of the lower digits; reverse[i] is the byte i with
 * its bits reversed. */
typedef struct bn_digit_tables {
    uint32_t x[256], y[256];
    uint8_t reverse[256];
} bn_digit_tables;

typedef struct bn_draw_table {
    uint32_t version; /* BN_DRAW_TABLE_VERSION */
    int32_t kind;     /* BN_SAMPLER_... */
    uint32_t seed[2];
    uint32_t size_log2;     /* the table of pixels has 2^size_log2 x 2^size_log2 entries */
    const uint32_t *pixels; /* sx, sy, fx, fy: one byte each from the lowest up; row-major */
    const bn_sampler *sampler;
    bn_digit_tables digits;
} bn_draw_table;

/* The table of a sampler; valid until the sampler is destroyed. */
BN_API const bn_draw_table *bn_sampler_table(const bn_sampler *sampler);

/* ---- Bits ------------------------------------------------------------------------------------ */

static inline uint32_t bn_reverse_bits(uint32_t v) {
    v = (v >> 16) | (v << 16);
    v = ((v >> 8) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8);
    v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
    v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
    return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

/* A bijection in which every input bit reaches every output bit (structure and constants: Wellons,
 * "Prospecting for Hash Functions", 2018). */
static inline uint32_t bn_hash32(uint32_t v) {
    v = (v ^ (v >> 16)) * 0x21f0aaadu;
    v = (v ^ (v >> 15)) * 0xd35a2d97u;
    return v ^ (v >> 15);
}

/* bn_domain_child(). */
static inline uint32_t bn_draw_domain_child(uint32_t domain, uint32_t key) {
    return bn_hash32(key * 0x85ebca6bu + bn_hash32(domain + 0x9e3779b9u));
}

/* Nested uniform (Owen) scrambling of bit-reversed digits: each output bit is the input bit,
 * flipped by a hash of the bits below it (Laine and Karras, "Stratified Sampling for Stochastic
 * Transparency", 2011; mixing constants of Vegdahl, "Building a Better LK Hash", 2021). */
static inline uint32_t bn_owen_reversed(uint32_t v, uint32_t seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

static inline uint32_t bn_owen(uint32_t digits, uint32_t seed) {
    return bn_reverse_bits(bn_owen_reversed(bn_reverse_bits(digits), seed));
}

/* The second coordinate of the Sobol' (0,2)-sequence from the first: with digits d_0 (the most
 * significant bit) to d_31 of the radical inverse, digit k becomes the sum over j of binomial(j, k)
 * d_j mod 2, which is odd exactly when k is a bitwise subset of j; so the sum factors into five
 * steps, one for each bit of j (Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast,
 * Elegant, and Compact", 2024). */
static inline uint32_t bn_sobol_second(uint32_t digits) {
    digits ^= (digits << 1) & 0xaaaaaaaau;
    digits ^= (digits << 2) & 0xccccccccu;
    digits ^= (digits << 4) & 0xf0f0f0f0u;
    digits ^= (digits << 8) & 0xff00ff00u;
    digits ^= (digits << 16) & 0xffff0000u;
    return digits;
}

/* Fills the tables of the fixed point set. The two seeds are part of what the table of pixels was
 * made for. */
static inline void bn_digit_tables_fill(bn_digit_tables *tables) {
    for (uint32_t d = 0; d < 256; ++d) {
        tables->x[d] = bn_owen(d << 24, 0x2f0b4c47u);
        tables->y[d] = bn_owen(bn_sobol_second(d << 24), 0x8e5d3aa1u);
        tables->reverse[d] = (uint8_t)(bn_reverse_bits(d) >> 24);
    }
}

/* ---- BLUE -----------------------------------------------------------------------------------
 * In two steps, so that a loop over the indices of a pixel does the first one once. */

/* Two dimensions of a pixel in a domain. */
typedef struct bn_blue_pair {
    uint32_t shift[2];   /* digital shifts of the fixed point set: below 256 */
    uint32_t lower[2];   /* what the coordinates are XORed with: lower digits and reflection */
    uint32_t multiplier; /* of the shuffle; even */
    uint32_t swap;       /* all ones when the two coordinates change places */
} bn_blue_pair;

typedef struct bn_blue_pixel {
    bn_blue_pair pair[2];
} bn_blue_pixel;

/* variant: 20 bits choose the shift over the table, its symmetry and that of the unit square; key:
 * the random bits of pixel and domain. */
static inline bn_blue_pair bn_draw_blue_look(const bn_draw_table *table, uint32_t x, uint32_t y,
                                             uint32_t variant, uint32_t key) {
    bn_blue_pair pair;
    uint32_t log2 = table->size_log2, mask = (1u << log2) - 1u, u, v, swap, entry;
    u = (x + variant) ^ (0u - (variant >> 14 & 1u));
    v = (y + (variant >> 7)) ^ (0u - (variant >> 15 & 1u));
    swap = (u ^ v) & (0u - (variant >> 16 & 1u));
    u = (u ^ swap) & mask;
    v = (v ^ swap) & mask;
    entry = table->pixels[(v << log2) | u];
    pair.shift[0] = entry & 255u;
    pair.shift[1] = entry >> 8 & 255u;
    pair.lower[0] = ((entry & 0x00ff0000u) | (key & 0xffffu)) ^ (0u - (variant >> 17 & 1u));
    pair.lower[1] = ((entry >> 8 & 0x00ff0000u) | key >> 16) ^ (0u - (variant >> 18 & 1u));
    pair.multiplier = key << 1;
    pair.swap = 0u - (variant >> 19 & 1u);
    return pair;
}

static inline bn_blue_pixel bn_draw_blue_pixel(const bn_draw_table *table, int32_t x, int32_t y,
                                               uint32_t domain) {
    bn_blue_pixel pixel;
    uint32_t variant0 = bn_hash32(domain + table->seed[0]);
    uint32_t variant1 = bn_hash32(variant0 ^ table->seed[1]);
    uint32_t key0 = bn_hash32((uint32_t)x * 0x8da6b343u + (uint32_t)y * 0xd8163841u +
                              (variant0 ^ (variant1 << 7 | variant1 >> 25)));
    uint32_t key1 = (key0 ^ variant1) * 0xc2b2ae35u;
    key1 ^= key1 >> 15;
    pixel.pair[0] = bn_draw_blue_look(table, (uint32_t)x, (uint32_t)y, variant0, key0);
    pixel.pair[1] = bn_draw_blue_look(table, (uint32_t)x, (uint32_t)y, variant1, key1);
    return pixel;
}

/* One coordinate from sample 256 on. `first` is what the first 256 samples have at these first
 * eight digits, `shifted` the Sobol' digits with the pixel's shift, `later` those of them below the
 * first eight: where they begin, the path leaves that of the first 256 samples and goes on in an
 * Owen scrambling of the pixel's own. */
static inline uint32_t bn_draw_continue(uint32_t first, uint32_t shifted, uint32_t later,
                                        uint32_t key) {
    uint32_t below = later | (later >> 1), leading;
    below |= below >> 2;
    below |= below >> 4;
    below |= below >> 8;
    below |= below >> 16;
    leading = below ^ (below >> 1);
    below >>= 1;
    return ((first ^ leading) & ~below) | (bn_owen(shifted, key) & below);
}

/* digits: the bit-reversed index. */
static inline void bn_draw_blue_at(const bn_draw_table *table, const bn_blue_pair *pair,
                                   uint32_t digits, uint32_t out[2]) {
    uint32_t x, y, swap;
    /* The shuffle: nested in the index from its top bit down, and fixing zero, so that it maps
     * every power-of-two prefix to itself. */
    digits ^= digits * pair->multiplier;
    x = table->digits.x[(digits >> 24) ^ pair->shift[0]] ^ pair->lower[0];
    y = table->digits.y[(digits >> 24) ^ pair->shift[1]] ^ pair->lower[1];
    if ((digits & 0x00ffffffu) != 0u) {
        uint32_t second = bn_sobol_second(digits);
        uint32_t key = pair->multiplier ^ pair->lower[1];
        /* Later digits of the index reach up into the first eight of y. */
        uint32_t shifted = bn_sobol_second(pair->shift[1] << 24) ^ second;
        y = table->digits.y[bn_sobol_second(shifted & 0xff000000u) >> 24] ^ pair->lower[1];
        x = bn_draw_continue(x, digits ^ (pair->shift[0] << 24), digits & 0x00ffffffu,
                             bn_hash32(key));
        y = bn_draw_continue(y, shifted, second & 0x00ffffffu, bn_hash32(~key));
    }
    swap = (x ^ y) & pair->swap;
    out[0] = x ^ swap;
    out[1] = y ^ swap;
}

static inline uint32_t bn_draw_digits(const bn_draw_table *table, uint32_t index) {
    return index < 256u ? (uint32_t)table->digits.reverse[index] << 24 : bn_reverse_bits(index);
}

static inline void bn_draw_blue(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                uint32_t domain, uint32_t out[4]) {
    bn_blue_pixel pixel = bn_draw_blue_pixel(table, x, y, domain);
    uint32_t digits = bn_draw_digits(table, index);
    bn_draw_blue_at(table, &pixel.pair[0], digits, out);
    bn_draw_blue_at(table, &pixel.pair[1], digits, out + 2);
}

/* ---- SOBOL and WHITE ------------------------------------------------------------------------- */

static inline void bn_draw_sobol(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                 uint32_t domain, uint32_t out[4]) {
    uint32_t key = bn_hash32((uint32_t)y ^ bn_hash32(domain + table->seed[0]));
    key = bn_hash32((uint32_t)x ^ bn_hash32(key + table->seed[1]));
    uint32_t reversed = bn_reverse_bits(index);
    for (int pair = 0; pair < 2; ++pair) {
        uint32_t digits = bn_owen_reversed(reversed, key);
        uint32_t second = bn_sobol_second(digits);
        key = bn_hash32(key + 0x9e3779b9u);
        out[2 * pair] = bn_owen(digits, key);
        key = bn_hash32(key + 0x9e3779b9u);
        out[2 * pair + 1] = bn_owen(second, key);
        key = bn_hash32(key + 0x9e3779b9u);
    }
}

static inline void bn_draw_white(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                 uint32_t domain, uint32_t out[4]) {
    /* Two chains of 32 bits: pixels that meet in one differ in the other. */
    uint32_t a =
        bn_hash32((uint32_t)x ^ bn_hash32((uint32_t)y ^ bn_hash32(domain + table->seed[0])));
    uint32_t b =
        bn_hash32((uint32_t)y + bn_hash32((uint32_t)x + bn_hash32(domain ^ table->seed[1])));
    for (uint32_t dimension = 0; dimension < 4u; ++dimension) {
        b += 0x9e3779b9u;
        out[dimension] = bn_hash32(a ^ bn_hash32(index ^ bn_hash32(b)));
    }
}

/* ---- The draws ------------------------------------------------------------------------------- */

static inline void bn_draw_4d_u32(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                  uint32_t domain, uint32_t out[4]) {
    if (table->kind == BN_SAMPLER_BLUE)
        bn_draw_blue(table, x, y, index, domain, out);
    else if (table->kind == BN_SAMPLER_SOBOL)
        bn_draw_sobol(table, x, y, index, domain, out);
    else if (table->kind == BN_SAMPLER_WHITE)
        bn_draw_white(table, x, y, index, domain, out);
    else
        bn_sample_4d_u32(table->sampler, x, y, index, domain, out);
}

static inline float bn_draw_float(uint32_t bits) {
    return (float)(bits >> 8) * (1.0f / 16777216.0f); /* 2^-24; C++11 has no hexadecimal floats */
}

static inline void bn_draw_4d(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                              uint32_t domain, float out[4]) {
    uint32_t bits[4];
    bn_draw_4d_u32(table, x, y, index, domain, bits);
    out[0] = bn_draw_float(bits[0]);
    out[1] = bn_draw_float(bits[1]);
    out[2] = bn_draw_float(bits[2]);
    out[3] = bn_draw_float(bits[3]);
}

#ifdef __cplusplus
}
#endif

#endif
