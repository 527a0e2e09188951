/* SPDX-License-Identifier: Apache-2.0
 * BLUE, SOBOL and WHITE draws in WGSL, translated from bn_draw.glsl by libbn/tools/make_wgsl.py.
 * Concatenate this file with your shader, and declare the words of bn_tables() in a group and
 * binding of your choice. The seed comes from bn_sampler_seed():
 *
 *     @group(0) @binding(0) var<storage, read> bn_words: array<u32>;
 *
 *     let u: vec4f = bn_draw_blue_4d(seed, u32(pixel.x), u32(pixel.y), index, bn_domain_child(0u, ray));
 *
 * Coordinates are signed integers reinterpreted as unsigned: u32(-1i) is the column to the left of
 * column 0. bn_draw_blue_bits() and its variants return all 32 bits of each number. Names that begin
 * with bn_ or BN_ are reserved. bn_draw.h explains how BLUE works. */

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
const BN_PIXELS_AT = 0u;    /* [64][64]: byte m of a pixel's word is its place for member m */
const BN_BLOCKS_AT = 4096u; /* [16][16][member][2]: digits of a block, row-major */
const BN_PLACES_AT = 6144u; /* [member][16][2]: digits of a place */
const BN_POINTS_AT = 6272u; /* [256][member][4]: the first 256 samples, by reversed index */
const BN_LATER_AT = 10368u; /* [6][16][member][4]: digits for index bits 8 to 31, four at a time */
const BN_WORD_COUNT = 11904u;

/* Four consecutive words. For a two-word entry, the last two are ignored. */
fn bn_draw_row(at: u32) -> vec4u {
    var row: vec4u;
    row.x = bn_words[at];
    row.y = bn_words[at + 1u];
    row.z = bn_words[at + 2u];
    row.w = bn_words[at + 3u];
    return row;
}

/* Two consecutive words. */
fn bn_draw_half_row(at: u32) -> vec2u {
    var row: vec2u;
    row.x = bn_words[at];
    row.y = bn_words[at + 1u];
    return row;
}

/* ---- Bits */

/* A bijection in which every input bit affects every output bit (structure and constants: Wellons,
 * "Prospecting for Hash Functions", 2018). */
fn bn_hash32(v_in: u32) -> u32 {
    var v = v_in;
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0xd35a2d97u;
    return v ^ (v >> 15u);
}

/* bn_domain_child(): a hash of the parent and key / 4, which all members of a family share. The upper
 * two bits hold the member number. The draws hash the result once more. Before the last step, which
 * leaves the upper half unchanged, families with the same parent differ by multiples of the golden
 * ratio. As a result, no two of any thirty consecutive families share their upper six bits, which BLUE
 * uses as the family's shift. */
fn bn_domain_child(domain: u32, key: u32) -> u32 {
    var v = (domain + (key >> 2u) * 0x121658bdu + 0x9e3779b9u) * 0x21f0aaadu;
    v = ((v ^ (v >> 16u)) & 0xfffffffcu) | (key & 3u);
    return (v >> 2u) | (v << 30u);
}

/* Nested uniform (Owen) scrambling of bit-reversed digits: each output bit is the input bit, flipped
 * according to a hash of the bits below it (Laine and Karras, "Stratified Sampling for Stochastic
 * Transparency", 2011; mixing constants from Vegdahl, "Building a Better LK Hash", 2021). */
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

/* The second coordinate of the Sobol' (0,2)-sequence, computed from the first. Let d_0 (the most
 * significant bit) to d_31 be the digits of the radical inverse; digit k of the result is the sum over
 * j of binomial(j, k) d_j mod 2. The binomial is odd exactly when k is a bitwise subset of j, so the
 * sum factors into five steps, one per bit of j (Ahmed, "An Implementation Algorithm of 2D Sobol
 * Sequence Fast, Elegant, and Compact", 2024). */
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
    at: u32, /* the pixel's position in the tile: 64 row + column */
    place: u32,
    block: u32, /* the two parts of its label: indices of two-word entries */
    keys: u32, /* random upper 16 digits of the tile's copy, for pair 0 */
    low: u32, /* random lower 16 digits of the pixel, for pair 0, one half-word each */
    shuffle: u32, /* the copy's sample order; the same for all members of a family */
    member: u32, /* number within the family */
}

/* A factor that gives each member its own random digits. */
fn bn_draw_key_factor(member: u32) -> u32 {
    return member * 0x0bd794d6u + 0xd35a2d97u;
}

