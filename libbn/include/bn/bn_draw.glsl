/* SPDX-License-Identifier: Apache-2.0
 * The draws of BLUE, SOBOL and WHITE, in the common subset of GLSL, HLSL, Metal, CUDA and C. They
 * are bit-equal to bn_sample_4d(). bn_draw.h compiles this text as C and CUDA, bn_draw.hlsl and
 * bn_draw.metal as their languages; libbn/tools/make_wgsl.py writes bn_draw.wgsl from it. See
 * docs/shaders.md.
 *
 * In a shader (GLSL 3.30 or GLSL ES 3.00, no extensions), say how to read word i of what
 * bn_sampler_table_words() wrote, then include this file:
 *
 *     #version 430
 *     layout(std430, binding = 0) readonly buffer bn_table { uint bn_words[]; };
 *     #define BN_WORD(i) bn_words[i]
 *
 *     vec4 u = bn_draw_blue(uint(pixel.x), uint(pixel.y), index, domain);
 *     vec2 v = bn_draw_blue_pair(uint(pixel.x), uint(pixel.y), index, domain, 1u); // u.zw, alone
 *
 * Coordinates are signed integers reinterpreted as unsigned: uint(-1) is the column left of zero.
 * Without storage buffers, as in WebGL 2, the words come from a texture:
 *
 *     uniform highp usampler2D bn_words; // R32UI, 64 texels wide
 *     #define BN_WORD(i) texelFetch(bn_words, ivec2((i) & 63u, (i) >> 6u), 0).r
 *
 * Names that begin with bn_ are reserved. bn_draw.h explains how BLUE works. */
#ifndef BN_DRAW_GLSL
#define BN_DRAW_GLSL

#ifndef BN_ANY
/* Whether v, or any lane of it where it is a vector, is not zero. */
#define BN_ANY(v) ((v) != 0u)
#endif

#ifndef BN_UINT
#ifdef GL_ES
precision highp float;
precision highp int;
#endif
#define BN_UINT uint
#define BN_FLOAT2 vec2
#define BN_FLOAT4 vec4
#define BN_FUNCTION
#define BN_TABLE
#define BN_PASS_TABLE
#define bn_draw_domain_child bn_domain_child
/* Newer versions have instructions for what is spelled out below. */
#if __VERSION__ >= 400 || (defined(GL_ES) && __VERSION__ >= 310)
#define BN_REVERSE_BITS(v) bitfieldReverse(v)
#define BN_MULTIPLY_HIGH(a, b) bn_multiply_high(a, b)
uint bn_multiply_high(uint a, uint b) {
    uint high, low;
    umulExtended(a, b, high, low);
    return high;
}
#endif
#endif

/* THE TABLES
 *
 * One flat buffer of BN_WORD_COUNT 32-bit words, in the byte order of the machine: 42 KiB, the same
 * for all three kinds. Seeds differ in the first two words alone, and SOBOL and WHITE read no others.
 * Entries of two words hold the first 16 digits of four coordinates, a half-word each from the lowest
 * up; entries of four, all 32 digits of each. `member` is the domain's number within its family, 0 to
 * 3. */
#define BN_SEED_AT 0u      /* the hashed seed, its low word first */
#define BN_PIXELS_AT 2u    /* 64 x 64, row-major: eight bits for each member of a family from the
                              lowest up, eight times the place of the pixel in its block of 4 x 4 */
#define BN_BLOCKS_AT 4098u /* [16 x 16][member][2]: digits of a block of 4 x 4 pixels */
#define BN_PLACES_AT 6146u /* [16][member][2]: digits of a place in a block */
#define BN_POINTS_AT 6274u /* [256][member][4]: the first 256 points, by reversed index */
#define BN_LATER_AT 10370u /* [24][member][4]: digits of bits 8 to 31 of an index */
#define BN_WORD_COUNT 10754u

#ifndef bn_uint4 /* else a vector of the language */
struct bn_uint4 {
    BN_UINT x, y, z, w;
};
struct bn_uint2 {
    BN_UINT x, y;
};
#endif

/* Four words in a row. An entry of two words is read with the two that follow it, for which nobody
 * asks. */
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

/* Two words in a row. */
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

#ifndef BN_MULTIPLY_HIGH
#define BN_MULTIPLY_HIGH(a, b) bn_multiply_high(a, b)
/* The upper half of the 64-bit product, from products of half-words. */
BN_FUNCTION BN_UINT bn_multiply_high(BN_UINT a, BN_UINT b) {
    BN_UINT low = (a & 0xffffu) * (b & 0xffffu);
    BN_UINT left = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    BN_UINT right = (a & 0xffffu) * (b >> 16u) + (left & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u);
}
#endif

/* A bijection in which every input bit reaches every output bit (structure and constants: Wellons,
 * "Prospecting for Hash Functions", 2018). */
