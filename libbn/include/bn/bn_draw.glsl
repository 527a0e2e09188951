/* SPDX-License-Identifier: Apache-2.0
 * BLUE, SOBOL and WHITE draws in the common subset of GLSL, HLSL, Metal, CUDA and C. They are
 * bit-identical to those of bn_sample_4d(). bn_draw.h, bn_draw.hlsl and bn_draw.metal include this
 * file; libbn/tools/make_wgsl.py translates it to bn_draw.wgsl. See docs/shaders.md.
 *
 * In a shader (GLSL 3.30 or GLSL ES 3.00, no extensions), define BN_WORD(i) to read word i of
 * bn_tables(), then include this file. The seed comes from bn_sampler_seed():
 *
 *     #version 430
 *     layout(std430, binding = 0) readonly buffer bn_table { uint bn_words[]; };
 *     #define BN_WORD(i) bn_words[i]
 *     uniform uvec2 seed;
 *
 *     vec4 u = bn_draw_blue_4d(seed, uint(pixel.x), uint(pixel.y), index, domain);
 *     vec2 v = bn_draw_blue_2d(seed, uint(pixel.x), uint(pixel.y), index, domain, 1u); // u.zw
 *
 * Coordinates are signed integers reinterpreted as unsigned: uint(-1) is the column to the left of
 * column 0. In APIs without storage buffers, such as WebGL 2, read the words from a texture:
 *
 *     uniform highp usampler2D bn_words; // R32UI, 64 texels wide
 *     #define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
 *
 * Upload that texture with default unpack parameters: a flipped one returns white noise without an error.
 *
 * Names that begin with bn_ are reserved. bn_draw.h explains how BLUE works. */
#ifndef BN_DRAW_GLSL
#define BN_DRAW_GLSL

#ifndef BN_ANY
/* Whether v, or any lane of a vector v, is nonzero. */
#define BN_ANY(v) ((v) != 0u)
#endif

#ifndef BN_FUNCTION
#ifdef GL_ES
precision highp float;
precision highp int;
#endif
#define BN_UINT uint
#define BN_FUNCTION
#endif

#ifndef BN_TABLE
#define BN_FLOAT2 vec2
#define BN_FLOAT4 vec4
#define bn_uint2 uvec2
#define bn_uint4 uvec4
#define BN_TABLE
#define BN_PASS_TABLE
#define bn_draw_domain_child bn_domain_child
/* Newer GLSL versions have a built-in function for this. */
#if __VERSION__ >= 400 || (defined(GL_ES) && __VERSION__ >= 310)
#define BN_REVERSE_BITS(v) bitfieldReverse(v)
#endif
#endif

/* THE TABLES
 *
 * One flat buffer of BN_WORD_COUNT 32-bit words (46.5 KiB). It is the same for every seed, and only
 * BLUE reads it. Each bit of a pixel's label and of a sample's index XORs a vector of digits into the
 * four coordinates; the tables hold sums of these vectors. A label is a pixel's path through the quadtree
 * of the 64 x 64 pixel tile: its upper eight bits select a block of 4 x 4 pixels, and its lower four, the
 * place, the pixel in the block (docs/blue.md, "Terms").
 *
 * A two-word entry holds the upper 16 digits of the four coordinates, packed into one half-word each,
 * lowest first. A four-word entry holds all 32 digits of each coordinate. `member` is the domain's
 * number within its family, 0 to 3. */
#define BN_PIXELS_AT 0u    /* [64][64]: byte m of a pixel's word is its place for member m */
#define BN_BLOCKS_AT 4096u /* [16][16][member][2]: digits of a block, row-major */
#define BN_PLACES_AT 6144u /* [member][16][2]: digits of a place */
#define BN_POINTS_AT 6272u /* [256][member][4]: the first 256 samples, by reversed index */
#define BN_LATER_AT 10368u /* [6][16][member][4]: digits for index bits 8 to 31, four at a time */
#define BN_WORD_COUNT 11904u

#ifndef bn_uint4 /* otherwise a built-in vector type */
struct bn_uint4 {
    BN_UINT x, y, z, w;
};
struct bn_uint2 {
    BN_UINT x, y;
};
#endif

/* Four consecutive words. For a two-word entry, the last two are ignored. */
#ifndef BN_ROW
#define BN_ROW(at) bn_draw_row(BN_PASS_TABLE at)
BN_FUNCTION bn_uint4 bn_draw_row(BN_TABLE BN_UINT at) {
    bn_uint4 row;
    row.x = BN_WORD(at);
    row.y = BN_WORD(at + 1u);
    row.z = BN_WORD(at + 2u);
    row.w = BN_WORD(at + 3u);
    return row;
}
#endif

