/* SPDX-License-Identifier: Apache-2.0
 * Inline versions of the draws in bn.h: bn_draw_1d(), bn_draw_2d(), bn_draw_4d() and bn_draw_4d_u32() are
 * bit-identical to bn_sample_1d() and its variants. BLUE is inlined; the other sampler types call the
 * library. bn_path.h and bn.hpp use these functions. Linking fails if the library has a different table
 * version.
 *
 * ON A GPU
 *
 * The draws are in bn_draw.glsl, which GLSL, HLSL, Metal and WGSL share; they use only 32-bit integers
 * (docs/shaders.md). In CUDA and HIP, include this header: bn_draw_blue_4d(), bn_draw_sobol_4d(),
 * bn_draw_white_4d() and bn_domain_child() are then __host__ __device__. BLUE reads a copy of bn_tables() in
 * device memory; the seed is an argument.
 *
 * HOW BLUE WORKS
 *
 * A pixel's samples form a digital sequence: each bit of the sample index and of the pixel's label XORs a
 * vector of digits into each of the four coordinates. A label is the pixel's path through a quadtree over a
 * tile of 64 x 64 pixels. A search (libbn/tools/bn_bake_sampler.c) chose the vectors and the quadtree so that
 * the errors of neighbouring pixels cancel. Each copy of the tile adds random digits and has its own sample
 * order. Each family shifts and reflects the tile, and its four members use different vectors. docs/blue.md
 * explains the construction and lists the terms; bn_draw.glsl documents the tables.
 *
 * COST
 *
 * On x86-64, a 4-D draw takes about 115 instructions and four loads of 8 to 16 bytes from 47 KiB of tables;
 * each member of a family uses half of the tables. Drawing one pair or one dimension takes slightly fewer
 * instructions. When inlined into a loop, draws for many domains or indices in one pixel share work. For
 * indices of 256 and above, every four additional index bits cost one more XOR. With SSE2, the last step
 * handles all four dimensions at once. CUDA and HIP do not use SSE2. To disable it elsewhere, define
 * BN_DRAW_PLAIN; the results are bit-identical. */
#ifndef BN_BN_DRAW_H
#define BN_BN_DRAW_H

/* Your warnings, such as -Wshadow, do not apply to this header unless you define BN_SHOW_WARNINGS. */
#if defined(__GNUC__) && !defined(BN_SHOW_WARNINGS)
#pragma GCC system_header
#endif

#include <bn/bn_device.h>

#if !defined(BN_DRAW_PLAIN) && !defined(BN_DEVICE_TOO) &&                                          \
    (defined(__SSE2__) || (defined(_M_X64) && !defined(_M_ARM64EC)))
#define BN_DRAW_SSE2 1
#include <emmintrin.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Code shared with shaders */

typedef struct bn_uint4 bn_uint4;
typedef struct bn_uint2 bn_uint2;
typedef struct bn_blue_pixel bn_blue_pixel;

#ifndef BN_DEVICE_TOO
/* A table lookup, because the ALU is the bottleneck. */
BN_HOST_INLINE uint32_t bn_draw_key_factor(uint32_t member) {
    static const uint32_t factors[4] = {0xd35a2d97u, 0xdf31c26du, 0xeb095743u, 0xf6e0ec19u};
    return factors[member];
}
#define BN_KEY_FACTOR(member) bn_draw_key_factor(member)
#endif
#include <bn/bn_draw.glsl>

BN_DEVICE_INLINE float bn_draw_float(uint32_t bits) {
    /* 2^-24 in decimal because C++11 has no hexadecimal floats. The 24 bits fit in a signed integer. */
    return (float)(int32_t)(bits >> 8) * (1.0f / 16777216.0f);
}

BN_DEVICE_INLINE void bn_draw_floats(bn_uint4 v, float out[4]) {
    out[0] = bn_draw_float(v.x);
    out[1] = bn_draw_float(v.y);
    out[2] = bn_draw_float(v.z);
    out[3] = bn_draw_float(v.w);
}

BN_DEVICE_INLINE void bn_draw_pair_floats(bn_uint2 v, float out[2]) {
    out[0] = bn_draw_float(v.x);
    out[1] = bn_draw_float(v.y);
}

/* ---- Draws from words and a seed, as in shaders */

/* Same as bn_sample_4d() for a BLUE sampler whose bn_sampler_seed() is `seed`. `words` is the table returned
 * by bn_tables(). */
BN_DEVICE_INLINE void bn_draw_blue_4d(const uint32_t *words, bn_uint2 seed, int32_t x, int32_t y,
                                      uint32_t index, uint32_t domain, float out[4]) {
    bn_draw_floats(bn_draw_blue_bits(words, seed, (uint32_t)x, (uint32_t)y, index, domain), out);
}

