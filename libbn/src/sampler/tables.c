/* SPDX-License-Identifier: Apache-2.0
 * The constant tables of the draws. data/blue.u32 is compiled in as bn_tables_7. The preprocessor computes
 * bn_index_digits_7, 2 KiB, which replaces the bit operations on an index by one load. Both names include the table
 * version, so that linking fails if a program's headers and the library differ. */
#include "sampler/types.h"

const uint32_t *bn_tables(size_t *count, uint32_t *version) {
    if (count != NULL) *count = BN_WORD_COUNT;
    if (version != NULL) *version = BN_DRAW_TABLE_VERSION;
    return bn_tables_7;
}

/* bn_reverse_bits() and bn_draw_flip() of a number below 256, as constants. */
#define BIT(i, from, to) (((i) >> (from)&1u) << (to))
#define REVERSED(i)                                                                                \
    (BIT(i, 0, 31) | BIT(i, 1, 30) | BIT(i, 2, 29) | BIT(i, 3, 28) | BIT(i, 4, 27) |               \
     BIT(i, 5, 26) | BIT(i, 6, 25) | BIT(i, 7, 24))
#define PLACE(i, more) (((((i) >> 1) - 1u + (more)) & 15u) + 1u)
#define FLIP(i)                                                                                    \
    ((i) < 2u ? 0u                                                                                 \
              : 1u << PLACE(i, 0u) | BIT(i, 5, PLACE(i, 5u)) | BIT(i, 6, PLACE(i, 11u)) |          \
                    BIT(i, 7, PLACE(i, 2u)))
#define ONE(i)                                                                                     \
    { REVERSED(i), FLIP(i) }
#define FOUR(i) ONE(i), ONE((i) + 1u), ONE((i) + 2u), ONE((i) + 3u)
#define SIXTEEN(i) FOUR(i), FOUR((i) + 4u), FOUR((i) + 8u), FOUR((i) + 12u)
#define SIXTY_FOUR(i) SIXTEEN(i), SIXTEEN((i) + 16u), SIXTEEN((i) + 32u), SIXTEEN((i) + 48u)

const bn_index_digits bn_index_digits_7[256] = {SIXTY_FOUR(0u), SIXTY_FOUR(64u), SIXTY_FOUR(128u),
                                                SIXTY_FOUR(192u)};