/* Two consecutive words. */
#ifndef BN_HALF_ROW
#define BN_HALF_ROW(at) bn_draw_half_row(BN_PASS_TABLE at)
BN_FUNCTION bn_uint2 bn_draw_half_row(BN_TABLE BN_UINT at) {
    bn_uint2 row;
    row.x = BN_WORD(at);
    row.y = BN_WORD(at + 1u);
    return row;
}
#endif

/* ---- Bits */

#ifndef BN_REVERSE_BITS
#define BN_REVERSE_BITS(v) bn_reverse_bits(v)
BN_FUNCTION BN_UINT bn_reverse_bits(BN_UINT v) {
    v = (v >> 16u) | (v << 16u);
    v = ((v >> 8u) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8u);
    v = ((v >> 4u) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4u);
    v = ((v >> 2u) & 0x33333333u) | ((v & 0x33333333u) << 2u);
    return ((v >> 1u) & 0x55555555u) | ((v & 0x55555555u) << 1u);
}
#endif

/* A bijection in which every input bit affects every output bit (structure and constants: Wellons,
 * "Prospecting for Hash Functions", 2018). */
BN_FUNCTION BN_UINT bn_hash32(BN_UINT v) {
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0xd35a2d97u;
    return v ^ (v >> 15u);
}

/* bn_domain_child(): a hash of the parent and key / 4, which all members of a family share. The upper
 * two bits hold the member number. The draws hash the result once more. Before the last step, which
 * leaves the upper half unchanged, families with the same parent differ by multiples of the golden
 * ratio. As a result, no two of any thirty consecutive families share their upper six bits, which BLUE
 * uses as the family's shift. */
BN_FUNCTION BN_UINT bn_draw_domain_child(BN_UINT domain, BN_UINT key) {
    BN_UINT v = (domain + (key >> 2u) * 0x121658bdu + 0x9e3779b9u) * 0x21f0aaadu;
    v = ((v ^ (v >> 16u)) & 0xfffffffcu) | (key & 3u);
    return v >> 2u | v << 30u;
}

/* Nested uniform (Owen) scrambling of bit-reversed digits: each output bit is the input bit, flipped
 * according to a hash of the bits below it (Laine and Karras, "Stratified Sampling for Stochastic
 * Transparency", 2011; mixing constants from Vegdahl, "Building a Better LK Hash", 2021). */
