/* SPDX-License-Identifier: Apache-2.0
 * The draws of bn_draw.h for eight consecutive indices at once, as vectors of GNU C with the few
 * AVX2 instructions it has no word for. A file that includes this one defines BN_BLOCK_RUNS, the
 * name of its function. The functions follow those of bn_draw.h line by line. */
#include "../sampler_block.h"
#include <immintrin.h>
#include <string.h>

typedef uint32_t lanes __attribute__((vector_size(32)));

static inline lanes set(uint32_t v) {
    return (lanes)_mm256_set1_epi32((int)v);
}

static inline lanes load(const uint32_t *p) {
    return (lanes)_mm256_loadu_si256((const __m256i *)(const void *)p);
}

static inline lanes gather(const uint32_t *p, lanes index) {
    return (lanes)_mm256_i32gather_epi32((const int *)(const void *)p, (__m256i)index, 4);
}

static inline lanes hash32(lanes v) {
    v = (v ^ (v >> 16)) * 0x21f0aaadu;
    v = (v ^ (v >> 15)) * 0xd35a2d97u;
    return v ^ (v >> 15);
}

static inline lanes reverse_bits(lanes v) {
    const __m256i bytes = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
    v = (lanes)_mm256_shuffle_epi8((__m256i)v, bytes);
    v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
    v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
    return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

static inline lanes owen_reversed(lanes v, uint32_t seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1u;
    v ^= v * 0x05526c56u;
    v ^= v * 0x53a22864u;
    return v;
}

static inline lanes owen(lanes digits, uint32_t seed) {
    return reverse_bits(owen_reversed(reverse_bits(digits), seed));
}

static inline lanes sobol_second(lanes digits) {
    digits ^= (digits << 1) & 0xaaaaaaaau;
    digits ^= (digits << 2) & 0xccccccccu;
    digits ^= (digits << 4) & 0xf0f0f0f0u;
    digits ^= (digits << 8) & 0xff00ff00u;
    digits ^= (digits << 16) & 0xffff0000u;
    return digits;
}

/* Four dimensions of eight samples as floats, out[8][4]. */
static inline void store(const lanes v[4], float *out) {
    const __m256 scale = _mm256_set1_ps(1.0f / 16777216.0f);
    __m256 f[4], pairs[4];
    for (int d = 0; d < 4; ++d) {
        f[d] = _mm256_mul_ps(_mm256_cvtepi32_ps((__m256i)(v[d] >> 8)), scale);
    }
    pairs[0] = _mm256_unpacklo_ps(f[0], f[1]);
    pairs[1] = _mm256_unpacklo_ps(f[2], f[3]);
    pairs[2] = _mm256_unpackhi_ps(f[0], f[1]);
    pairs[3] = _mm256_unpackhi_ps(f[2], f[3]);
    f[0] = _mm256_shuffle_ps(pairs[0], pairs[1], 0x44); /* samples 0 and 4 */
    f[1] = _mm256_shuffle_ps(pairs[0], pairs[1], 0xee);
    f[2] = _mm256_shuffle_ps(pairs[2], pairs[3], 0x44);
    f[3] = _mm256_shuffle_ps(pairs[2], pairs[3], 0xee);
    _mm256_storeu_ps(out, _mm256_permute2f128_ps(f[0], f[1], 0x20));
    _mm256_storeu_ps(out + 8, _mm256_permute2f128_ps(f[2], f[3], 0x20));
    _mm256_storeu_ps(out + 16, _mm256_permute2f128_ps(f[0], f[1], 0x31));
    _mm256_storeu_ps(out + 24, _mm256_permute2f128_ps(f[2], f[3], 0x31));
}

/* ---- BLUE ---- */

/* The bit-reversed indices of a run. */
static inline lanes run_digits(uint32_t first) {
    const lanes last = {0x00000000u, 0x80000000u, 0x40000000u, 0xc0000000u,
                        0x20000000u, 0xa0000000u, 0x60000000u, 0xe0000000u};
    return set(bn_reverse_bits(first)) | last;
}

static inline lanes run_flips(uint32_t first) {
    const lanes last = {0, 1, 2, 3, 4, 5, 6, 7};
    const lanes two = set(2u), t = ((set(first) + last) >> 1) - 1u;
    lanes flip = two << (t & 15u);
    flip |= set(first >> 5 & 1u) << (((t + 5u) & 15u) + 1u);
    flip |= set(first >> 6 & 1u) << (((t + 11u) & 15u) + 1u);
    flip |= set(first >> 7 & 1u) << (((t + 2u) & 15u) + 1u);
    return flip;
}

static inline lanes continued(lanes first, lanes shifted, lanes later, uint32_t key) {
    lanes below = later | (later >> 1), leading;
    below |= below >> 2;
    below |= below >> 4;
    below |= below >> 8;
    below |= below >> 16;
    leading = below ^ (below >> 1);
    below >>= 1;
    return ((first ^ leading) & ~below) | (owen(shifted, key) & below);
}

static inline lanes times_x(lanes digits) {
    lanes upper = digits >> 1 & 0x55555555u, lower = digits & 0x55555555u;
    return lower << 1 | (upper ^ lower);
}

static inline lanes times_x_plus_1(lanes digits) {
    lanes upper = digits >> 1 & 0x55555555u, lower = digits & 0x55555555u;
    return (upper ^ lower) << 1 | upper;
}

static inline lanes second_pair(lanes digits, uint32_t form) {
    digits ^= (times_x(digits) << 2) & 0xccccccccu;
    digits ^= (times_x_plus_1(digits) << 4) & 0xf0f0f0f0u;
    digits ^= (times_x(digits) << 8) & 0xff00ff00u;
    digits ^= (times_x_plus_1(digits) << 16) & 0xffff0000u;
    return digits ^ ((digits << 1) & (0xaaaaaaaau & (0u - (form & 1u))));
}

static inline lanes blue_digits(const bn_draw_table *table, const bn_blue_pixel *pixel,
                                uint32_t first) {
    lanes digits = run_digits(first), later;
    digits ^= digits * (pixel->shuffle << 1);
    digits ^= run_flips(first) * pixel->shuffle & 0x80000000u;
    later = digits & 0x00ffffffu;
    return gather(table->order[pixel->order], digits >> 24) << 24 ^ later ^
           (later * ((uint32_t)(pixel->key >> 32) | 1u) & 0xff000000u);
}

static inline void blue_later(const bn_draw_table *table, const bn_blue_pixel *pixel,
                              const uint32_t lower[4], uint32_t first, lanes v[4]) {
    lanes digits = blue_digits(table, pixel, first);
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        uint32_t key = (uint32_t)(pixel->key >> 32), shifts = pixel->shifts >> 16u * pair;
        if (pair == 1u) {
            key = key >> 16 | key << 16;
            digits = second_pair(digits, pixel->order);
        }
        lanes second = sobol_second(digits);
        lanes shifted = second ^ bn_sobol_second((shifts >> 8 & 255u) << 24);
        lanes x = gather(table->digits.x, (digits >> 24) ^ (shifts & 255u)) ^ lower[2u * pair];
        lanes y = gather(table->digits.y, sobol_second(shifted & 0xff000000u) >> 24) ^
                  lower[2u * pair + 1u];
        lanes swap;
        x = continued(x, digits ^ (shifts & 255u) << 24, digits & 0x00ffffffu, bn_hash32(key));
        y = continued(y, shifted, second & 0x00ffffffu, bn_hash32(~key));
        x ^= 0u - (pixel->symmetry >> 2u * pair & 1u);
        y ^= 0u - (pixel->symmetry >> (2u * pair + 1u) & 1u);
        swap = (x ^ y) & (0u - ((pixel->symmetry >> 4 ^ pair) & 1u));
        v[2u * pair] = x ^ swap;
        v[2u * pair + 1u] = y ^ swap;
    }
}

