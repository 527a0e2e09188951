/* SPDX-License-Identifier: Apache-2.0
 * The sampler type MASK. The mask supplies every pixel's first sample; each dimension looks it up at a
 * different shift. The other samples come from an Owen-scrambled Sobol' (0, 2)-sequence that starts at
 * zero. The mask's value is added as a digital shift (XOR), which preserves a pixel's nets. The usual
 * Cranley-Patterson rotation (1976) destroys them, and is worse than no mask at about 4 or more
 * samples. */
#include "base/assert.h"
#include "sampler/types.h"

/* Accessed directly, not through bn_builtin_mask(), so that programs that draw do not link the other
 * masks. */
extern const uint16_t bn_data_mask_64[];

/* The keys of the scramblings, arbitrary and the same in every pixel, because the mask's values differ. */
enum { BN_MASK_KEY_X = 0x51ed270b, BN_MASK_KEY_Y = 0x3c6ef372 };

/* A shifted coordinate on the torus, also for negative ones. */
static uint32_t wrap(int32_t coordinate, uint32_t shift, uint32_t extent) {
    int64_t sum = ((int64_t)coordinate + shift) % extent;
    return (uint32_t)(sum < 0 ? sum + extent : sum);
}

/* The value of the texel that a lookup reads, as 32 binary digits. */
static uint32_t mask_lookup(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t key) {
    uint32_t w = sampler->mask_width, h = sampler->mask_height;
    uint32_t shift_x = (uint32_t)((uint64_t)key * w >> 32);
    uint32_t shift_y = (uint32_t)((uint64_t)bn_hash32(key) * h >> 32);
    const size_t at = (size_t)wrap(y, shift_y, h) * w + wrap(x, shift_x, w);
    uint64_t rank;
    if (sampler->mask_rank_bits == 32) {
        rank = ((const uint32_t *)sampler->mask)[at];
    } else {
        rank = (sampler->mask != NULL ? (const uint16_t *)sampler->mask : bn_data_mask_64)[at];
    }
    /* (rank + 1/2) / texels times 2^32: the scale is 2^63 / texels, rounded up. */
    BN_ASSERT(rank < (uint64_t)w * h);
    return (uint32_t)((2u * rank + 1u) * sampler->mask_scale >> 32);
}

/* Owen scrambling that maps zero to itself. */
static uint32_t mask_scramble(uint32_t digits, uint32_t key) {
    return bn_owen(digits, key) ^ bn_owen(0, key);
}

void bn_draw_mask(const bn_sampler *sampler, int32_t x, int32_t y, uint32_t index, uint32_t domain,
                  uint32_t pairs, uint32_t out[4]) {
    uint32_t key = bn_hash32(bn_hash32(domain + sampler->seed[0]) ^ sampler->seed[1]);
    uint32_t pixel = bn_hash32((uint32_t)x ^ bn_hash32((uint32_t)y ^ key));
    uint32_t reversed = bn_reverse_bits(index), low = sampler->mask_low_digits;
    for (uint32_t pair = 0; pair < 2u; ++pair) {
        const uint32_t key_x = bn_hash32(key + 0x9e3779b9u), key_y = bn_hash32(key_x + 0x9e3779b9u);
        const uint32_t pixel_x = pixel, pixel_y = bn_hash32(pixel + 0x9e3779b9u);
        key = key_y;
        pixel = bn_hash32(pixel_y + 0x9e3779b9u);
        if (!(pairs >> pair & 1u)) continue;
        /* Rank scrambling: a nested shuffle, different for each pixel and pair. Without it, all pairs would repeat
         * the same points in the same order. It maps each power-of-two prefix to itself. */
        uint32_t digits = reversed ^ (reversed * (pixel_x << 1));
        uint32_t second = bn_sobol_second(digits);
        out[2 * pair] = mask_scramble(digits, BN_MASK_KEY_X) ^ mask_lookup(sampler, x, y, key_x) ^
                        (pixel_x & low);
        out[2 * pair + 1] = mask_scramble(second, BN_MASK_KEY_Y) ^
                            mask_lookup(sampler, x, y, key_y) ^ (pixel_y & low);
    }
}
