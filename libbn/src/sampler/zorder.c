/* SPDX-License-Identifier: Apache-2.0
 * The sampler type ZORDER: Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling
 * Error via Hierarchical Ordering of Pixels", 2020. Along a Morton curve with scrambled digits, the
 * pixels of a 4096 x 4096 tile take consecutive blocks of 2^k points from one Owen-scrambled Sobol'
 * sequence. Indices from 2^k on continue a pixel's block, scrambled differently in each pixel. A
 * domain's second pair is its first pair with the index mapped by an SZ sequence's matrix (Ahmed et
 * al., "SZ Sequences: Binary-Based (0, 2^q)-Sequences", 2025), so that all four numbers are stratified
 * together. Each domain has its own curve and sample orders, so domains are independent, like the
 * dimensions in the paper. */
#include "base/assert.h"
#include "sampler/types.h"

enum {
    BN_MORTON_BITS = 12
}; /* per axis of a tile: with 2^16 samples, a tile's indices have 40 bits */

/* A tile's samples are numbered by 64-bit indices: the pixel's position on the curve, then the index in its
 * block. Digits are reversed indices, most significant first; the upper 32 become coordinates. */
static uint64_t reverse_bits64(uint64_t v) {
    return (uint64_t)bn_reverse_bits((uint32_t)v) << 32 | bn_reverse_bits((uint32_t)(v >> 32));
}

/* bn_sobol_second() with 64 digits. */
static uint64_t sobol_second64(uint64_t digits) {
    digits ^= (digits << 1) & 0xaaaaaaaaaaaaaaaau;
    digits ^= (digits << 2) & 0xccccccccccccccccu;
    digits ^= (digits << 4) & 0xf0f0f0f0f0f0f0f0u;
    digits ^= (digits << 8) & 0xff00ff00ff00ff00u;
    digits ^= (digits << 16) & 0xffff0000ffff0000u;
    return digits ^ ((digits << 32) & 0xffffffff00000000u);
}

/* Multiplies each base-4 digit (two bits) by the element x of the four-element field. */
static uint64_t times_x64(uint64_t digits) {
    uint64_t upper = digits >> 1 & 0x5555555555555555u, lower = digits & 0x5555555555555555u;
    return lower << 1 | (upper ^ lower);
}

/* Maps the digits of the first pair to the second: multiplies by the upper triangular matrix with
 * entries binomial(j, i) x^(j - i) over the four-element field, which factors into one step per bit of
 * j, as in bn_sobol_second(). If `form` is odd, the second binary digit of each pair is added to the
 * first. This only renames the base-4 digits, and makes the four cross pairs of dimensions equally
 * good over both forms. */
static uint64_t second_pair64(uint64_t digits, uint32_t form) {
    digits ^= (times_x64(digits) << 2) & 0xccccccccccccccccu;
    digits ^= (times_x64(times_x64(digits)) << 4) & 0xf0f0f0f0f0f0f0f0u;
    digits ^= (times_x64(digits) << 8) & 0xff00ff00ff00ff00u;
    digits ^= (times_x64(times_x64(digits)) << 16) & 0xffff0000ffff0000u;
    digits ^= times_x64(digits) << 32;
    return digits ^ ((digits << 1) & (form & 1u ? 0xaaaaaaaaaaaaaaaau : 0u));
}

/* A coordinate of sample 2^k or later. `first` is the coordinate within the block, `shifted` holds
 * all digits, and `later` holds the digits from indices beyond the block. From the first of the
 * latter on, a scrambling that differs in each pixel replaces the block's. */
static uint32_t continued(uint32_t first, uint32_t shifted, uint32_t later, uint32_t key) {
    uint32_t below = later | (later >> 1), leading;
    below |= below >> 2;
    below |= below >> 4;
    below |= below >> 8;
    below |= below >> 16;
    leading = below ^ (below >> 1);
    below >>= 1;
    return ((first ^ leading) & ~below) | (bn_owen(shifted, key) & below);
}

/* Spreads the low 16 bits to the even bit positions. */
static uint32_t morton_spread(uint32_t v) {
    v &= 0xffffu;
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
}

/* Scrambles one dimension by the whole image's Owen scrambling, and by the pixel's own from the first
 * digit that comes from indices beyond the block. */
static uint32_t zorder_scramble(uint64_t block_digits, uint64_t later, uint32_t image_key,
                                uint32_t pixel_key) {
    uint32_t first = bn_owen((uint32_t)(block_digits >> 32), image_key);
    uint32_t shifted = (uint32_t)((block_digits ^ later) >> 32);
    return continued(first, shifted, (uint32_t)(later >> 32), pixel_key);
}

void bn_draw_zorder(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index,
                    uint32_t domain, uint32_t pairs, uint32_t out[4]) {
    const uint32_t coordinate_mask = (1u << BN_MORTON_BITS) - 1u, k = sampler->log2_samples;
    const uint32_t block_mask = (1u << k) - 1u;
    BN_ASSERT(k <= 16); /* bn_sampler_init_zorder() clamps the count */
    /* Each tile of 4096 x 4096 pixels is scrambled independently. */
    uint32_t tile = bn_hash32(((uint32_t)x >> BN_MORTON_BITS) ^
                              bn_hash32(((uint32_t)y >> BN_MORTON_BITS) + 0x9e3779b9u));
    uint32_t key = bn_hash32(tile ^ bn_hash32(domain + sampler->seed[0]));
    key = bn_hash32(key ^ sampler->seed[1]);
    const uint32_t curve = bn_hash32(key ^ 0x2545f491u);
    /* Scrambling the Morton index permutes the four quarters of each square of the quadtree. */
    uint32_t morton = morton_spread((uint32_t)x & coordinate_mask) |
                      morton_spread((uint32_t)y & coordinate_mask) << 1;
    uint32_t pixel =
        bn_owen(morton << (32 - 2 * BN_MORTON_BITS), curve) >> (32 - 2 * BN_MORTON_BITS);
    /* The order within the block, and of later blocks, differs in each pixel. */
    uint32_t order_key = bn_hash32(bn_hash32(pixel ^ curve) ^ (index >> k));
    uint32_t low = k == 0 ? 0 : bn_owen((index & block_mask) << (32 - k), order_key) >> (32 - k);
    /* The digits of the sample within the tile's sequence, and those that later blocks of the pixel add. */
    uint64_t block = reverse_bits64((uint64_t)pixel << k | low);
    uint64_t later = reverse_bits64((uint64_t)(index & ~block_mask));
    uint64_t top = k == 0 ? 0 : ~(uint64_t)0 << (64 - k);
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        key = bn_hash32(key + 0x9e3779b9u);
        if (!(pairs >> pair & 1u)) continue;
        uint32_t pixel_key = bn_hash32(pixel ^ bn_hash32(key ^ 0x5bd1e995u));
        if (pair == 1) block = second_pair64(block, curve);
        uint64_t later_second = sobol_second64(later), block_second = sobol_second64(block);
        block_second ^= later_second & top;
        out[2 * pair] =
            zorder_scramble(block, later, bn_hash32(key ^ 1u), bn_hash32(pixel_key ^ 1u));
        out[2 * pair + 1] = zorder_scramble(block_second, later_second & ~top, bn_hash32(key ^ 2u),
                                            bn_hash32(pixel_key ^ 2u));
    }
}