static void blue(const bn_draw_table *table, const bn_block_rows *rows, int32_t x, int32_t y,
                 uint32_t domain, uint32_t first, uint32_t runs, float *out) {
    const bn_blue_pixel pixel = bn_draw_blue_pixel(table, x, y, domain);
    const uint32_t *const orders = table->order[pixel.order];
    const lanes shuffle = set(pixel.shuffle), multiplier = set(pixel.shuffle << 1);
    const lanes last = {0x00u, 0x80u, 0x40u, 0xc0u, 0x20u, 0xa0u, 0x60u, 0xe0u};
    /* Orders are linear: that of the upper three bits of the digits, which differ in a run, XOR
     * that of the lower five. */
    const lanes upper_order = load(rows->upper[pixel.order]);
    const uint32_t *coordinate[4];
    uint32_t lower[4], byte[4];
    lanes xored[4], v[4];
    bn_draw_blue_lower(&pixel, lower);
    for (uint32_t d = 0; d < 4u; ++d) {
        uint32_t source = d ^ ((pixel.symmetry >> 4 ^ d >> 1) & 1u);
        coordinate[d] = source & 1u ? rows->y : rows->x;
        byte[d] = 8u * source;
        xored[d] = set(lower[source] ^ (0u - (pixel.symmetry >> source & 1u)));
    }
    for (; runs > 0 && first < 256u; --runs, first += BN_RUN, out += 4 * BN_RUN) {
        lanes digits = set(table->index[first].digits) | last;
        digits ^= multiplier * digits;
        digits ^= (shuffle * load(rows->flip + first) >> 24) & 0x80u;
        uint32_t low = (uint32_t)_mm_cvtsi128_si32(_mm256_castsi256_si128((__m256i)digits)) & 31u;
        lanes order =
            (lanes)_mm256_permutevar8x32_epi32((__m256i)upper_order, (__m256i)(digits >> 5)) ^
            (orders[low] ^ pixel.shifts);
        uint32_t row = (uint32_t)_mm_cvtsi128_si32(_mm256_castsi256_si128((__m256i)order));
        for (int d = 0; d < 4; ++d) {
            __m256i set_of_eight = (__m256i)load(coordinate[d] + BN_RUN * (row >> byte[d] & 31u));
            __m256i upper = _mm256_srl_epi32((__m256i)order, _mm_cvtsi32_si128((int)byte[d] + 5));
            v[d] = (lanes)_mm256_permutevar8x32_epi32(set_of_eight, upper) ^ xored[d];
        }
        store(v, out);
    }
    for (; runs > 0; --runs, first += BN_RUN, out += 4 * BN_RUN) {
        blue_later(table, &pixel, lower, first, v);
        store(v, out);
    }
}

