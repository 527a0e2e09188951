/* SPDX-License-Identifier: Apache-2.0
 * The draws of BLUE, SOBOL and WHITE in WGSL: bn_draw.glsl, translated by libbn/tools/make_wgsl.py.
 * Put this text in front of yours or behind it, and declare the words of bn_sampler_table_words(),
 * in the group and binding of your choice:
 *
 *     @group(0) @binding(0) var<storage, read> bn_words: array<u32>;
 *
 *     let u: vec4f = bn_draw_blue(u32(pixel.x), u32(pixel.y), index, bn_domain_child(0u, ray));
 *
 * Coordinates are signed integers reinterpreted as unsigned: u32(-1i) is the column left of zero.
 * bn_draw_blue_bits() and its relatives give all 32 bits of each number. Names that begin with bn_
 * and BN_ are reserved. bn_draw.h explains how BLUE works. */

/* THE TABLES
 *
 * One flat buffer of BN_WORD_COUNT 32-bit words, in the byte order of the machine: 42 KiB, the same
 * for all three kinds. Seeds differ in the first two words alone, and SOBOL and WHITE read no others.
 * Entries of two words hold the first 16 digits of four coordinates, a half-word each from the lowest
 * up; entries of four, all 32 digits of each. `member` is the domain's number within its family, 0 to
 * 3. */
const BN_SEED_AT = 0u;      /* the hashed seed, its low word first */
const BN_PIXELS_AT = 2u;    /* 64 x 64, row-major: eight bits for each member of a family from the
                              lowest up, eight times the place of the pixel in its block of 4 x 4 */
const BN_BLOCKS_AT = 4098u; /* [16 x 16][member][2]: digits of a block of 4 x 4 pixels */
const BN_PLACES_AT = 6146u; /* [16][member][2]: digits of a place in a block */
const BN_POINTS_AT = 6274u; /* [256][member][4]: the first 256 points, by reversed index */
const BN_LATER_AT = 10370u; /* [24][member][4]: digits of bits 8 to 31 of an index */
const BN_WORD_COUNT = 10754u;

/* Four words in a row. An entry of two words is read with the two that follow it, for which nobody
 * asks. */
fn bn_draw_row(at: u32) -> vec4u {
    var row: vec4u;
    row.x = bn_words[at];
    row.y = bn_words[at + 1u];
    row.z = bn_words[at + 2u];
    row.w = bn_words[at + 3u];
    return row;
}

/* Two words in a row, or one with that which follows it. */
fn bn_draw_half_row(at: u32) -> vec2u {
    var row: vec2u;
    row.x = bn_words[at];
    row.y = bn_words[at + 1u];
    return row;
}

/* ---- Bits */

/* The upper half of the 64-bit product, from products of half-words. */
fn bn_multiply_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let left = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let right = (a & 0xffffu) * (b >> 16u) + (left & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u);
}

/* A bijection in which every input bit reaches every output bit (structure and constants: Wellons,
 * "Prospecting for Hash Functions", 2018). */
fn bn_hash32(v_in: u32) -> u32 {
    var v = v_in;
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0xd35a2d97u;
    return v ^ (v >> 15u);
}

/* bn_domain_child(): a hash of the parent and of key / 4, which is the same for a whole family,
 * with the member of the family in the upper two bits. The draws hash the result once more. */
fn bn_domain_child(domain: u32, key: u32) -> u32 {
    let v = (domain + (key >> 2u) * 0x85ebca6bu + 0x9e3779b9u) * 0x21f0aaadu;
    return ((v ^ (v >> 16u)) >> 2u) | (key << 30u);
}

/* Nested uniform (Owen) scrambling of bit-reversed digits: each output bit is the input bit,
 * flipped by a hash of the bits below it (Laine and Karras, "Stratified Sampling for Stochastic
 * Transparency", 2011; mixing constants of Vegdahl, "Building a Better LK Hash", 2021). */
