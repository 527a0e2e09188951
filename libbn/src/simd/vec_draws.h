/* SPDX-License-Identifier: Apache-2.0
 * The vector type of draws.h for AVX2: bn_u32v holds BN_U32_LANES unsigned numbers. It is a GCC and
 * Clang vector type, whose operators work lane by lane and accept scalars on one side.
 *
 * Almost all tables are read without gathers, which are slow on some CPUs, and on others have been
 * since the microcode fix for CVE-2022-40982. Instead, each lane loads four consecutive words, and
 * the rows are transposed in registers. */
#ifndef BN_VEC_DRAWS_H
#define BN_VEC_DRAWS_H

#include <immintrin.h>
#include <stdint.h>
#include <string.h>

#define BN_U32_LANES 8
typedef uint32_t bn_u32v __attribute__((vector_size(4 * BN_U32_LANES)));

static inline bn_u32v u32_load(const void *p) {
    bn_u32v v;
    memcpy(&v, p, sizeof v);
    return v;
}

/* Reverses the bytes, then the bits of each byte, with one table lookup for each half-byte. */
static inline bn_u32v u32_reverse_bits(bn_u32v v) {
    const __m256i bytes = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
    const __m256i nibbles = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
    const bn_u32v swapped = (bn_u32v)_mm256_shuffle_epi8((__m256i)v, bytes);
    const bn_u32v low = swapped & 0x0f0f0f0fu, high = swapped >> 4u & 0x0f0f0f0fu;
    return (bn_u32v)_mm256_shuffle_epi8(nibbles, (__m256i)low) << 4u |
           (bn_u32v)_mm256_shuffle_epi8(nibbles, (__m256i)high);
}

/* Whether any lane differs from zero. */
static inline int u32_any(bn_u32v v) {
    return !_mm256_testz_si256((__m256i)v, (__m256i)v);
}

static inline bn_u32v u32_gather(const uint32_t *words, bn_u32v at) {
    const bn_u32v v = {words[at[0]], words[at[1]], words[at[2]], words[at[3]],
                       words[at[4]], words[at[5]], words[at[6]], words[at[7]]};
    return v;
}

/* Transposes the 4 x 4 values in each block of four lanes of four vectors. */
static inline void u32_transpose(bn_u32v v[4]) {
    const __m256i a = _mm256_unpacklo_epi32((__m256i)v[0], (__m256i)v[1]);
    const __m256i b = _mm256_unpackhi_epi32((__m256i)v[0], (__m256i)v[1]);
    const __m256i c = _mm256_unpacklo_epi32((__m256i)v[2], (__m256i)v[3]);
    const __m256i d = _mm256_unpackhi_epi32((__m256i)v[2], (__m256i)v[3]);
    v[0] = (bn_u32v)_mm256_unpacklo_epi64(a, c);
    v[1] = (bn_u32v)_mm256_unpackhi_epi64(a, c);
    v[2] = (bn_u32v)_mm256_unpacklo_epi64(b, d);
    v[3] = (bn_u32v)_mm256_unpackhi_epi64(b, d);
}

static inline __m128i load_four(const uint32_t *words) {
    return _mm_loadu_si128((const __m128i *)(const void *)words);
}

/* Loads into row[0] to row[3] the four words that start at `at`, for every lane. */
static inline void u32_gather_rows(const uint32_t *words, bn_u32v at, bn_u32v row[4]) {
    for (int i = 0; i < 4; ++i) {
        row[i] = (bn_u32v)_mm256_inserti128_si256(_mm256_castsi128_si256(load_four(words + at[i])),
                                                  load_four(words + at[i + 4]), 1);
    }
    u32_transpose(row);
}

/* Loads two words for each of two lanes. */
static inline __m128i load_twos(const uint32_t *first, const uint32_t *second) {
    const __m128 low = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(const void *)first));
    return _mm_castps_si128(_mm_loadh_pi(low, (const __m64 *)(const void *)second));
}

/* Loads into row[0] and row[1] the two words that start at `at`, for every lane. */
static inline void u32_gather_half_rows(const uint32_t *words, bn_u32v at, bn_u32v row[2]) {
    __m256 twos[2]; /* for lanes 0, 1 and 2, 3 of each block of four */
    for (int i = 0; i < 2; ++i) {
        const int a = 2 * i, b = a + 1;
        const __m256i v =
            _mm256_inserti128_si256(_mm256_castsi128_si256(load_twos(words + at[a], words + at[b])),
                                    load_twos(words + at[a + 4], words + at[b + 4]), 1);
        twos[i] = (__m256)v;
    }
    row[0] = (bn_u32v)_mm256_shuffle_ps(twos[0], twos[1], 0x88);
    row[1] = (bn_u32v)_mm256_shuffle_ps(twos[0], twos[1], 0xdd);
}

/* ---- Floats, (v >> 8) * 2^-24 */

static inline __m256 floats_of(bn_u32v v) {
    return _mm256_mul_ps(_mm256_cvtepi32_ps((__m256i)(v >> 8u)),
                         _mm256_set1_ps(1.0f / 16777216.0f));
}

/* out[lane] */
static inline void u32_store_one(bn_u32v x, float *out) {
    _mm256_storeu_ps(out, floats_of(x));
}

/* out[lane][2] */
static inline void u32_store_two(bn_u32v x, bn_u32v y, float *out) {
    const __m256 a = floats_of(x), b = floats_of(y);
    const __m256 low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
    _mm_storeu_ps(out, _mm256_extractf128_ps(low, 0));
    _mm_storeu_ps(out + 4, _mm256_extractf128_ps(high, 0));
    _mm_storeu_ps(out + 8, _mm256_extractf128_ps(low, 1));
    _mm_storeu_ps(out + 12, _mm256_extractf128_ps(high, 1));
}

static inline void store_lane(__m128 lane, uint32_t dimensions, float *out) {
    if (dimensions == 4) {
        _mm_storeu_ps(out, lane);
    } else {
        _mm_storel_pi((__m64 *)(void *)out, lane);
        _mm_store_ss(out + 2, _mm_movehl_ps(lane, lane));
    }
}

/* out[lane][dimensions], for three or four dimensions. */
static inline void u32_store_wide(bn_u32v v[4], uint32_t dimensions, float *out) {
    for (int d = 0; d < 4; ++d) v[d] = (bn_u32v)floats_of(v[d]);
    u32_transpose(v);
    for (int i = 0; i < 4; ++i, out += dimensions) {
        const __m256 lanes = (__m256)v[i];
        store_lane(_mm256_extractf128_ps(lanes, 0), dimensions, out);
        store_lane(_mm256_extractf128_ps(lanes, 1), dimensions, out + 4 * dimensions);
    }
}

#endif
