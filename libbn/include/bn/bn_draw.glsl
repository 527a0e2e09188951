/* SPDX-License-Identifier: Apache-2.0
 * The draws of bn_draw.h for shaders: kinds BLUE, SOBOL and WHITE, bit-equal to bn_sample_4d().
 * GLSL 4.30 or GLSL ES 3.10, no extensions. Include this text after defining how the table that
 * bn_sampler_table() hands out is reached:
 *
 *     #version 430
 *     layout(std430, binding = 0) readonly buffer bn_table { uint bn_words[]; };
 *     #define BN_PIXEL(i) bn_words[i]              // table->pixels, 4^size_log2 words
 *     #define BN_DIGIT_X(i) bn_words[16384u + (i)] // table->digits.x, 256 words
 *     #define BN_DIGIT_Y(i) bn_words[16640u + (i)] // table->digits.y, 256 words
 *     #define BN_SEED_LOW ...                      // table->seed[0], as a uniform for example
 *     #define BN_SEED_HIGH ...                     // table->seed[1]
 *     #define BN_SIZE_LOG2 7u                      // table->size_log2; 7 when it is not defined
 *
 *     vec4 u = bn_draw_blue(uint(pixel.x), uint(pixel.y), index, domain);
 *
 * Coordinates are the bits of signed integers: uint(-1) is the column left of zero. The table may
 * lie in a texture as well. How BLUE works stands in bn_draw.h, whose functions these follow one by
 * one; products of 64 bits are made of 32-bit words here. Names that begin with bn_ are taken. */
#ifndef BN_DRAW_GLSL
#define BN_DRAW_GLSL

#ifdef GL_ES
precision highp float;
precision highp int;
#endif

#ifndef BN_SIZE_LOG2
#define BN_SIZE_LOG2 7u
#endif

uint bn_hash32(uint v) {
    v = (v ^ (v >> 16u)) * 0x21f0aaadu;
    v = (v ^ (v >> 15u)) * 0xd35a2d97u;
    return v ^ (v >> 15u);
}

uint bn_domain_child(uint domain, uint key) {
    uint v = (domain + (key >> 2u) * 0x85ebca6bu + 0x9e3779b9u) * 0x21f0aaadu;
    return ((v ^ (v >> 16u)) >> 2u) | (key << 30u);
}

uint bn_owen_reversed(uint v, uint seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16u) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

uint bn_owen(uint digits, uint seed) {
    return bitfieldReverse(bn_owen_reversed(bitfieldReverse(digits), seed));
}

uint bn_sobol_second(uint digits) {
    digits ^= (digits << 1u) & 0xaaaaaaaau;
    digits ^= (digits << 2u) & 0xccccccccu;
    digits ^= (digits << 4u) & 0xf0f0f0f0u;
    digits ^= (digits << 8u) & 0xff00ff00u;
    digits ^= (digits << 16u) & 0xffff0000u;
    return digits;
}

vec4 bn_floats(uvec4 v) {
    float scale = 1.0 / 16777216.0;
    return vec4(float(v.x >> 8u) * scale, float(v.y >> 8u) * scale, float(v.z >> 8u) * scale,
                float(v.w >> 8u) * scale);
}

/* ---- BLUE ---- */

struct bn_blue_pixel {
    uint shifts;
    uint fine;
    uint key_low;
    uint key_high;
    uint shuffle;
    uint order;
    uint symmetry;
};

bn_blue_pixel bn_draw_blue_pixel(uint x, uint y, uint domain) {
    bn_blue_pixel pixel;
    uint low, high, lower, upper;
    umulExtended(domain, 0x7f4a7c15u, high, low);
    high += domain * 0x9e3779b9u + BN_SEED_HIGH;
    low += BN_SEED_LOW;
    if (low < BN_SEED_LOW) high += 1u;
    pixel.symmetry = low >> 27u;
    uint exchange = pixel.symmetry & 16u;
    uint place = (x & 127u) * 0x01000001u | (y & 127u) * 0x00010100u;
    place = (place << exchange) | (place >> ((32u - exchange) & 31u));
    uint reflect = high & 0x80808080u;
    place = (place + (high & 0x7f7f7f7fu)) ^ (reflect - (reflect >> 7u));
    uint bytes = ((1u << BN_SIZE_LOG2) - 1u) * 0x01010101u;
    place = (place & bytes & 0x00ff00ffu) |
            ((place & bytes & 0xff00ff00u) >> (8u - BN_SIZE_LOG2));
    uint entry0 = BN_PIXEL(place & 0xffffu);
    uint entry1 = BN_PIXEL(place >> 16u);
    pixel.shifts = (entry0 & 0xffffu) | (entry1 << 16u);
    pixel.fine = (entry0 >> 16u) | (entry1 & 0xffff0000u);
    uint position = x + y * 0x9e3779b1u;
    umulExtended(position, 0xde82ef95u, upper, lower);
    upper += position * 0xd1342543u;
    lower ^= upper;
    pixel.shuffle = (low << 1u) + lower;
    pixel.order = domain >> 29u;
    lower ^= low;
    upper ^= high;
    umulExtended(lower, 0x7f4a7c15u, pixel.key_high, pixel.key_low);
    pixel.key_high += upper * 0x7f4a7c15u + lower * 0x9e3779b9u;
    return pixel;
}