BN_FUNCTION BN_UINT bn_hash32(BN_UINT v) {
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0xd35a2d97u;
    return v ^ (v >> 15u);
}

/* bn_domain_child(): a hash of the parent and of key / 4, which is the same for a whole family,
 * with the member of the family in the upper two bits. The draws hash the result once more. */
BN_FUNCTION BN_UINT bn_draw_domain_child(BN_UINT domain, BN_UINT key) {
    BN_UINT v = (domain + (key >> 2u) * 0x85ebca6bu + 0x9e3779b9u) * 0x21f0aaadu;
    return ((v ^ (v >> 16u)) >> 2u) | (key << 30u);
}

/* Nested uniform (Owen) scrambling of bit-reversed digits: each output bit is the input bit,
 * flipped by a hash of the bits below it (Laine and Karras, "Stratified Sampling for Stochastic
 * Transparency", 2011; mixing constants of Vegdahl, "Building a Better LK Hash", 2021). */
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

/* The second coordinate of the Sobol' (0,2)-sequence from the first: with digits d_0 (the most
 * significant bit) to d_31 of the radical inverse, digit k becomes the sum over j of binomial(j, k)
 * d_j mod 2, which is odd exactly when k is a bitwise subset of j; so the sum factors into five
 * steps, one for each bit of j (Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast,
 * Elegant, and Compact", 2024). */
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
    BN_UINT place, block; /* the words that hold the pixel's digits */
    BN_UINT low01, low23; /* the lower 16 digits, the pixel's own: a half-word each */
    BN_UINT shuffle;      /* of the index: the same for all members of a family */
    BN_UINT member;       /* of the family, times two */
    BN_UINT reflect;      /* four bits: which coordinates are reflected */
};

BN_FUNCTION bn_blue_pixel bn_draw_blue_pixel(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT domain) {
    bn_blue_pixel pixel;
    BN_UINT member = (domain >> 29u) & 6u;
    /* The family: its four members differ only in the upper two bits of the domain. The upper half
     * of a 64-bit product depends on every bit of it. */
    BN_UINT family = (domain << 2u) ^ BN_WORD(BN_SEED_AT);
    family = BN_MULTIPLY_HIGH(family, 0x7f4a7c15u) + family * 0x9e3779b9u + BN_WORD(BN_SEED_AT + 1u);
    /* The tile, reflected and shifted. */
    BN_UINT column = ((x ^ (0u - (family >> 16u & 1u))) + (family >> 26u)) & 63u;
    BN_UINT row = ((y ^ (0u - (family >> 17u & 1u))) + (family >> 20u)) & 63u;
    BN_UINT places = BN_WORD(BN_PIXELS_AT + row * 64u + column);
    pixel.place = BN_PLACES_AT + (places >> (4u * member) & 255u) + member;
    pixel.block = BN_BLOCKS_AT + ((row & 60u) << 5u) + ((column & 60u) << 1u) + member;
    BN_UINT position = bn_hash32(x + y * 0x9e3779b1u);
    BN_UINT low = (position ^ family) * 0x21f0aaadu + member * 0x85ebca6bu;
    pixel.low01 = low ^ (low >> 15u);
    pixel.low23 = pixel.low01 * 0xd35a2d97u;
    pixel.shuffle = position + family;
    pixel.member = member;
    pixel.reflect = family >> (2u * member) & 15u;
    return pixel;
}

/* A factor for the shuffle: bit 31 of their product decides whether the first digit of this index
 * and its neighbour is flipped. That bit is one of the shuffle's lower bits, or a sum of several. */
