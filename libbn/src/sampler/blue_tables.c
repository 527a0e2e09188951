/* SPDX-License-Identifier: Apache-2.0
 * Makes the tables of the draws from data/blue.u32, which holds a tile of labels and, for each
 * member of a family, the vectors of digits that the bits of an index and of a label contribute.
 * Takes microseconds. */
#include "sampler/blue_tables.h"
#include <string.h>

extern const uint32_t bn_data_blue[];

enum {
    PIXELS = 64 * 64,
    BLOCKS = 16 * 16,
    INDEX_BITS = 32,
    PLACE_BITS = 4,
    LABEL_BITS = 12,
    MEMBERS = 4,
    /* The parts of the data, in words. */
    TILE_AT = 0,                         /* as in the tables */
    BLOCKS_AT = TILE_AT + PIXELS,        /* 8 bits a block: the upper bits of its labels */
    VECTORS_AT = BLOCKS_AT + BLOCKS / 4, /* [member][INDEX_BITS + LABEL_BITS][4] */
    VECTORS = INDEX_BITS + LABEL_BITS
};

/* XORs the vectors first, first + 1 ... of a member whose bits are set in `bits`. */
static void add_vectors(uint32_t member, uint32_t first, uint32_t bits, uint32_t sum[4]) {
    const uint32_t *vector = bn_data_blue + VECTORS_AT + (member * VECTORS + first) * 4u;
    for (int d = 0; d < 4; ++d) sum[d] = 0;
    for (; bits != 0; bits >>= 1, vector += 4) {
        for (int d = 0; d < 4 && (bits & 1u); ++d) sum[d] ^= vector[d];
    }
}

/* The same, reduced to the upper halves of the four coordinates. */
static void add_label_vectors(uint32_t member, uint32_t first, uint32_t bits, uint32_t out[2]) {
    uint32_t sum[4];
    add_vectors(member, first, bits, sum);
    out[0] = sum[0] >> 16 | (sum[1] & 0xffff0000u);
    out[1] = sum[2] >> 16 | (sum[3] & 0xffff0000u);
}

static void fill_words(uint32_t *words) {
    memcpy(words + BN_PIXELS_AT, bn_data_blue + TILE_AT, PIXELS * sizeof *words);
    for (uint32_t member = 0; member < MEMBERS; ++member) {
        for (uint32_t i = 0; i < BLOCKS; ++i) {
            uint32_t label = bn_data_blue[BLOCKS_AT + i / 4u] >> (i % 4u * 8u) & 255u;
            add_label_vectors(member, INDEX_BITS + PLACE_BITS, label,
                              words + BN_BLOCKS_AT + (i * MEMBERS + member) * 2u);
        }
        for (uint32_t i = 0; i < 1u << PLACE_BITS; ++i) {
            add_label_vectors(member, INDEX_BITS, i,
                              words + BN_PLACES_AT + (member * 16u + i) * 2u);
        }
        for (uint32_t i = 0; i < 256u; ++i) {
            add_vectors(member, 0, i,
                        words + BN_POINTS_AT +
                            ((bn_reverse_bits(i) >> 24) * MEMBERS + member) * 4u);
        }
        for (uint32_t i = 0; i < 6u * 16u; ++i) {
            add_vectors(member, 8u + i / 16u * 4u, bn_reverse_bits(i) >> 28,
                        words + BN_LATER_AT + (i * MEMBERS + member) * 4u);
        }
    }
}

void bn_blue_tables_fill(bn_sampler *sampler, int32_t kind, uint64_t seed_key) {
    bn_draw_table *table = &sampler->table;
    table->version = BN_DRAW_TABLE_VERSION;
    table->kind = kind;
    table->sampler = sampler;
    table->words = sampler->words;
    sampler->words[BN_SEED_AT] = (uint32_t)seed_key;
    sampler->words[BN_SEED_AT + 1u] = (uint32_t)(seed_key >> 32);
    fill_words(sampler->words);
    for (uint32_t i = 0; i < 256u; ++i) {
        table->index[i].reversed = bn_reverse_bits(i);
        table->index[i].flip = bn_draw_flip(i);
    }
}