/* ---- SOBOL and WHITE ---- */

static void sobol(const bn_draw_table *table, int32_t x, int32_t y, uint32_t domain, uint32_t first,
                  uint32_t runs, float *out) {
    uint32_t key = bn_hash32((uint32_t)y ^ bn_hash32(domain + table->seed[0]));
    uint32_t keys[6];
    key = bn_hash32((uint32_t)x ^ bn_hash32(key + table->seed[1]));
    for (int i = 0; i < 6; ++i) {
        keys[i] = key;
        key = bn_hash32(key + 0x9e3779b9u);
    }
    for (; runs > 0; --runs, first += BN_RUN, out += 4 * BN_RUN) {
        const lanes reversed = run_digits(first);
        lanes v[4];
        for (int pair = 0; pair < 2; ++pair) {
            lanes digits = owen_reversed(reversed, keys[3 * pair]);
            v[2 * pair] = owen(digits, keys[3 * pair + 1]);
            v[2 * pair + 1] = owen(sobol_second(digits), keys[3 * pair + 2]);
        }
        store(v, out);
    }
}

static void white(const bn_draw_table *table, int32_t x, int32_t y, uint32_t domain, uint32_t first,
                  uint32_t runs, float *out) {
    const lanes last = {0, 1, 2, 3, 4, 5, 6, 7};
    uint32_t a =
        bn_hash32((uint32_t)x ^ bn_hash32((uint32_t)y ^ bn_hash32(domain + table->seed[0])));
    uint32_t b =
        bn_hash32((uint32_t)y + bn_hash32((uint32_t)x + bn_hash32(domain ^ table->seed[1])));
    uint32_t keys[4];
    for (uint32_t d = 0; d < 4u; ++d) keys[d] = bn_hash32(b + (d + 1u) * 0x9e3779b9u);
    for (; runs > 0; --runs, first += BN_RUN, out += 4 * BN_RUN) {
        const lanes index = set(first) | last;
        lanes v[4];
        for (int d = 0; d < 4; ++d) v[d] = hash32(hash32(index ^ keys[d]) ^ a);
        store(v, out);
    }
}

void BN_BLOCK_RUNS(const bn_draw_table *table, const bn_block_rows *rows, int32_t x, int32_t y,
                   uint32_t domain, uint32_t first, uint32_t runs, float *out) {
    if (table->kind == BN_SAMPLER_BLUE)
        blue(table, rows, x, y, domain, first, runs, out);
    else if (table->kind == BN_SAMPLER_SOBOL)
        sobol(table, x, y, domain, first, runs, out);
    else
        white(table, x, y, domain, first, runs, out);
}