BN_FUNCTION BN_UINT bn_draw_flip(BN_UINT index) {
    BN_UINT t = (index >> 1u) - 1u;
    BN_UINT flip = 2u << (t & 15u);
    flip |= (index >> 5u & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= (index >> 6u & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= (index >> 7u & 1u) << (((t + 2u) & 15u) + 1u);
    return flip & ((t >> 31u) - 1u); /* zero for the first pair, where t is 2^32 - 1 */
}

/* The digits of an index, reversed and shuffled. Each digit is flipped depending on the later ones,
 * through a product that is nested in the index from its top bit down. The first digit is also
 * flipped by random bits of its own: by the product alone, one in eight pairs of families would
 * flip it alike over the first 16 samples of a pixel. Zero maps to zero, so every power-of-two
 * prefix maps to itself. */
BN_FUNCTION BN_UINT bn_draw_blue_digits(BN_UINT shuffle, BN_UINT reversed, BN_UINT flip) {
    return reversed ^ reversed * (shuffle << 1u) ^ ((shuffle * flip) & 0x80000000u);
}

BN_FUNCTION BN_UINT bn_draw_reflected(BN_UINT v, BN_UINT reflect) {
    return v ^ (0u - (reflect & 1u));
}

BN_FUNCTION bn_uint4 bn_draw_blue_at(BN_TABLE bn_blue_pixel pixel, BN_UINT index) {
    BN_UINT digits = bn_draw_blue_digits(pixel.shuffle, BN_REVERSE_BITS(index), bn_draw_flip(index));
    bn_uint4 v = BN_ROW(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 2u);
    bn_uint4 place = BN_ROW(pixel.place), block = BN_ROW(pixel.block);
    BN_UINT high01 = place.x ^ block.x, high23 = place.y ^ block.y;
    v.x ^= high01 << 16u | (pixel.low01 & 0xffffu);
    v.y ^= (high01 & 0xffff0000u) | pixel.low01 >> 16u;
    v.z ^= high23 << 16u | (pixel.low23 & 0xffffu);
    v.w ^= (high23 & 0xffff0000u) | pixel.low23 >> 16u;
    BN_UINT later = BN_LATER_AT + pixel.member * 2u;
    for (digits <<= 8u; BN_ANY(digits); digits <<= 1u) {
        BN_UINT picked = 0u - (digits >> 31u);
        bn_uint4 row = BN_ROW(later);
        v.x ^= row.x & picked;
        v.y ^= row.y & picked;
        v.z ^= row.z & picked;
        v.w ^= row.w & picked;
        later += 16u;
    }
    v.x = bn_draw_reflected(v.x, pixel.reflect);
    v.y = bn_draw_reflected(v.y, pixel.reflect >> 1u);
    v.z = bn_draw_reflected(v.z, pixel.reflect >> 2u);
    v.w = bn_draw_reflected(v.w, pixel.reflect >> 3u);
    return v;
}

/* One pair of dimensions alone, by 0 or 1: the sample of these digits without what bits 8 to 31 of
 * the index add to it. */
BN_FUNCTION bn_uint2 bn_draw_blue_pair_first(BN_TABLE bn_blue_pixel pixel, BN_UINT digits,
                                             BN_UINT pair) {
    BN_UINT second = 0u - pair;
    BN_UINT high = pixel.keys01 ^ ((pixel.keys01 ^ pixel.keys23) & second);
    BN_UINT low = pixel.low01 ^ ((pixel.low01 ^ pixel.low23) & second);
    high ^= BN_WORD(pixel.place + pair) ^ BN_WORD(pixel.block + pair);
    bn_uint2 v = BN_HALF_ROW(BN_POINTS_AT + (digits >> 24u) * 16u + (pixel.member + pair) * 2u);
    v.x ^= high << 16u | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | low >> 16u;
    return v;
}

BN_FUNCTION bn_uint2 bn_draw_blue_pair_at(BN_TABLE bn_blue_pixel pixel, BN_UINT index,
                                          BN_UINT pair) {
    BN_UINT digits = bn_draw_blue_digits(pixel.shuffle, BN_REVERSE_BITS(index), bn_draw_flip(index));
    bn_uint2 v = bn_draw_blue_pair_first(BN_PASS_TABLE pixel, digits, pair);
    BN_UINT later = BN_LATER_AT + (pixel.member + pair) * 2u;
    for (digits <<= 8u; BN_ANY(digits); digits <<= 1u) {
        BN_UINT picked = 0u - (digits >> 31u);
        bn_uint2 row = BN_HALF_ROW(later);
        v.x ^= row.x & picked;
        v.y ^= row.y & picked;
        later += 16u;
    }
    return v;
}

BN_FUNCTION bn_uint2 bn_draw_blue_pair_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                            BN_UINT domain, BN_UINT pair) {
    bn_blue_pixel pixel = bn_draw_blue_pixel(BN_PASS_TABLE x, y, domain);
    return bn_draw_blue_pair_at(BN_PASS_TABLE pixel, index, pair);
}

BN_FUNCTION bn_uint4 bn_draw_blue_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                       BN_UINT domain) {
    return bn_draw_blue_at(BN_PASS_TABLE bn_draw_blue_pixel(BN_PASS_TABLE x, y, domain), index);
}

/* ---- SOBOL and WHITE */

BN_FUNCTION BN_UINT bn_draw_sobol_next(BN_UINT key) {
    return bn_hash32(key + 0x9e3779b9u);
}

/* The first key of a pair. Each pair takes three of one chain. */
BN_FUNCTION BN_UINT bn_draw_sobol_key(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT domain, BN_UINT pair) {
    BN_UINT key = bn_hash32(y ^ bn_hash32(domain + BN_WORD(BN_SEED_AT)));
    key = bn_hash32(x ^ bn_hash32(key + BN_WORD(BN_SEED_AT + 1u)));
    BN_UINT second = bn_draw_sobol_next(bn_draw_sobol_next(bn_draw_sobol_next(key)));
    return key ^ ((key ^ second) & (0u - pair));
}