fn bn_draw_blue_pixel(seed: vec2u, x: u32, y: u32, domain: u32) -> bn_blue_pixel {
    var pixel: bn_blue_pixel;
    let turned = (domain << 2u) | (domain >> 30u);
    let member = turned & 3u;
    pixel.member = member;
    /* A hash of the family, whose four members differ only in the upper two bits of the domain. */
    let start = (turned & 0xfffffffcu) ^ seed.x;
    var family = start * 0x21f0aaadu;
    family = (family ^ (family >> 16u)) * 0xd35a2d97u + seed.y;
    /* Reflect and shift the tile. Only the lower six bits of the y shift move it; the other bits
     * renumber the copies. */
    let column = (x ^ (0u - (family >> 31u))) + (start >> 26u);
    let row = (y ^ (0u - ((family >> 19u) & 1u))) + (family >> 20u);
    /* Each copy of the tile has its own random digits and sample order, which all its pixels share.
     * The error is therefore as blue between powers of two as at them. */
    var copy = (column >> 6u) + (row >> 6u) * 0x9e3779b1u + family;
    copy = (copy ^ (copy >> 16u)) * 0x21f0aaadu;
    copy ^= copy >> 15u;
    pixel.shuffle = copy;
    /* The two parts of the pixel's label, its path through the quadtree. Two copies of the code that
     * reads them are written by hand: for SSE2 in bn_draw.h, and for arrays in
     * bindings/bluenoise/arrays.py. Tests compare the bits of all three. */
    pixel.at = ((row & 63u) << 6u) | (column & 63u);
    let places = bn_words[BN_PIXELS_AT + pixel.at];
    pixel.place = BN_PLACES_AT / 2u + ((places >> (8u * member)) & 15u) + member * 16u;
    pixel.block = BN_BLOCKS_AT / 2u + ((pixel.at & 0xf00u) >> 2u) + (pixel.at & 0x3cu) + member;
    var keys = copy * bn_draw_key_factor(member);
    keys ^= keys >> 16u;
    pixel.keys = keys;
    pixel.low = (bn_hash32(x + y * 0x9e3779b1u) ^ keys) * 0x21f0aaadu;
    return pixel;
}

/* The keys for pair 1, rotated so that the four coordinates' first eight digits use different bits of
 * the hash. The low digits for pair 1 are low ^ keys. */
fn bn_draw_second_keys(keys: u32) -> u32 {
    return (keys << 8u) | (keys >> 24u);
}

/* A factor for the shuffle: bit 31 of the product decides whether the sample order exchanges this
 * index with its neighbour, index ^ 1. That bit is one of the shuffle's lower bits, or a sum of
 * several. The factor depends only on the index's lowest eight bits. */