fn bn_owen_reversed(v_in: u32, seed: u32) -> u32 {
    var v = v_in;
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

fn bn_owen(digits: u32, seed: u32) -> u32 {
    return reverseBits(bn_owen_reversed(reverseBits(digits), seed));
}

/* The second coordinate of the Sobol' (0,2)-sequence from the first: with digits d_0 (the most
 * significant bit) to d_31 of the radical inverse, digit k becomes the sum over j of binomial(j, k)
 * d_j mod 2, which is odd exactly when k is a bitwise subset of j; so the sum factors into five
 * steps, one for each bit of j (Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast,
 * Elegant, and Compact", 2024). */
fn bn_sobol_second(digits_in: u32) -> u32 {
    var digits = digits_in;
    digits ^= (digits << 1u) & 0xaaaaaaaau;
    digits ^= (digits << 2u) & 0xccccccccu;
    digits ^= (digits << 4u) & 0xf0f0f0f0u;
    digits ^= (digits << 8u) & 0xff00ff00u;
    digits ^= (digits << 16u) & 0xffff0000u;
    return digits;
}

/* ---- BLUE: a pixel in a domain, then its samples */

struct bn_blue_pixel {
    place: u32,
    block: u32, /* the words that hold the upper 16 digits of the pixel */
    keys01: u32,
    keys23: u32, /* what the domain adds to them, from the fourth digit on */
    low01: u32,
    low23: u32, /* the lower 16 digits, random: as in all these, a half-word each */
    shuffle: u32, /* of the index: the same for all members of a family */
    member: u32, /* of the family, times two */
}

fn bn_draw_blue_pixel(x: u32, y: u32, domain: u32) -> bn_blue_pixel {
    var pixel: bn_blue_pixel;
    let member = (domain >> 29u) & 6u;
    pixel.member = member;
    /* The family: its four members differ only in the upper two bits of the domain. The upper half
     * of a 64-bit product depends on every bit of it. */
    var family = (domain << 2u) ^ bn_words[BN_SEED_AT];
    family = bn_multiply_high(family, 0x7f4a7c15u) + family * 0x9e3779b9u +
        bn_words[BN_SEED_AT + 1u];
    /* The order of the samples: one for 32 x 32 pixels, so that samples in the middle of an octave
     * are as blue as the first ones. */
    pixel.shuffle = bn_hash32((x >> 5u) + (y >> 5u) * 0x9e3779b1u) + family;
    /* The tile, reflected and shifted. */
    let column = ((x ^ (0u - ((family >> 16u) & 1u))) + (family >> 26u)) & 63u;
    let row = ((y ^ (0u - ((family >> 17u) & 1u))) + (family >> 20u)) & 63u;
    let places = bn_words[BN_PIXELS_AT + row * 64u + column];
    pixel.place = BN_PLACES_AT + ((places >> (4u * member)) & 255u) + member;
    pixel.block = BN_BLOCKS_AT + ((row & 60u) << 5u) + ((column & 60u) << 1u) + member;
    let own = member * 0x85ebca6bu;
    let keys = (family ^ (family >> 15u)) * (own + 0x21f0aaadu);
    pixel.keys01 = keys & 0x1fff1fffu;
    pixel.keys23 = (keys >> 3u) & 0x1fff1fffu;
    let low = (bn_hash32(x + y * 0x9e3779b1u) ^ family) * 0x21f0aaadu + own;
    pixel.low01 = low ^ (low >> 15u);
    pixel.low23 = pixel.low01 * 0xd35a2d97u;
    return pixel;
}

/* A factor for the shuffle: bit 31 of their product decides whether the first digit of this index
 * and its neighbour is flipped. That bit is one of the shuffle's lower bits, or a sum of several. */
fn bn_draw_flip(index: u32) -> u32 {
    let t = (index >> 1u) - 1u;
    var flip = 2u << (t & 15u);
    flip |= ((index >> 5u) & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= ((index >> 6u) & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= ((index >> 7u) & 1u) << (((t + 2u) & 15u) + 1u);
    return flip & ((t >> 31u) - 1u); /* zero for the first pair, where t is 2^32 - 1 */
}

/* The digits of an index, reversed and shuffled. Each digit is flipped depending on the later ones,
 * through a product that is nested in the index from its top bit down. The first digit is also
 * flipped by random bits of its own: by the product alone, one in eight pairs of families would
 * flip it alike over the first 16 samples of a pixel. Zero maps to zero, so every power-of-two
 * prefix maps to itself. */
fn bn_draw_blue_digits(shuffle: u32, reversed: u32, flip: u32) -> u32 {
    return reversed ^ (reversed * (shuffle << 1u)) ^ ((shuffle * flip) & 0x80000000u);
}

fn bn_draw_blue_at(pixel: bn_blue_pixel, index: u32) -> vec4u {
    var digits = bn_draw_blue_digits(pixel.shuffle, reverseBits(index), bn_draw_flip(index));
    var v = bn_draw_row(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 2u);
    let place = bn_draw_row(pixel.place);
    let block = bn_draw_row(pixel.block);
    let high01 = place.x ^ block.x ^ pixel.keys01;
    let high23 = place.y ^ block.y ^ pixel.keys23;
    v.x ^= (high01 << 16u) | (pixel.low01 & 0xffffu);
    v.y ^= (high01 & 0xffff0000u) | (pixel.low01 >> 16u);
    v.z ^= (high23 << 16u) | (pixel.low23 & 0xffffu);
    v.w ^= (high23 & 0xffff0000u) | (pixel.low23 >> 16u);
    var later = BN_LATER_AT + pixel.member * 2u;
    for (digits <<= 8u; digits != 0u; digits <<= 1u) {
        let picked = 0u - (digits >> 31u);
        let row = bn_draw_row(later);
        v.x ^= row.x & picked;
        v.y ^= row.y & picked;
        v.z ^= row.z & picked;
        v.w ^= row.w & picked;
        later += 16u;
    }
    return v;
}

/* One pair of dimensions alone, by 0 or 1: the sample of these digits without what bits 8 to 31 of
 * the index add to it. */
fn bn_draw_blue_pair_first(pixel: bn_blue_pixel, digits: u32, pair: u32) -> vec2u {
    let second = 0u - pair;
    let place = bn_draw_half_row(pixel.place + pair);
    let block = bn_draw_half_row(pixel.block + pair);
    let high = place.x ^ block.x ^ pixel.keys01 ^ ((pixel.keys01 ^ pixel.keys23) & second);
    let low = pixel.low01 ^ ((pixel.low01 ^ pixel.low23) & second);
    var v = bn_draw_half_row(BN_POINTS_AT + (digits >> 24u) * 16u + (pixel.member + pair) * 2u);
    v.x ^= (high << 16u) | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | (low >> 16u);
    return v;
}

fn bn_draw_blue_pair_at(pixel: bn_blue_pixel, index: u32, pair: u32) -> vec2u {
    var digits = bn_draw_blue_digits(pixel.shuffle, reverseBits(index), bn_draw_flip(index));
    var v = bn_draw_blue_pair_first(pixel, digits, pair);
    var later = BN_LATER_AT + (pixel.member + pair) * 2u;
    for (digits <<= 8u; digits != 0u; digits <<= 1u) {
        let picked = 0u - (digits >> 31u);
        let row = bn_draw_half_row(later);
        v.x ^= row.x & picked;
        v.y ^= row.y & picked;
        later += 16u;
    }
    return v;
}

fn bn_draw_blue_pair_bits(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2u {
    let pixel = bn_draw_blue_pixel(x, y, domain);
    return bn_draw_blue_pair_at(pixel, index, pair);
}

fn bn_draw_blue_bits(x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    return bn_draw_blue_at(bn_draw_blue_pixel(x, y, domain), index);
}

/* ---- SOBOL and WHITE */

fn bn_draw_sobol_next(key: u32) -> u32 {
    return bn_hash32(key + 0x9e3779b9u);
}

/* The first key of a domain. Each pair takes three, one after the other. */
fn bn_draw_sobol_key(x: u32, y: u32, domain: u32) -> u32 {
    let key = bn_hash32(y ^ bn_hash32(domain + bn_words[BN_SEED_AT]));
    return bn_hash32(x ^ bn_hash32(key + bn_words[BN_SEED_AT + 1u]));
}

fn bn_draw_sobol_second_key(key: u32) -> u32 {
    return bn_draw_sobol_next(bn_draw_sobol_next(bn_draw_sobol_next(key)));
}

fn bn_draw_sobol_two(key_in: u32, index: u32) -> vec2u {
    var key = key_in;
    var v: vec2u;
    let digits = bn_owen_reversed(reverseBits(index), key);
    key = bn_draw_sobol_next(key);
    v.x = bn_owen(digits, key);
    v.y = bn_owen(bn_sobol_second(digits), bn_draw_sobol_next(key));
    return v;
}

fn bn_draw_sobol_pair_bits(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2u {
    var key = bn_draw_sobol_key(x, y, domain);
    key ^= (key ^ bn_draw_sobol_second_key(key)) & (0u - pair);
    return bn_draw_sobol_two(key, index);
}

fn bn_draw_sobol_bits(x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    var v: vec4u;
    let key = bn_draw_sobol_key(x, y, domain);
    var two = bn_draw_sobol_two(key, index);
    v.x = two.x;
    v.y = two.y;
    two = bn_draw_sobol_two(bn_draw_sobol_second_key(key), index);
    v.z = two.x;
    v.w = two.y;
    return v;
}

/* WHITE has two 32-bit keys: pixels that collide in one differ in the other. */
fn bn_draw_white_key(x: u32, y: u32, domain: u32) -> u32 {
    return bn_hash32(x ^ bn_hash32(y ^ bn_hash32(domain + bn_words[BN_SEED_AT])));
}

fn bn_draw_white_other_key(x: u32, y: u32, domain: u32) -> u32 {
    return bn_hash32(y + bn_hash32(x + bn_hash32(domain ^ bn_words[BN_SEED_AT + 1u])));
}

fn bn_draw_white_one(a: u32, b: u32, index: u32) -> u32 {
    return bn_hash32(a ^ bn_hash32(index ^ bn_hash32(b)));
}

fn bn_draw_white_pair_bits(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2u {
    var v: vec2u;
    let a = bn_draw_white_key(x, y, domain);
    let b = bn_draw_white_other_key(x, y, domain) + pair * 0x3c6ef372u;
    v.x = bn_draw_white_one(a, b + 0x9e3779b9u, index);
    v.y = bn_draw_white_one(a, b + 0x3c6ef372u, index);
    return v;
}

fn bn_draw_white_bits(x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    var v: vec4u;
    let a = bn_draw_white_key(x, y, domain);
    let b = bn_draw_white_other_key(x, y, domain);
    v.x = bn_draw_white_one(a, b + 0x9e3779b9u, index);
    v.y = bn_draw_white_one(a, b + 0x3c6ef372u, index);
    v.z = bn_draw_white_one(a, b + 0xdaa66d2bu, index);
    v.w = bn_draw_white_one(a, b + 0x78dde6e4u, index);
    return v;
}

/* ---- The draws of shaders */

fn bn_draw_floats(v: vec4u) -> vec4f {
    let scale = 1.0f / 16777216.0f;
    return vec4f(f32(v.x >> 8u), f32(v.y >> 8u), f32(v.z >> 8u), f32(v.w >> 8u)) * scale;
}

fn bn_draw_pair_floats(v: vec2u) -> vec2f {
    let scale = 1.0f / 16777216.0f;
    return vec2f(f32(v.x >> 8u), f32(v.y >> 8u)) * scale;
}

fn bn_draw_blue(x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_blue_bits(x, y, index, domain));
}

fn bn_draw_sobol(x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_sobol_bits(x, y, index, domain));
}

fn bn_draw_white(x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_white_bits(x, y, index, domain));
}

fn bn_draw_blue_pair(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_blue_pair_bits(x, y, index, domain, pair));
}

fn bn_draw_sobol_pair(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_sobol_pair_bits(x, y, index, domain, pair));
}

fn bn_draw_white_pair(x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_white_pair_bits(x, y, index, domain, pair));
}