BN_FUNCTION bn_uint2 bn_draw_sobol_pair_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                             BN_UINT domain, BN_UINT pair) {
    bn_uint2 v;
    BN_UINT key = bn_draw_sobol_key(BN_PASS_TABLE x, y, domain, pair);
    BN_UINT digits = bn_owen_reversed(BN_REVERSE_BITS(index), key);
    key = bn_draw_sobol_next(key);
    v.x = bn_owen(digits, key);
    v.y = bn_owen(bn_sobol_second(digits), bn_draw_sobol_next(key));
    return v;
}

BN_FUNCTION bn_uint4 bn_draw_sobol_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                        BN_UINT domain) {
    bn_uint4 v;
    bn_uint2 first = bn_draw_sobol_pair_bits(BN_PASS_TABLE x, y, index, domain, BN_PAIR(0u));
    bn_uint2 second = bn_draw_sobol_pair_bits(BN_PASS_TABLE x, y, index, domain, BN_PAIR(1u));
    v.x = first.x;
    v.y = first.y;
    v.z = second.x;
    v.w = second.y;
    return v;
}

BN_FUNCTION BN_UINT bn_draw_white_one(BN_UINT a, BN_UINT b, BN_UINT index) {
    return bn_hash32(a ^ bn_hash32(index ^ bn_hash32(b)));
}

BN_FUNCTION bn_uint2 bn_draw_white_pair_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                             BN_UINT domain, BN_UINT pair) {
    bn_uint2 v;
    /* Two 32-bit hashes: pixels that collide in one differ in the other. */
    BN_UINT a = bn_hash32(x ^ bn_hash32(y ^ bn_hash32(domain + BN_WORD(BN_SEED_AT))));
    BN_UINT b = bn_hash32(y + bn_hash32(x + bn_hash32(domain ^ BN_WORD(BN_SEED_AT + 1u))));
    b += pair * 0x3c6ef372u;
    v.x = bn_draw_white_one(a, b + 0x9e3779b9u, index);
    v.y = bn_draw_white_one(a, b + 0x3c6ef372u, index);
    return v;
}

BN_FUNCTION bn_uint4 bn_draw_white_bits(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index,
                                        BN_UINT domain) {
    bn_uint4 v;
    bn_uint2 first = bn_draw_white_pair_bits(BN_PASS_TABLE x, y, index, domain, BN_PAIR(0u));
    bn_uint2 second = bn_draw_white_pair_bits(BN_PASS_TABLE x, y, index, domain, BN_PAIR(1u));
    v.x = first.x;
    v.y = first.y;
    v.z = second.x;
    v.w = second.y;
    return v;
}

/* ---- The draws of shaders */

#ifndef BN_DRAW_IN_C
BN_FUNCTION BN_FLOAT4 bn_draw_floats(bn_uint4 v) {
    float scale = 1.0f / 16777216.0f;
    return BN_FLOAT4(float(v.x >> 8u), float(v.y >> 8u), float(v.z >> 8u), float(v.w >> 8u)) * scale;
}

BN_FUNCTION BN_FLOAT2 bn_draw_pair_floats(bn_uint2 v) {
    float scale = 1.0f / 16777216.0f;
    return BN_FLOAT2(float(v.x >> 8u), float(v.y >> 8u)) * scale;
}

BN_FUNCTION BN_FLOAT4 bn_draw_blue(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain) {
    return bn_draw_floats(bn_draw_blue_bits(BN_PASS_TABLE x, y, index, domain));
}

BN_FUNCTION BN_FLOAT4 bn_draw_sobol(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain) {
    return bn_draw_floats(bn_draw_sobol_bits(BN_PASS_TABLE x, y, index, domain));
}

BN_FUNCTION BN_FLOAT4 bn_draw_white(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain) {
    return bn_draw_floats(bn_draw_white_bits(BN_PASS_TABLE x, y, index, domain));
}

BN_FUNCTION BN_FLOAT2 bn_draw_blue_pair(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain,
                                    BN_UINT pair) {
    return bn_draw_pair_floats(bn_draw_blue_pair_bits(BN_PASS_TABLE x, y, index, domain, pair));
}

BN_FUNCTION BN_FLOAT2 bn_draw_sobol_pair(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain,
                                     BN_UINT pair) {
    return bn_draw_pair_floats(bn_draw_sobol_pair_bits(BN_PASS_TABLE x, y, index, domain, pair));
}

BN_FUNCTION BN_FLOAT2 bn_draw_white_pair(BN_TABLE BN_UINT x, BN_UINT y, BN_UINT index, BN_UINT domain,
                                     BN_UINT pair) {
    return bn_draw_pair_floats(bn_draw_white_pair_bits(BN_PASS_TABLE x, y, index, domain, pair));
}
#endif

#endif