fn bn_draw_flip(index: u32) -> u32 {
    let t = ((index & 255u) >> 1u) - 1u;
    var flip = 2u << (t & 15u);
    flip |= ((index >> 5u) & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= ((index >> 6u) & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= ((index >> 7u) & 1u) << (((t + 2u) & 15u) + 1u);
    return flip & ((t >> 31u) - 1u); /* zero for the first pair, where t is 2^32 - 1 */
}

/* Applies the copy's sample order to the reversed digits of an index. The product flips each digit
 * depending on the digits after it, that is, on the higher bits of the index. Separate random bits
 * also flip the first digit; otherwise one in eight pairs of families would flip it identically over a
 * pixel's first 16 samples. Zero maps to zero, so every power-of-two prefix maps to itself. */
fn bn_draw_blue_digits(shuffle: u32, reversed: u32, flip: u32) -> u32 {
    return reversed ^ (reversed * (shuffle << 1u)) ^ ((shuffle * flip) & 0x80000000u);
}

fn bn_draw_blue_at(pixel: bn_blue_pixel, index: u32) -> vec4u {
    var digits = bn_draw_blue_digits(pixel.shuffle, reverseBits(index), bn_draw_flip(index));
    var v = bn_draw_row(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 4u);
    let place = bn_draw_row(pixel.place * 2u);
    let block = bn_draw_row(pixel.block * 2u);
    var high = place.x ^ block.x ^ pixel.keys;
    var low = pixel.low;
    v.x ^= (high << 16u) | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | (low >> 16u);
    high = place.y ^ block.y ^ bn_draw_second_keys(pixel.keys);
    low ^= pixel.keys;
    v.z ^= (high << 16u) | (low & 0xffffu);
    v.w ^= (high & 0xffff0000u) | (low >> 16u);
    var later = BN_LATER_AT + pixel.member * 4u;
    for (digits <<= 8u; digits != 0u; digits <<= 4u) {
        let row = bn_draw_row(later + (digits >> 28u) * 16u);
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
fn bn_draw_blue_pair_first(pixel: bn_blue_pixel, digits: u32, pair_in: u32) -> vec2u {
    var pair = pair_in;
    pair &= 1u;
    let second = 0u - pair;
    var high = bn_words[pixel.place * 2u + pair] ^ bn_words[pixel.block * 2u + pair];
    high ^= pixel.keys ^ ((pixel.keys ^ bn_draw_second_keys(pixel.keys)) & second);
    let low = pixel.low ^ (pixel.keys & second);
    var v = bn_draw_half_row(BN_POINTS_AT + (digits >> 24u) * 16u + pixel.member * 4u + pair * 2u);
    v.x ^= (high << 16u) | (low & 0xffffu);
    v.y ^= (high & 0xffff0000u) | (low >> 16u);
    return v;
}

fn bn_draw_blue_pair_at(pixel: bn_blue_pixel, index: u32, pair: u32) -> vec2u {
    var digits = bn_draw_blue_digits(pixel.shuffle, reverseBits(index), bn_draw_flip(index));
    var v = bn_draw_blue_pair_first(pixel, digits, pair);
    var later = BN_LATER_AT + pixel.member * 4u + (pair & 1u) * 2u;
    for (digits <<= 8u; digits != 0u; digits <<= 4u) {
        let row = bn_draw_half_row(later + (digits >> 28u) * 16u);
        v.x ^= row.x;
        v.y ^= row.y;
        later += 256u;
    }
    return v;
}

fn bn_draw_blue_pair_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32,
    pair: u32) -> vec2u {
    let pixel = bn_draw_blue_pixel(seed, x, y, domain);
    return bn_draw_blue_pair_at(pixel, index, pair);
}

fn bn_draw_blue_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    return bn_draw_blue_at(bn_draw_blue_pixel(seed, x, y, domain), index);
}

/* ---- SOBOL and WHITE */

fn bn_draw_sobol_next(key: u32) -> u32 {
    return bn_hash32(key + 0x9e3779b9u);
}

/* The first scrambling key of a domain. Each pair uses three consecutive keys. */
fn bn_draw_sobol_key(seed: vec2u, x: u32, y: u32, domain: u32) -> u32 {
    let key = bn_hash32(y ^ bn_hash32(domain + seed.x));
    return bn_hash32(x ^ bn_hash32(key + seed.y));
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

fn bn_draw_sobol_pair_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32,
    pair: u32) -> vec2u {
    var key = bn_draw_sobol_key(seed, x, y, domain);
    key ^= (key ^ bn_draw_sobol_second_key(key)) & (0u - (pair & 1u));
    return bn_draw_sobol_two(key, index);
}

fn bn_draw_sobol_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    var v: vec4u;
    let key = bn_draw_sobol_key(seed, x, y, domain);
    var two = bn_draw_sobol_two(key, index);
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
fn bn_draw_white_hash(v_in: vec4u) -> vec4u {
    var v = v_in;
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

fn bn_draw_white_counter(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    var v: vec4u;
    v.x = x + seed.x;
    v.y = y;
    v.z = index;
    v.w = domain + seed.y;
    return v;
}

fn bn_draw_white_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4u {
    return bn_draw_white_hash(bn_draw_white_counter(seed, x, y, index, domain));
}

fn bn_draw_white_pair_bits(seed: vec2u, x: u32, y: u32, index: u32, domain: u32,
    pair: u32) -> vec2u {
    let v = bn_draw_white_bits(seed, x, y, index, domain);
    let second = 0u - (pair & 1u);
    var two: vec2u;
    two.x = v.x ^ ((v.x ^ v.z) & second);
    two.y = v.y ^ ((v.y ^ v.w) & second);
    return two;
}

/* ---- Draws for shaders */

fn bn_draw_floats(v: vec4u) -> vec4f {
    let scale = 1.0f / 16777216.0f;
    return vec4f(f32(v.x >> 8u), f32(v.y >> 8u), f32(v.z >> 8u), f32(v.w >> 8u)) * scale;
}

fn bn_draw_pair_floats(v: vec2u) -> vec2f {
    let scale = 1.0f / 16777216.0f;
    return vec2f(f32(v.x >> 8u), f32(v.y >> 8u)) * scale;
}

fn bn_draw_blue_4d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_blue_bits(seed, x, y, index, domain));
}

fn bn_draw_sobol_4d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_sobol_bits(seed, x, y, index, domain));
}

fn bn_draw_white_4d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32) -> vec4f {
    return bn_draw_floats(bn_draw_white_bits(seed, x, y, index, domain));
}

fn bn_draw_blue_2d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_blue_pair_bits(seed, x, y, index, domain, pair));
}

fn bn_draw_sobol_2d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_sobol_pair_bits(seed, x, y, index, domain, pair));
}

fn bn_draw_white_2d(seed: vec2u, x: u32, y: u32, index: u32, domain: u32, pair: u32) -> vec2f {
    return bn_draw_pair_floats(bn_draw_white_pair_bits(seed, x, y, index, domain, pair));
}
