/* SPDX-License-Identifier: Apache-2.0
 * The draws of bn.h as inline functions, for renderers that want them inside their own loops.
 * Bit-equal to bn_sample_4d_u32() and its relatives:
 *
 *     const bn_draw_table *table = bn_sampler_table(sampler);
 *     float u[4];
 *     bn_draw_4d(table, x, y, index, domain, u);
 *
 * The table lives as long as its sampler. Kinds BLUE, SOBOL and WHITE are drawn inline; for ZORDER
 * and MASK the inline form calls the library. Everything is unsigned integer arithmetic, of 64 bits
 * only in a few products: bn_draw.glsl is the same text for a graphics processor.
 *
 * HOW BLUE WORKS. Dimensions (0, 1) and (2, 3) are two looks at one toroidal table of pixels, with
 * shifts and symmetries of the table and of the unit square chosen by a hash of the domain: 2^19
 * equally likely variants of each look, 2^37 of both together. An entry gives the pixel its set of
 * 256 points: digital shifts (sx, sy) of the two coordinates of one fixed scrambled Sobol'
 * (0,8,2)-net, which also decide the order of the points, and the next eight digits (fx, fy). An
 * offline search chose the entries so that the errors of every power-of-two prefix are blue over
 * the screen (libbn/tools/bn_bake_sampler.c).
 *
 * The order of the points is the same net's for both pairs but for a fixed linear map of the index,
 * which makes the four dimensions together those of an SZ sequence: a (0,4)-sequence in base 4
 * (Ahmed et al., "SZ Sequences: Binary-Based (0, 2^q)-Sequences", 2025). The four domains of a
 * family, children of one parent by keys 4 k to 4 k + 3, have an order for each, chosen by
 * libbn/tools/bn_search_orders.c so that any two of them, too, are stratified together. None of
 * these maps moves a point out of a power-of-two prefix, so what the table arranges stays. A nested
 * shuffle of the index, different in every pixel and family, keeps prefixes in place as well and
 * makes families independent. Sample 256 and later ones continue every pixel's set as an
 * Owen-scrambled sequence of its own.
 *
 * WHAT IT COSTS. About 110 instructions on x86-64 for a draw of four dimensions, two looks into the
 * table of pixels (64 KiB), one into the orders (1 KiB for each of eight) and four into the point
 * set (2 KiB). Draws of many domains in one pixel, or of many indices, share what they have in
 * common when they are inlined into a loop. Samples from 256 on cost about eight times as much.
 * Include <emmintrin.h> before this header, where SSE2 is, and the last step works on the four
 * dimensions at once; the library itself does. Without it, or with BN_DRAW_PLAIN defined, this is
 * plain C: the same bits, somewhat slower. */
#ifndef BN_BN_DRAW_H
#define BN_BN_DRAW_H

#include <bn/bn.h>

/* What GCC, Clang and MSVC define in <emmintrin.h>. */
#if !defined(BN_DRAW_PLAIN) &&                                                                     \
    (defined(_EMMINTRIN_H_INCLUDED) || defined(__EMMINTRIN_H) || defined(_INCLUDED_EMM))
#define BN_DRAW_SSE2 1
#endif

/* One copy per translation unit, called: what is not worth its place in every loop. */
#if defined(__GNUC__)
#define BN_DRAW_RARE static __attribute__((noinline, unused))
#else
#define BN_DRAW_RARE static inline
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Changes whenever the layout of bn_draw_table or the values drawn from it change. */
#define BN_DRAW_TABLE_VERSION 3u

/* The fixed point set: x[d] and y[d] are the scrambled coordinates of the point whose bit-reversed
 * index is d, 32 bits each with the scrambling of the lower digits. */
typedef struct bn_digit_tables {
    uint32_t x[256], y[256];
} bn_digit_tables;