BN_FUNCTION BN_UINT bn_owen_reversed(BN_UINT v, BN_UINT seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

BN_FUNCTION BN_UINT bn_owen(BN_UINT digits, BN_UINT seed) {
    return BN_REVERSE_BITS(bn_owen_reversed(BN_REVERSE_BITS(digits), seed));
}

/* The second coordinate of the Sobol' (0,2)-sequence, computed from the first. Let d_0 (the most
 * significant bit) to d_31 be the digits of the radical inverse; digit k of the result is the sum over
 * j of binomial(j, k) d_j mod 2. The binomial is odd exactly when k is a bitwise subset of j, so the
 * sum factors into five steps, one per bit of j (Ahmed, "An Implementation Algorithm of 2D Sobol
 * Sequence Fast, Elegant, and Compact", 2024). */
BN_FUNCTION BN_UINT bn_sobol_second(BN_UINT digits) {
    digits ^= (digits << 1u) & 0xaaaaaaaau;
    digits ^= (digits << 2u) & 0xccccccccu;
    digits ^= (digits << 4u) & 0xf0f0f0f0u;
    digits ^= (digits << 8u) & 0xff00ff00u;
    digits ^= (digits << 16u) & 0xffff0000u;
    return digits;
}

/* ---- BLUE: a pixel in a domain, then its samples */

struct bn_blue_pixel {
    BN_UINT at;           /* the pixel's position in the tile: 64 row + column */
    BN_UINT place, block; /* the two parts of its label: indices of two-word entries */
    BN_UINT keys;         /* random upper 16 digits of the tile's copy, for pair 0 */
    BN_UINT low;          /* random lower 16 digits of the pixel, for pair 0, one half-word each */
    BN_UINT shuffle;      /* the copy's sample order; the same for all members of a family */
    BN_UINT member;       /* number within the family */
};

/* A factor that gives each member its own random digits. */
#ifndef BN_KEY_FACTOR
#define BN_KEY_FACTOR(member) bn_draw_key_factor(member)
BN_FUNCTION BN_UINT bn_draw_key_factor(BN_UINT member) {
    return member * 0x0bd794d6u + 0xd35a2d97u;
}
#endif

BN_FUNCTION bn_blue_pixel bn_draw_blue_pixel(BN_TABLE bn_uint2 seed, BN_UINT x, BN_UINT y,
                                             BN_UINT domain) {
    bn_blue_pixel pixel;
    BN_UINT turned = domain << 2u | domain >> 30u, member = turned & 3u;
    pixel.member = member;
    /* A hash of the family, whose four members differ only in the upper two bits of the domain. */
    BN_UINT start = (turned & 0xfffffffcu) ^ seed.x;
    BN_UINT family = start * 0x21f0aaadu;
    family = (family ^ (family >> 16u)) * 0xd35a2d97u + seed.y;
    /* Reflect and shift the tile. Only the lower six bits of the y shift move it; the other bits
     * renumber the copies. */
    BN_UINT column = (x ^ (0u - (family >> 31u))) + (start >> 26u);
    BN_UINT row = (y ^ (0u - (family >> 19u & 1u))) + (family >> 20u);
    /* Each copy of the tile has its own random digits and sample order, which all its pixels share.
     * The error is therefore as blue between powers of two as at them. */
    BN_UINT copy = (column >> 6u) + (row >> 6u) * 0x9e3779b1u + family;
    copy = (copy ^ (copy >> 16u)) * 0x21f0aaadu;
    copy ^= copy >> 15u;
    pixel.shuffle = copy;
    /* The two parts of the pixel's label, its path through the quadtree. Two copies of the code that
     * reads them are written by hand: for SSE2 in bn_draw.h, and for arrays in
     * bindings/bluenoise/arrays.py. Tests compare the bits of all three. */
    pixel.at = (row & 63u) << 6u | (column & 63u);
    BN_UINT places = BN_WORD(BN_PIXELS_AT + pixel.at);
    pixel.place = BN_PLACES_AT / 2u + (places >> (8u * member) & 15u) + member * 16u;
    pixel.block = BN_BLOCKS_AT / 2u + ((pixel.at & 0xf00u) >> 2u) + (pixel.at & 0x3cu) + member;
    BN_UINT keys = copy * BN_KEY_FACTOR(member);
    keys ^= keys >> 16u;
    pixel.keys = keys;
    pixel.low = (bn_hash32(x + y * 0x9e3779b1u) ^ keys) * 0x21f0aaadu;
    return pixel;
}

/* The keys for pair 1, rotated so that the four coordinates' first eight digits use different bits of
 * the hash. The low digits for pair 1 are low ^ keys. */
BN_FUNCTION BN_UINT bn_draw_second_keys(BN_UINT keys) {
    return keys << 8u | keys >> 24u;
}

/* A factor for the shuffle: bit 31 of the product decides whether the sample order exchanges this
 * index with its neighbour, index ^ 1. That bit is one of the shuffle's lower bits, or a sum of
 * several. The factor depends only on the index's lowest eight bits. */
BN_FUNCTION BN_UINT bn_draw_flip(BN_UINT index) {
    BN_UINT t = ((index & 255u) >> 1u) - 1u;
    BN_UINT flip = 2u << (t & 15u);
    flip |= (index >> 5u & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= (index >> 6u & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= (index >> 7u & 1u) << (((t + 2u) & 15u) + 1u);
    return flip & ((t >> 31u) - 1u); /* zero for the first pair, where t is 2^32 - 1 */
}

/* Applies the copy's sample order to the reversed digits of an index. The product flips each digit
 * depending on the digits after it, that is, on the higher bits of the index. Separate random bits
 * also flip the first digit; otherwise one in eight pairs of families would flip it identically over a
 * pixel's first 16 samples. Zero maps to zero, so every power-of-two prefix maps to itself. */
BN_FUNCTION BN_UINT bn_draw_blue_digits(BN_UINT shuffle, BN_UINT reversed, BN_UINT flip) {
    return reversed ^ reversed * (shuffle << 1u) ^ ((shuffle * flip) & 0x80000000u);
}

BN_FUNCTION bn_uint4 bn_draw_blue_at(BN_TABLE bn_blue_pixel pixel, BN_UINT index) {
    BN_UINT digits =
        bn_draw_blue_digits(pixel.shuffle, BN_REVERSE_BITS(index), bn_draw_flip(index));
    bn_uint4 v = BN_ROW(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 4u);
    bn_uint4 place = BN_ROW(pixel.place * 2u), block = BN_ROW(pixel.block * 2u);
    BN_UINT high = place.x ^ block.x ^ pixel.keys, low = pixel.low;
    v.x ^= high << 16u | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | low >> 16u;
    high = place.y ^ block.y ^ bn_draw_second_keys(pixel.keys);
    low ^= pixel.keys;
    v.z ^= high << 16u | (low & 0xffffu);
    v.w ^= (high & 0xffff0000u) | low >> 16u;
    BN_UINT later = BN_LATER_AT + pixel.member * 4u;
    for (digits <<= 8u; BN_ANY(digits); digits <<= 4u) {
        bn_uint4 row = BN_ROW(later + (digits >> 28u) * 16u);
        v.x ^= row.x;
        v.y ^= row.y;
        v.z ^= row.z;
        v.w ^= row.w;
        later += 256u;
    }
    return v;
}

/* The sample for these digits in one pair of dimensions, 0 or 1, before bits 8 to 31 of the index are
 * added. */
BN_FUNCTION bn_uint2 bn_draw_blue_pair_first(BN_TABLE bn_blue_pixel pixel, BN_UINT digits,
                                             BN_UINT pair) {
    pair &= 1u;
    BN_UINT second = 0u - pair;
    BN_UINT high = BN_WORD(pixel.place * 2u + pair) ^ BN_WORD(pixel.block * 2u + pair);
    high ^= pixel.keys ^ ((pixel.keys ^ bn_draw_second_keys(pixel.keys)) & second);
    BN_UINT low = pixel.low ^ (pixel.keys & second);
    bn_uint2 v = BN_HALF_ROW(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 4u + pair * 2u);
    v.x ^= high << 16u | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | low >> 16u;
    return v;
}

BN_FUNCTION bn_uint2 bn_draw_blue_pair_at(BN_TABLE bn_blue_pixel pixel, BN_UINT index,
                                          BN_UINT pair) {
    BN_UINT digits =
        bn_draw_blue_digits(pixel.shuffle, BN_REVERSE_BITS(index), bn_draw_flip(index));
    bn_uint2 v = bn_draw_blue_pair_first(BN_PASS_TABLE pixel, digits, pair);
    BN_UINT later = BN_LATER_AT + pixel.member * 4u + (pair & 1u) * 2u;
    for (digits <<= 8u; BN_ANY(digits); digits <<= 4u) {
        bn_uint2 row = BN_HALF_ROW(later + (digits >> 28u) * 16u);
        v.x ^= row.x;
        v.y ^= row.y;
        later += 256u;
    }
    return v;
}

BN_FUNCTION bn_uint2 bn_draw_blue_pair_bits(BN_TABLE bn_uint2 seed, BN_UINT x, BN_UINT y,
                                            BN_UINT index, BN_UINT domain, BN_UINT pair) {
    bn_blue_pixel pixel = bn_draw_blue_pixel(BN_PASS_TABLE seed, x, y, domain);
    return bn_draw_blue_pair_at(BN_PASS_TABLE pixel, index, pair);
}

BN_FUNCTION bn_uint4 bn_draw_blue_bits(BN_TABLE bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain) {
    return bn_draw_blue_at(BN_PASS_TABLE bn_draw_blue_pixel(BN_PASS_TABLE seed, x, y, domain),
                           index);
}

/* ---- SOBOL and WHITE */

BN_FUNCTION BN_UINT bn_draw_sobol_next(BN_UINT key) {
    return bn_hash32(key + 0x9e3779b9u);
}

/* The first scrambling key of a domain. Each pair uses three consecutive keys. */
BN_FUNCTION BN_UINT bn_draw_sobol_key(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT domain) {
    BN_UINT key = bn_hash32(y ^ bn_hash32(domain + seed.x));
    return bn_hash32(x ^ bn_hash32(key + seed.y));
}

BN_FUNCTION BN_UINT bn_draw_sobol_second_key(BN_UINT key) {
    return bn_draw_sobol_next(bn_draw_sobol_next(bn_draw_sobol_next(key)));
}

BN_FUNCTION bn_uint2 bn_draw_sobol_two(BN_UINT key, BN_UINT index) {
    bn_uint2 v;
    BN_UINT digits = bn_owen_reversed(BN_REVERSE_BITS(index), key);
    key = bn_draw_sobol_next(key);
    v.x = bn_owen(digits, key);
    v.y = bn_owen(bn_sobol_second(digits), bn_draw_sobol_next(key));
    return v;
}

BN_FUNCTION bn_uint2 bn_draw_sobol_pair_bits(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                             BN_UINT domain, BN_UINT pair) {
    BN_UINT key = bn_draw_sobol_key(seed, x, y, domain);
    key ^= (key ^ bn_draw_sobol_second_key(key)) & (0u - (pair & 1u));
    return bn_draw_sobol_two(key, index);
}

BN_FUNCTION bn_uint4 bn_draw_sobol_bits(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                        BN_UINT domain) {
    bn_uint4 v;
    BN_UINT key = bn_draw_sobol_key(seed, x, y, domain);
    bn_uint2 two = bn_draw_sobol_two(key, index);
    v.x = two.x;
    v.y = two.y;
    two = bn_draw_sobol_two(bn_draw_sobol_second_key(key), index);
    v.z = two.x;
    v.w = two.y;
    return v;
}

/* WHITE: pcg4d, which hashes four words to four (Jarzynski and Olano, "Hash Functions for GPU
 * Rendering", 2020, after O'Neill's generators). The pixel, index and domain form the counter, to
 * which the seed is added. The domain is mixed first because the members of a family differ in only
 * two bits. */
BN_FUNCTION bn_uint4 bn_draw_white_hash(bn_uint4 v) {
    v.w = (v.w ^ (v.w >> 16u)) * 0x21f0aaadu;
    v.x = v.x * 1664525u + 1013904223u;
    v.y = v.y * 1664525u + 1013904223u;
    v.z = v.z * 1664525u + 1013904223u;
    v.w = v.w * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v.x ^= v.x >> 16u;
    v.y ^= v.y >> 16u;
    v.z ^= v.z >> 16u;
    v.w ^= v.w >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

BN_FUNCTION bn_uint4 bn_draw_white_counter(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                           BN_UINT domain) {
    bn_uint4 v;
    v.x = x + seed.x;
    v.y = y;
    v.z = index;
    v.w = domain + seed.y;
    return v;
}

BN_FUNCTION bn_uint4 bn_draw_white_bits(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                        BN_UINT domain) {
    return bn_draw_white_hash(bn_draw_white_counter(seed, x, y, index, domain));
}

BN_FUNCTION bn_uint2 bn_draw_white_pair_bits(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                             BN_UINT domain, BN_UINT pair) {
    bn_uint4 v = bn_draw_white_bits(seed, x, y, index, domain);
    BN_UINT second = 0u - (pair & 1u);
    bn_uint2 two;
    two.x = v.x ^ ((v.x ^ v.z) & second);
    two.y = v.y ^ ((v.y ^ v.w) & second);
    return two;
}

/* ---- Draws for shaders */

#ifdef BN_FLOAT4
BN_FUNCTION BN_FLOAT4 bn_draw_floats(bn_uint4 v) {
    float scale = 1.0f / 16777216.0f;
    return BN_FLOAT4(float(v.x >> 8u), float(v.y >> 8u), float(v.z >> 8u), float(v.w >> 8u)) *
           scale;
}

BN_FUNCTION BN_FLOAT2 bn_draw_pair_floats(bn_uint2 v) {
    float scale = 1.0f / 16777216.0f;
    return BN_FLOAT2(float(v.x >> 8u), float(v.y >> 8u)) * scale;
}

BN_FUNCTION BN_FLOAT4 bn_draw_blue_4d(BN_TABLE bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                      BN_UINT domain) {
    return bn_draw_floats(bn_draw_blue_bits(BN_PASS_TABLE seed, x, y, index, domain));
}

BN_FUNCTION BN_FLOAT4 bn_draw_sobol_4d(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain) {
    return bn_draw_floats(bn_draw_sobol_bits(seed, x, y, index, domain));
}

BN_FUNCTION BN_FLOAT4 bn_draw_white_4d(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain) {
    return bn_draw_floats(bn_draw_white_bits(seed, x, y, index, domain));
}

BN_FUNCTION BN_FLOAT2 bn_draw_blue_2d(BN_TABLE bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                      BN_UINT domain, BN_UINT pair) {
    return bn_draw_pair_floats(
        bn_draw_blue_pair_bits(BN_PASS_TABLE seed, x, y, index, domain, pair));
}

BN_FUNCTION BN_FLOAT2 bn_draw_sobol_2d(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain, BN_UINT pair) {
    return bn_draw_pair_floats(bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair));
}

BN_FUNCTION BN_FLOAT2 bn_draw_white_2d(bn_uint2 seed, BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain, BN_UINT pair) {
    return bn_draw_pair_floats(bn_draw_white_pair_bits(seed, x, y, index, domain, pair));
}
#endif

#endif