/* Same for SOBOL. */
BN_DEVICE_INLINE void bn_draw_sobol_4d(bn_uint2 seed, int32_t x, int32_t y, uint32_t index,
                                       uint32_t domain, float out[4]) {
    bn_draw_floats(bn_draw_sobol_bits(seed, (uint32_t)x, (uint32_t)y, index, domain), out);
}

/* Same for WHITE. */
BN_DEVICE_INLINE void bn_draw_white_4d(bn_uint2 seed, int32_t x, int32_t y, uint32_t index,
                                       uint32_t domain, float out[4]) {
    bn_draw_floats(bn_draw_white_bits(seed, (uint32_t)x, (uint32_t)y, index, domain), out);
}

/* Same as bn_sample_2d(): dimensions (0, 1) for pair 0, (2, 3) for pair 1. */
BN_DEVICE_INLINE void bn_draw_blue_2d(const uint32_t *words, bn_uint2 seed, int32_t x, int32_t y,
                                      uint32_t index, uint32_t domain, uint32_t pair,
                                      float out[2]) {
    bn_draw_pair_floats(
        bn_draw_blue_pair_bits(words, seed, (uint32_t)x, (uint32_t)y, index, domain, pair), out);
}

BN_DEVICE_INLINE void bn_draw_sobol_2d(bn_uint2 seed, int32_t x, int32_t y, uint32_t index,
                                       uint32_t domain, uint32_t pair, float out[2]) {
    uint32_t key = bn_draw_sobol_key(seed, (uint32_t)x, (uint32_t)y, domain);
    if (pair & 1u) key = bn_draw_sobol_second_key(key);
    bn_draw_pair_floats(bn_draw_sobol_two(key, index), out);
}

BN_DEVICE_INLINE void bn_draw_white_2d(bn_uint2 seed, int32_t x, int32_t y, uint32_t index,
                                       uint32_t domain, uint32_t pair, float out[2]) {
    bn_draw_pair_floats(
        bn_draw_white_pair_bits(seed, (uint32_t)x, (uint32_t)y, index, domain, pair & 1u), out);
}

#ifndef BN_DEVICE_ONLY

/* ---- The library's constant tables. Their names include BN_DRAW_TABLE_VERSION. */

/* The tables returned by bn_tables(). */
BN_API extern const uint32_t bn_tables_7[BN_WORD_COUNT];

/* The lowest eight bits of an index, bit-reversed, and the value bn_draw_flip() returns for them. */
typedef struct bn_index_digits {
    uint32_t reversed, flip;
} bn_index_digits;

/* Indexed by the lowest eight bits. */
BN_API extern const bn_index_digits bn_index_digits_7[256];

BN_HOST_INLINE bn_uint2 bn_draw_seed(const bn_sampler *sampler) {
    bn_uint2 seed;
    seed.x = sampler->seed[0];
    seed.y = sampler->seed[1];
    return seed;
}

/* ---- BLUE, faster */

/* bn_draw_blue_digits() of an index, with its reversed digits and its flip looked up in a table. */
BN_HOST_INLINE uint32_t bn_draw_blue_shuffled(uint32_t shuffle, uint32_t index) {
    const bn_index_digits low = bn_index_digits_7[index & 255u];
    uint32_t reversed = low.reversed;
    if (index > 255u) {
        reversed |= bn_index_digits_7[index >> 8 & 255u].reversed >> 8 |
                    bn_index_digits_7[index >> 16 & 255u].reversed >> 16 |
                    bn_index_digits_7[index >> 24].reversed >> 24;
    }
    return bn_draw_blue_digits(shuffle, reversed, low.flip);
}

#if defined(BN_DRAW_SSE2)

BN_HOST_INLINE __m128i bn_draw_load_pair(const uint32_t *words) {
    return _mm_loadl_epi64((const __m128i *)(const void *)words);
}

BN_HOST_INLINE __m128i bn_draw_load_four(const uint32_t *words) {
    return _mm_loadu_si128((const __m128i *)(const void *)words);
}

#endif