typedef struct bn_draw_table {
    uint32_t version;       /* BN_DRAW_TABLE_VERSION */
    int32_t kind;           /* BN_SAMPLER_... */
    uint32_t blue_indices;  /* 256 when kind is BLUE, else 0 */
    uint32_t size_log2;     /* the table of pixels has 2^size_log2 x 2^size_log2 entries; 1 to 7 */
    uint32_t seed[2];       /* the hashed seed, its low word first */
    const uint32_t *pixels; /* sx, sy, fx, fy: one byte each from the lowest up; row-major */
    const bn_sampler *sampler;
    /* 2^size_log2 - 1, alone and in each of four bytes, two of them for the columns and two for the
     * rows; rows are moved by 8 - size_log2 bits to stand beside columns. */
    uint32_t size_mask, byte_masks, column_masks, row_masks, row_shift, reserved;
    /* For the first 256 indices: the bit-reversed index, twice that, and what brings the index's
     * flip of the first digit into place; see bn_draw_blue_shuffle(). */
    struct {
        uint32_t digits, doubled, flip, reserved;
    } index[256];
    /* The order of the points by the upper three bits of the domain, which are the member of the
     * family and the form of the second pair, and the shuffled digits of the index: one byte for
     * each of the four coordinates. */
    uint32_t order[8][256];
    /* Symmetries of the unit square as masks, for both pairs: the reflections of the coordinates,
     * then the exchanges of the two. Sixteen-byte aligned where samplers are. */
    uint32_t symmetry[32][8];
    float scale[4]; /* 2^-24 */
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

/* bn_domain_child(): a hash of the parent and of the four that the key is in, and in the upper
 * two bits the place among the four. The draws hash what it gives once more. */
static inline uint32_t bn_draw_domain_child(uint32_t domain, uint32_t key) {
    uint32_t v = (domain + (key >> 2) * 0x85ebca6bu + 0x9e3779b9u) * 0x21f0aaadu;
    return (v ^ (v >> 16)) >> 2 | key << 30;
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

/* Fills the tables of the fixed point set. The two seeds were picked from many for a small error
 * under random digital shifts, which tests/quality/test_pixel_error.c watches over; the tables of
 * pixels were made for them. */
static inline void bn_digit_tables_fill(bn_digit_tables *tables) {
    for (uint32_t d = 0; d < 256; ++d) {
        tables->x[d] = bn_owen(d << 24, 0x32c0b0c2u);
        tables->y[d] = bn_owen(bn_sobol_second(d << 24), 0xe0f8ebf3u);
    }
}

/* The product of each digit to base 4 with one of the two elements of the field of four that are
 * not 0 or 1, two bits for a digit: x and x + 1 modulo x^2 + x + 1. */
static inline uint32_t bn_draw_times_x(uint32_t digits) {
    uint32_t upper = digits >> 1 & 0x55555555u, lower = digits & 0x55555555u;
    return lower << 1 | (upper ^ lower);
}

static inline uint32_t bn_draw_times_x_plus_1(uint32_t digits) {
    uint32_t upper = digits >> 1 & 0x55555555u, lower = digits & 0x55555555u;
    return (upper ^ lower) << 1 | upper;
}

/* From the digits of the first pair those of the second: the upper triangular matrix of entries
 * binomial(j, i) x^(j - i) over the field of four, which like bn_sobol_second() factors into a step
 * for each bit of j. With it (0, 1) and (2, 3) together are an SZ sequence. An odd `form` adds the
 * second digit of each two to the first, which only renames the digits to base 4: over both forms
 * the four cross pairs of dimensions are alike at few samples. */
static inline uint32_t bn_draw_second_pair(uint32_t digits, uint32_t form) {
    digits ^= (bn_draw_times_x(digits) << 2) & 0xccccccccu;
    digits ^= (bn_draw_times_x_plus_1(digits) << 4) & 0xf0f0f0f0u;
    digits ^= (bn_draw_times_x(digits) << 8) & 0xff00ff00u;
    digits ^= (bn_draw_times_x_plus_1(digits) << 16) & 0xffff0000u;
    return digits ^ ((digits << 1) & 0xaaaaaaaau & (0u - (form & 1u)));
}

/* The order of a member of a family: a linear map of the first eight digits, in the upper byte
 * each, of which no digit reaches a later one; what bit 7 - k becomes stands in byte k of the pair
 * of words. Found by libbn/tools/bn_search_orders.c. */
static inline uint32_t bn_draw_member(uint32_t digits, uint32_t member) {
    static const uint32_t images[4][2] = {
        {0x10204080u, 0x01020408u},
        {0x90a04080u, 0x7b125cf8u},
        {0x90204080u, 0xdd1e2c68u},
        {0x10a04080u, 0x755eac18u},
    };
    uint32_t low = images[member & 3u][0], high = images[member & 3u][1], mapped = 0;
    for (uint32_t k = 0; k < 4u; ++k) {
        mapped ^= (low >> 8u * k & 255u) & (0u - (digits >> (31u - k) & 1u));
        mapped ^= (high >> 8u * k & 255u) & (0u - (digits >> (27u - k) & 1u));
    }
    return mapped << 24 | (digits & 0x00ffffffu);
}

/* What 31 random bits are multiplied with so that bit 31 of the product is the flip of the first
 * digit of this index and its neighbour: one of the upper 16 of them, or the sum of several. */
static inline uint32_t bn_draw_flip(uint32_t index) {
    uint32_t t = (index >> 1) - 1u;
    uint32_t flip = 2u << (t & 15u);
    flip |= (index >> 5 & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= (index >> 6 & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= (index >> 7 & 1u) << (((t + 2u) & 15u) + 1u);
    return index < 2u ? 0u : flip;
}

/* Fills everything of a table that follows from kind and size_log2. */
static inline void bn_draw_table_fill(bn_draw_table *table) {
    table->version = BN_DRAW_TABLE_VERSION;
    table->blue_indices = table->kind == BN_SAMPLER_BLUE ? 256u : 0u;
    table->size_mask = (1u << table->size_log2) - 1u;
    table->byte_masks = table->size_mask * 0x01010101u;
    table->row_masks = table->byte_masks & 0xff00ff00u;
    table->column_masks = table->byte_masks & 0x00ff00ffu;
    table->row_shift = 8u - table->size_log2;
    for (uint32_t i = 0; i < 256u; ++i) {
        table->index[i].digits = bn_reverse_bits(i) >> 24;
        table->index[i].doubled = table->index[i].digits << 1;
        table->index[i].flip = bn_draw_flip(i);
        for (uint32_t order = 0; order < 8u; ++order) {
            uint32_t first = bn_draw_member(i << 24, order >> 1);
            uint32_t second = bn_draw_second_pair(first, order);
            table->order[order][i] = (first >> 24 | second >> 24 << 16) * 0x101u;
        }
    }
    for (uint32_t i = 0; i < 32u; ++i) {
        for (uint32_t d = 0; d < 4u; ++d) {
            table->symmetry[i][d] = 0u - (i >> d & 1u);
            table->symmetry[i][4u + d] = 0u - ((i >> 4 ^ d >> 1) & 1u);
        }
    }
    for (uint32_t d = 0; d < 4u; ++d) table->scale[d] = 1.0f / 16777216.0f;
    bn_digit_tables_fill(&table->digits);
}

/* ---- BLUE -----------------------------------------------------------------------------------
 * In two steps, so that a loop over the indices of a pixel does the first one once. */

/* A pixel in a domain: the two entries it looks at, and its random bits. */
typedef struct bn_blue_pixel {
    uint32_t shifts;  /* digital shifts of the fixed point set: sx, sy of both pairs, a byte each */
    uint32_t fine;    /* digits 8 to 15: fx, fy of both pairs, a byte each */
    uint64_t key;     /* digits 16 to 31 */
    uint32_t shuffle; /* of the index: the lower 31 bits, the same for all members of a family */
    uint32_t order;   /* twice the member of the family, and the form of the second pair */
    uint32_t symmetry; /* four reflections of the unit square, and the look that is exchanged */
} bn_blue_pixel;

static inline bn_blue_pixel bn_draw_blue_pixel(const bn_draw_table *table, int32_t x, int32_t y,
                                               uint32_t domain) {
    bn_blue_pixel pixel;
    /* The upper bits of a product depend on all of the domain. */
    uint64_t seed = table->seed[0] | (uint64_t)table->seed[1] << 32;
    uint64_t variant = domain * 0x9e3779b97f4a7c15ull + seed;
    uint32_t shift = (uint32_t)(variant >> 32);
    uint32_t symmetry = (uint32_t)variant >> 27, exchange = symmetry & 16u;
    /* Column and row of the first look in the lower two bytes, row and column of the second in the
     * upper two, or the other way round: of one domain the two looks always differ. Shifted, then
     * reflected. Where rows and columns are exchanged, so are the coordinates. */
    uint32_t place = ((uint32_t)x & 127u) * 0x01000001u | ((uint32_t)y & 127u) * 0x00010100u;
    place = place << exchange | place >> ((32u - exchange) & 31u);
    uint32_t reflect = shift & 0x80808080u;
    place = (place + (shift & 0x7f7f7f7fu)) ^ (reflect - (reflect >> 7));
    place = (place & table->column_masks) | (place & table->row_masks) >> table->row_shift;
    uint32_t entry0 = table->pixels[place & 0xffffu], entry1 = table->pixels[place >> 16];
    pixel.shifts = (entry0 & 0xffffu) | entry1 << 16;
    pixel.fine = entry0 >> 16 | (entry1 & 0xffff0000u);
    uint64_t position = ((uint32_t)x + (uint32_t)y * 0x9e3779b1u) * 0xd1342543de82ef95ull;
    position ^= position >> 32;
    pixel.key = (position ^ variant) * 0x9e3779b97f4a7c15ull;
    /* The lower 30 bits of the product are the family's: the member is above them. */
    pixel.shuffle = ((uint32_t)variant << 1) + (uint32_t)position;
    pixel.order = domain >> 29;
    pixel.symmetry = symmetry;
    return pixel;
}

/* The shuffled digits of one of the first 256 indices. Each digit is flipped by its later ones: by
 * a product, nested in the index from its top bit down, and the first digit also by random bits of
 * its own, which the product alone would leave equal in one of eight pairs of families over the
 * first 16 samples of a pixel. Now two families share the order of its first 32 samples once in
 * 2^18 pairs. Zero stays where it is, so that every power-of-two prefix is mapped to itself. */
static inline uint32_t bn_draw_blue_shuffle(const bn_draw_table *table, uint32_t shuffle,
                                            uint32_t index) {
    uint32_t digits = shuffle * table->index[index].doubled ^ table->index[index].digits;
    return (digits ^ (shuffle * table->index[index].flip >> 24 & 0x80u)) & 255u;
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

/* The digits of any index in the order of the first pair. Every 256 samples the order is another,
 * and the domain's own: the lower digits flip the upper ones. */
static inline uint32_t bn_draw_blue_digits(const bn_blue_pixel *pixel, uint32_t index) {
    uint32_t digits = bn_reverse_bits(index);
    digits ^= digits * (pixel->shuffle << 1);
    digits ^= pixel->shuffle * bn_draw_flip(index) & 0x80000000u;
    digits = bn_draw_member(digits, pixel->order >> 1);
    return digits ^ ((digits & 0x00ffffffu) * ((uint32_t)(pixel->key >> 32) | 1u) & 0xff000000u);
}

/* One pair of dimensions from sample 256 on. lower: what the coordinates of the point set are XORed
 * with; key: the pixel's key of the pair. */
static inline void bn_draw_blue_later(const bn_draw_table *table, uint32_t shifts,
                                      const uint32_t lower[2], uint32_t key, uint32_t digits,
                                      uint32_t out[2]) {
    uint32_t second = bn_sobol_second(digits);
    /* Later digits of the index reach up into the first eight of y. */
    uint32_t shifted = bn_sobol_second((shifts >> 8 & 255u) << 24) ^ second;
    uint32_t x = table->digits.x[(digits >> 24) ^ (shifts & 255u)] ^ lower[0];
    uint32_t y = table->digits.y[bn_sobol_second(shifted & 0xff000000u) >> 24] ^ lower[1];
    out[0] =
        bn_draw_continue(x, digits ^ (shifts & 255u) << 24, digits & 0x00ffffffu, bn_hash32(key));
    out[1] = bn_draw_continue(y, shifted, second & 0x00ffffffu, bn_hash32(~key));
}

/* The point of one of the first 256 indices: its place in the point set before the pixel's shifts,
 * one byte for each of the four coordinates. */
static inline uint32_t bn_draw_blue_order(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                          uint32_t index) {
    return table->order[pixel->order][bn_draw_blue_shuffle(table, pixel->shuffle, index)];
}

/* What the coordinates of the point set are XORed with: the lower digits. */
static inline void bn_draw_blue_lower(const bn_blue_pixel *pixel, uint32_t lower[4]) {
    for (uint32_t d = 0; d < 4u; ++d) {
        lower[d] = ((uint32_t)(pixel->key >> 16u * d) & 0xffffu) | (pixel->fine >> 8u * d & 255u)
                                                                       << 16;
    }
}

/* Reflections and exchanges of the coordinates. */
static inline void bn_draw_blue_reflect(uint32_t symmetry, uint32_t v[4]) {
    for (uint32_t d = 0; d < 4u; ++d) v[d] ^= 0u - (symmetry >> d & 1u);
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        uint32_t exchange =
            (v[2u * pair] ^ v[2u * pair + 1u]) & (0u - ((symmetry >> 4 ^ pair) & 1u));
        v[2u * pair] ^= exchange;
        v[2u * pair + 1u] ^= exchange;
    }
}

/* Sample 256 and later ones of a pixel. */
static inline void bn_draw_blue_beyond(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                       uint32_t index, uint32_t out[4]) {
    uint32_t lower[4];
    uint32_t digits = bn_draw_blue_digits(pixel, index), key = (uint32_t)(pixel->key >> 32);
    bn_draw_blue_lower(pixel, lower);
    bn_draw_blue_later(table, pixel->shifts, lower, key, digits, out);
    bn_draw_blue_later(table, pixel->shifts >> 16, lower + 2, key >> 16 | key << 16,
                       bn_draw_second_pair(digits, pixel->order), out + 2);
    bn_draw_blue_reflect(pixel->symmetry, out);
}

#if defined(BN_DRAW_SSE2)

/* The first 256 samples, the four dimensions in one register. */
static inline __m128i bn_draw_blue_first(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                         uint32_t index) {
    const __m128i *symmetry = (const __m128i *)(const void *)table->symmetry[pixel->symmetry];
    uint32_t order = bn_draw_blue_order(table, pixel, index) ^ pixel->shifts;
    uint32_t second = order >> 16;
    __m128i v = _mm_unpacklo_epi64(
        _mm_unpacklo_epi32(_mm_cvtsi32_si128((int)table->digits.x[order & 255u]),
                           _mm_cvtsi32_si128((int)table->digits.y[order >> 8 & 255u])),
        _mm_unpacklo_epi32(_mm_cvtsi32_si128((int)table->digits.x[second & 255u]),
                           _mm_cvtsi32_si128((int)table->digits.y[second >> 8])));
    __m128i fine = _mm_unpacklo_epi8(_mm_cvtsi32_si128((int)pixel->fine), _mm_setzero_si128());
    __m128i lower = _mm_unpacklo_epi16(_mm_cvtsi64_si128((long long)pixel->key), fine);
    v = _mm_xor_si128(v, _mm_xor_si128(lower, _mm_load_si128(symmetry)));
    __m128i exchange =
        _mm_and_si128(_mm_xor_si128(v, _mm_shuffle_epi32(v, 0xb1)), _mm_load_si128(symmetry + 1));
    return _mm_xor_si128(v, exchange);
}

#else

/* The first 256 samples. */
static inline void bn_draw_blue_first(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                      uint32_t index, uint32_t out[4]) {
    uint32_t lower[4];
    uint32_t order = bn_draw_blue_order(table, pixel, index) ^ pixel->shifts;
    bn_draw_blue_lower(pixel, lower);
    out[0] = table->digits.x[order & 255u] ^ lower[0];
    out[1] = table->digits.y[order >> 8 & 255u] ^ lower[1];
    out[2] = table->digits.x[order >> 16 & 255u] ^ lower[2];
    out[3] = table->digits.y[order >> 24] ^ lower[3];
    bn_draw_blue_reflect(pixel->symmetry, out);
}

#endif

static inline void bn_draw_blue_at(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                   uint32_t index, uint32_t out[4]) {
    if (index >= 256u) {
        bn_draw_blue_beyond(table, pixel, index, out);
        return;
    }
#if defined(BN_DRAW_SSE2)
    _mm_storeu_si128((__m128i *)(void *)out, bn_draw_blue_first(table, pixel, index));
#else
    bn_draw_blue_first(table, pixel, index, out);
#endif
}

static inline void bn_draw_blue(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                uint32_t domain, uint32_t out[4]) {
    bn_blue_pixel pixel = bn_draw_blue_pixel(table, x, y, domain);
    bn_draw_blue_at(table, &pixel, index, out);
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
    /* 2^-24; C++11 has no hexadecimal floats. What is converted fits a signed integer. */
    return (float)(int32_t)(bits >> 8) * (1.0f / 16777216.0f);
}

/* What bn_draw_4d() does not do at once. */
BN_DRAW_RARE void bn_draw_4d_rare(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                                  uint32_t domain, float out[4]) {
    uint32_t bits[4];
    bn_draw_4d_u32(table, x, y, index, domain, bits);
    for (int d = 0; d < 4; ++d) out[d] = bn_draw_float(bits[d]);
}

static inline void bn_draw_4d(const bn_draw_table *table, int32_t x, int32_t y, uint32_t index,
                              uint32_t domain, float out[4]) {
    if (index < table->blue_indices) {
        bn_blue_pixel pixel = bn_draw_blue_pixel(table, x, y, domain);
#if defined(BN_DRAW_SSE2)
        __m128i v = _mm_srli_epi32(bn_draw_blue_first(table, &pixel, index), 8);
        _mm_storeu_ps(out, _mm_mul_ps(_mm_cvtepi32_ps(v), _mm_load_ps(table->scale)));
#else
        uint32_t bits[4];
        bn_draw_blue_first(table, &pixel, index, bits);
        out[0] = bn_draw_float(bits[0]);
        out[1] = bn_draw_float(bits[1]);
        out[2] = bn_draw_float(bits[2]);
        out[3] = bn_draw_float(bits[3]);
#endif
    } else {
        bn_draw_4d_rare(table, x, y, index, domain, out);
    }
}

#ifdef __cplusplus
}
#endif

#endif