uint bn_draw_flip(uint index) {
    uint t = (index >> 1u) - 1u;
    uint flip = 2u << (t & 15u);
    flip |= ((index >> 5u) & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= ((index >> 6u) & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= ((index >> 7u) & 1u) << (((t + 2u) & 15u) + 1u);
    return index < 2u ? 0u : flip;
}

uint bn_draw_continue(uint first, uint shifted, uint later, uint key) {
    uint below = later | (later >> 1u);
    below |= below >> 2u;
    below |= below >> 4u;
    below |= below >> 8u;
    below |= below >> 16u;
    uint leading = below ^ (below >> 1u);
    below >>= 1u;
    return ((first ^ leading) & ~below) | (bn_owen(shifted, key) & below);
}

uint bn_draw_times_x(uint digits) {
    uint upper = (digits >> 1u) & 0x55555555u, lower = digits & 0x55555555u;
    return (lower << 1u) | (upper ^ lower);
}

uint bn_draw_times_x_plus_1(uint digits) {
    uint upper = (digits >> 1u) & 0x55555555u, lower = digits & 0x55555555u;
    return ((upper ^ lower) << 1u) | upper;
}

uint bn_draw_second_pair(uint digits, uint form) {
    digits ^= (bn_draw_times_x(digits) << 2u) & 0xccccccccu;
    digits ^= (bn_draw_times_x_plus_1(digits) << 4u) & 0xf0f0f0f0u;
    digits ^= (bn_draw_times_x(digits) << 8u) & 0xff00ff00u;
    digits ^= (bn_draw_times_x_plus_1(digits) << 16u) & 0xffff0000u;
    return digits ^ ((digits << 1u) & 0xaaaaaaaau & (0u - (form & 1u)));
}

uint bn_draw_member(uint digits, uint member) {
    uint low = 0x10204080u, high = 0x01020408u, mapped = 0u;
    if (member == 1u) { low = 0x90a04080u; high = 0x7b125cf8u; }
    if (member == 2u) { low = 0x90204080u; high = 0xdd1e2c68u; }
    if (member == 3u) { low = 0x10a04080u; high = 0x755eac18u; }
    for (uint k = 0u; k < 4u; ++k) {
        mapped ^= (low >> (8u * k)) & 255u & (0u - ((digits >> (31u - k)) & 1u));
        mapped ^= (high >> (8u * k)) & 255u & (0u - ((digits >> (27u - k)) & 1u));
    }
    return (mapped << 24u) | (digits & 0x00ffffffu);
}

/* The digits of an index in the order of the first pair. */
uint bn_draw_blue_digits(bn_blue_pixel pixel, uint index) {
    uint digits = bitfieldReverse(index);
    digits ^= digits * (pixel.shuffle << 1u);
    digits ^= (pixel.shuffle * bn_draw_flip(index)) & 0x80000000u;
    digits = bn_draw_member(digits, pixel.order >> 1u);
    return digits ^ (((digits & 0x00ffffffu) * (pixel.key_high | 1u)) & 0xff000000u);
}

/* One pair of dimensions, before reflections: x and y of what comes back. shifts, fine: the pair's
 * in the lower two bytes; random: its digits 16 to 31; key: the pair's from sample 256 on. */
uvec2 bn_draw_blue_pair(uint index, uint digits, uint shifts, uint fine, uint random, uint key) {
    uint x = BN_DIGIT_X((digits >> 24u) ^ (shifts & 255u));
    uint shift = ((shifts >> 8u) & 255u) << 24u;
    x ^= (random & 0xffffu) | ((fine & 255u) << 16u);
    random = (random >> 16u) | ((fine << 8u) & 0x00ff0000u);
    if (index < 256u) return uvec2(x, BN_DIGIT_Y((digits ^ shift) >> 24u) ^ random);
    uint second = bn_sobol_second(digits);
    uint shifted = bn_sobol_second(shift) ^ second;
    uint y = BN_DIGIT_Y(bn_sobol_second(shifted & 0xff000000u) >> 24u) ^ random;
    return uvec2(bn_draw_continue(x, digits ^ (shifts << 24u), digits & 0x00ffffffu,
                                  bn_hash32(key)),
                 bn_draw_continue(y, shifted, second & 0x00ffffffu, bn_hash32(~key)));
}

uvec2 bn_draw_blue_reflect(uvec2 v, uint reflections, uint exchange) {
    uint x = v.x ^ (0u - (reflections & 1u));
    uint y = v.y ^ (0u - ((reflections >> 1u) & 1u));
    if ((exchange & 1u) != 0u) return uvec2(y, x);
    return uvec2(x, y);
}

uvec4 bn_draw_blue_u32(uint x, uint y, uint index, uint domain) {
    bn_blue_pixel p = bn_draw_blue_pixel(x, y, domain);
    uint digits = bn_draw_blue_digits(p, index);
    uvec2 first = bn_draw_blue_pair(index, digits, p.shifts, p.fine, p.key_low, p.key_high);
    uvec2 second =
        bn_draw_blue_pair(index, bn_draw_second_pair(digits, p.order), p.shifts >> 16u, p.fine >> 16u,
                          p.key_high, (p.key_high >> 16u) | (p.key_high << 16u));
    first = bn_draw_blue_reflect(first, p.symmetry, p.symmetry >> 4u);
    second = bn_draw_blue_reflect(second, p.symmetry >> 2u, ~p.symmetry >> 4u);
    return uvec4(first.x, first.y, second.x, second.y);
}

vec4 bn_draw_blue(uint x, uint y, uint index, uint domain) {
    return bn_floats(bn_draw_blue_u32(x, y, index, domain));
}

/* ---- SOBOL and WHITE ---- */

uvec4 bn_draw_sobol_u32(uint x, uint y, uint index, uint domain) {
    uint key0 = bn_hash32(y ^ bn_hash32(domain + BN_SEED_LOW));
    key0 = bn_hash32(x ^ bn_hash32(key0 + BN_SEED_HIGH));
    uint key1 = bn_hash32(key0 + 0x9e3779b9u);
    uint key2 = bn_hash32(key1 + 0x9e3779b9u);
    uint key3 = bn_hash32(key2 + 0x9e3779b9u);
    uint key4 = bn_hash32(key3 + 0x9e3779b9u);
    uint key5 = bn_hash32(key4 + 0x9e3779b9u);
    uint first = bn_owen_reversed(bitfieldReverse(index), key0);
    uint second = bn_owen_reversed(bitfieldReverse(index), key3);
    return uvec4(bn_owen(first, key1), bn_owen(bn_sobol_second(first), key2),
                 bn_owen(second, key4), bn_owen(bn_sobol_second(second), key5));
}

vec4 bn_draw_sobol(uint x, uint y, uint index, uint domain) {
    return bn_floats(bn_draw_sobol_u32(x, y, index, domain));
}

uint bn_draw_white_one(uint a, uint b, uint index) {
    return bn_hash32(a ^ bn_hash32(index ^ bn_hash32(b)));
}

uvec4 bn_draw_white_u32(uint x, uint y, uint index, uint domain) {
    uint a = bn_hash32(x ^ bn_hash32(y ^ bn_hash32(domain + BN_SEED_LOW)));
    uint b = bn_hash32(y + bn_hash32(x + bn_hash32(domain ^ BN_SEED_HIGH)));
    return uvec4(bn_draw_white_one(a, b + 0x9e3779b9u, index),
                 bn_draw_white_one(a, b + 0x3c6ef372u, index),
                 bn_draw_white_one(a, b + 0xdaa66d2bu, index),
                 bn_draw_white_one(a, b + 0x78dde6e4u, index));
}

vec4 bn_draw_white(uint x, uint y, uint index, uint domain) {
    return bn_floats(bn_draw_white_u32(x, y, index, domain));
}

#endif
