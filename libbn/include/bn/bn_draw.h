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
 * entry of the table fixes the digital shift (sx, sy) that turns one fixed set of 256 points, a
 * scrambled Sobol' (0,8,2)-net, into the set of the pixel, its order included, and the next eight
 * digits (fx, fy) of its points; an offline search chose the entries so that the errors of every
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

/* The fixed point set: x[d] and y[d] are the scrambled coordinates of the points whose first eight
 * digits are d, 32 bits with the scrambling of the lower digits; reverse[i] is the byte i with its
 * bits reversed, second[d] the first eight digits of the second coordinate for digits d of the
 * first. */
typedef struct bn_digit_tables {
    uint32_t x[256], y[256];
    uint8_t reverse[256], second[256];
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

/* ---- Bits
 * ----------------------------------------------------------------------------------------- */

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
        tables->y[d] = bn_owen(d << 24, 0x8e5d3aa1u);
        tables->reverse[d] = (uint8_t)(bn_reverse_bits(d) >> 24);
        tables->second[d] = (uint8_t)(bn_sobol_second(d << 24) >> 24);
    }
}

/* ---- BLUE
 * ----------------------------------------------------------------------------------------- */

/* The coordinate of one dimension: `shifted` are its Sobol' digits with the pixel's shift in the
 * first eight, `later` those of them below the first eight that come from the index alone, `first`
 * the coordinate that the first 256 samples have at this byte. Where `later` begins, the path
 * leaves that of the first 256 samples; from there on the pixel has an Owen scrambling of its own.
 */
static inline uint32_t bn_draw_continue(uint32_t first, uint32_t shifted, uint32_t later,
                                        uint32_t key) {
    uint32_t below = later | (later >> 1);
    below |= below >> 2;
    below |= below >> 4;
    below |= below >> 8;
    below |= below >> 16;
    uint32_t leading = below ^ (below >> 1);
    below >>= 1;
    return ((first ^ leading) & ~below) | (bn_owen(shifted, key) & below);
}

/* Two dimensions. variant: 20 bits that choose shift and symmetries; digits: the bit-reversed
 * index. */
static inline void bn_draw_blue_pair(const bn_draw_table *table, uint32_t x, uint32_t y,
                                     uint32_t digits, uint32_t variant, uint32_t key,
                                     uint32_t out[2]) {
    uint32_t shift = table->size_log2, mask = (1u << shift) - 1u, u, v, swap, entry, s;
    u = (x + variant) ^ (0u - (variant >> 14 & 1u));
    v = (y + (variant >> 7)) ^ (0u - (variant >> 15 & 1u));
    swap = (u ^ v) & (0u - (variant >> 16 & 1u));
    u = (u ^ swap) & mask;
    v = (v ^ swap) & mask;
    entry = table->pixels[(v << shift) | u];

    /* The shuffle: nested in the index from its top bit down, and fixing zero, so that it maps
     * every power-of-two prefix to itself. */
    s = digits ^ (digits * (key & ~1u));

    uint32_t first_x = table->digits.x[(s >> 24) ^ (entry & 255u)];
    first_x ^= (entry & 0x00ff0000u) ^ (key & 0xffffu);
    if (digits << 8 == 0u) {
        u = first_x;
        v = table->digits.y[table->digits.second[s >> 24] ^ (entry >> 8 & 255u)];
        v ^= (entry >> 8 & 0x00ff0000u) ^ (key >> 16);
    } else {
        uint32_t second = bn_sobol_second(s);
        uint32_t first_y = table->digits.y[(second >> 24) ^ (entry >> 8 & 255u)];
        first_y ^= (entry >> 8 & 0x00ff0000u) ^ (key >> 16);
        u = bn_draw_continue(first_x, s ^ (entry << 24), s & 0xffffffu, key * 0x9e3779b1u);
        v = bn_draw_continue(first_y, second ^ ((entry & 0xff00u) << 16), second & 0xffffffu,
                             bn_hash32(key));
    }
    u ^= 0u - (variant >> 17 & 1u);
    v ^= 0u - (variant >> 18 & 1u);
    swap = (u ^ v) & (0u - (variant >> 19 & 1u));
    out[0] = u ^ swap;
    out[1] = v ^ swap;
}

static inline void bn_draw_blue(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                uint32_t domain, uint32_t out[4]) {
    uint32_t variant0 = bn_hash32(domain + table->seed[0]);
    uint32_t variant1 = bn_hash32(domain ^ table->seed[1]);
    uint32_t key0 = bn_hash32((uint32_t)x * 0x8da6b343u + (uint32_t)y * 0xd8163841u +
                              (variant0 ^ (variant1 << 7 | variant1 >> 25)));
    uint32_t key1 = (key0 ^ variant1) * 0xc2b2ae35u;
    uint32_t digits =
        index < 256u ? (uint32_t)table->digits.reverse[index] << 24 : bn_reverse_bits(index);
    key1 ^= key1 >> 15;
    bn_draw_blue_pair(table, (uint32_t)x, (uint32_t)y, digits, variant0, key0, out);
    bn_draw_blue_pair(table, (uint32_t)x, (uint32_t)y, digits, variant1, key1, out + 2);
}

/* ---- SOBOL and WHITE
 * ------------------------------------------------------------------------------ */

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

/* ---- The draws
 * ------------------------------------------------------------------------------------ */

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
    return (float)(bits >> 8) * 0x1p-24f;
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