/* Sample `index` of a pixel. */
BN_HOST_INLINE void bn_draw_blue_floats(const bn_blue_pixel *pixel, uint32_t index, float out[4]) {
#if defined(BN_DRAW_SSE2)
    /* All four dimensions in one register. */
    const uint32_t digits = bn_draw_blue_shuffled(pixel->shuffle, index);
    const uint32_t *point = bn_tables_7 + BN_POINTS_AT + (size_t)pixel->member * 4u;
    const __m128i keys = _mm_cvtsi32_si128((int)pixel->keys);
    __m128i low = _mm_cvtsi32_si128((int)pixel->low);
    __m128i high =
        _mm_unpacklo_epi32(keys, _mm_cvtsi32_si128((int)bn_draw_second_keys(pixel->keys)));
    low = _mm_unpacklo_epi32(low, _mm_xor_si128(low, keys));
    __m128i v;
    high = _mm_xor_si128(high,
                         _mm_xor_si128(bn_draw_load_pair(bn_tables_7 + (size_t)pixel->place * 2u),
                                       bn_draw_load_pair(bn_tables_7 + (size_t)pixel->block * 2u)));
    v = _mm_xor_si128(_mm_unpacklo_epi16(low, high),
                      bn_draw_load_four(point + (size_t)(digits >> 24) * 16u));
    if (index > 255u) {
        const uint32_t *later = bn_tables_7 + BN_LATER_AT + (size_t)pixel->member * 4u;
        for (uint32_t rest = digits << 8; rest != 0; rest <<= 4, later += 256) {
            v = _mm_xor_si128(v, bn_draw_load_four(later + (size_t)(rest >> 28) * 16u));
        }
    }
    _mm_storeu_ps(
        out, _mm_mul_ps(_mm_cvtepi32_ps(_mm_srli_epi32(v, 8)), _mm_set1_ps(1.0f / 16777216.0f)));
#else
    bn_draw_floats(bn_draw_blue_at(bn_tables_7, *pixel, index), out);
#endif
}

/* One pair of the sample. */
BN_HOST_INLINE void bn_draw_blue_pair_floats(const bn_blue_pixel *pixel, uint32_t index,
                                             uint32_t pair, float out[2]) {
#if defined(BN_DRAW_SSE2)
    const uint32_t half = pair & 1u;
    const size_t member = (size_t)pixel->member * 4u + half * 2u;
    const uint32_t digits = bn_draw_blue_shuffled(pixel->shuffle, index);
    uint32_t high = bn_tables_7[(size_t)pixel->place * 2u + half] ^
                    bn_tables_7[(size_t)pixel->block * 2u + half] ^
                    (half ? bn_draw_second_keys(pixel->keys) : pixel->keys);
    __m128i v =
        bn_draw_load_pair(bn_tables_7 + BN_POINTS_AT + (size_t)(digits >> 24) * 16u + member);
    __m128i low = _mm_cvtsi32_si128((int)(pixel->low ^ (half ? pixel->keys : 0u)));
    __m128 u;
    v = _mm_xor_si128(v, _mm_unpacklo_epi16(low, _mm_cvtsi32_si128((int)high)));
    if (index > 255u) {
        const uint32_t *later = bn_tables_7 + BN_LATER_AT + member;
        for (uint32_t rest = digits << 8; rest != 0; rest <<= 4, later += 256) {
            v = _mm_xor_si128(v, bn_draw_load_pair(later + (size_t)(rest >> 28) * 16u));
        }
    }
    u = _mm_mul_ps(_mm_cvtepi32_ps(_mm_srli_epi32(v, 8)), _mm_set1_ps(1.0f / 16777216.0f));
    _mm_storel_epi64((__m128i *)(void *)out, _mm_castps_si128(u));
#else
    bn_draw_pair_floats(bn_draw_blue_pair_at(bn_tables_7, *pixel, index, pair), out);
#endif
}

/* ---- The draws in bn.h */

BN_HOST_INLINE void bn_draw_4d_u32(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                                   uint32_t domain, uint32_t out[4]) {
    if (sampler->type == BN_SAMPLER_BLUE) {
        const bn_uint4 v = bn_draw_blue_bits(bn_tables_7, bn_draw_seed(sampler), (uint32_t)x,
                                             (uint32_t)y, index, domain);
        out[0] = v.x;
        out[1] = v.y;
        out[2] = v.z;
        out[3] = v.w;
    } else {
        bn_sample_4d_u32(sampler, x, y, index, domain, out);
    }
}

BN_HOST_INLINE void bn_draw_4d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                               uint32_t domain, float out[4]) {
    if (sampler->type == BN_SAMPLER_BLUE) {
        const bn_blue_pixel pixel = bn_draw_blue_pixel(bn_tables_7, bn_draw_seed(sampler),
                                                       (uint32_t)x, (uint32_t)y, domain);
        bn_draw_blue_floats(&pixel, index, out);
    } else {
        bn_sample_4d(sampler, x, y, index, domain, out);
    }
}

BN_HOST_INLINE void bn_draw_2d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                               uint32_t domain, uint32_t pair, float out[2]) {
    if (sampler->type == BN_SAMPLER_BLUE) {
        const bn_blue_pixel pixel = bn_draw_blue_pixel(bn_tables_7, bn_draw_seed(sampler),
                                                       (uint32_t)x, (uint32_t)y, domain);
        bn_draw_blue_pair_floats(&pixel, index, pair, out);
    } else {
        bn_sample_2d(sampler, x, y, index, domain, pair, out);
    }
}

BN_HOST_INLINE float bn_draw_1d(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                                uint32_t domain) {
    float out[2];
    bn_draw_2d(sampler, x, y, index, domain, 0, out);
    return out[0];
}

#endif

#ifdef __cplusplus
}
#endif

#undef BN_DRAW_SSE2
#include <bn/bn_device.h>

#endif
