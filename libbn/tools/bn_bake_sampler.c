/* SPDX-License-Identifier: Apache-2.0
 * Makes libbn/data/blue.u32, the table behind BN_SAMPLER_BLUE.
 *
 * Samples and pixels are in pole order (pole_order.h). Three stages choose the remaining degrees of freedom
 * so that errors of neighbouring pixels cancel: the vectors of each member of a family (bake_vectors.c), the
 * quadtree down to the blocks (bake_blocks.c), and the quadtree inside the blocks (bake_places.c). All moves
 * preserve the nets. Takes half an hour to an hour on one core. The vectors determine nearly all of the error; the
 * quadtree determines how visible its own pattern is. docs/blue.md lists the terms.
 *
 * The table depends only on the effort. Cosines, logarithms and exponentials come from the C library, so
 * another library may give a different table of the same quality. */
#include "bake_tile.h"
#include <errno.h>
#include <string.h>

/* The seeds of the vectors and of the quadtree; the latter has the lowest spectral peaks of three seeds. */
enum { VECTOR_SEED = 1, TREE_SEED = 5, PATH_SIZE = 4096 };

/* ---- The quadtree ---- */

/* A random permutation of the four children of a level's node (x, y): p ^ flip after a linear map. Without
 * the map, both rows of the parent flip columns alike, and both columns flip rows alike, which keeps
 * pixels along a column or row apart. */
static uint32_t permuted(uint64_t seed, int level, uint32_t x, uint32_t y, int linear) {
    static const uint32_t maps[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 1, 3, 2},
                                        {0, 3, 1, 2}, {0, 2, 3, 1}, {0, 3, 2, 1}};
    const uint32_t child = (x >> level & 1u) | (y >> level & 1u) << 1;
    const uint32_t column = x >> (level + 1), row = y >> (level + 1);
    const uint64_t node = (uint64_t)level << 32;
    if (linear) {
        const uint64_t hash = bake_mix(bake_mix(seed + node) + (row << 16 | column));
        return maps[(hash >> 32) % 6][child] ^ (uint32_t)(hash & 3u);
    }
    const uint64_t along = bake_mix(bake_mix(seed + node + 1) + (row >> 1 << 16 | column));
    const uint64_t across = bake_mix(bake_mix(seed + node + 2) + (row << 16 | column >> 1));
    return child ^ (uint32_t)(along & 1u) ^ (uint32_t)(across & 1u) << 1;
}

/* Assigns labels by randomly permuting the four children of every quadtree node. Uses `seed` down to blocks
 * of 4 x 4 pixels, and `within` inside them. Inside, all permutations are allowed if `linear` is set,
 * otherwise only those that keep columns and rows apart. */
static void make_labels(uint16_t label[PIXELS], uint64_t seed, uint64_t within, int linear) {
    for (uint32_t p = 0; p < PIXELS; ++p) {
        uint32_t out = 0;
        for (int level = 5; level >= 0; --level) {
            out = out << 2 | permuted(level < 2 ? within : seed, level, p % SIDE, p / SIDE,
                                      linear && level < 2);
        }
        label[p] = (uint16_t)out;
    }
}

static void make_trees(bake_table *table, uint64_t seed) {
    for (int member = 0; member < MEMBERS; ++member) {
        make_labels(table->label[member], bake_mix(seed),
                    bake_mix(seed + 1000 * (uint64_t)(member + 1)), member != 0);
    }
}

/* ---- The table ---- */

/* Adds random sums of each coordinate's upper digits to the digits below the sixteenth, so that points
 * differ in all 32 digits. This linear scrambling preserves every net. The searches ignore the lower
 * digits. */
static void scramble_lower_digits(bake_table *table, uint64_t seed) {
    bake_random r = bake_random_make(seed, 9, 0);
    for (int member = 0; member < MEMBERS; ++member) {
        for (int d = 0; d < 4; ++d) {
            for (int to = 16; to < 32; ++to) {
                for (int from = 0; from < to; ++from) {
                    if (bake_random_below(&r, 2)) {
                        pole_add_digit(&table->member[member], d, from, to);
                    }
                }
            }
        }
    }
}

/* Converts the label vectors to the table's form: sixteen digits, where the blocks in the first row and
 * the first column are the basis of each quadtree level. */
static void rebase_labels(bake_table *table) {
    for (int member = 0; member < MEMBERS; ++member) {
        pole_vectors *v = &table->member[member];
        const pole_vectors old = *v;
        for (int i = 0; i < POLE_LABEL_BITS; ++i) {
            const int block = i < 4 ? 0 : (i & 1 ? 16 : 1) << (i / 2 - 2);
            const uint32_t upper = table->label[0][0] ^ table->label[0][bake_pixel_of(block, 0)];
            pole_sum(old.label, i < 4 ? 1u << i : upper & ~15u, v->label[i]);
            for (int d = 0; d < 4; ++d) v->label[i][d] &= 0xffff0000u;
        }
    }
}

static void make_table(bake_table *table, double effort) {
    bake_options options = {VECTOR_SEED, effort};
    for (int member = 0; member < MEMBERS; ++member) {
        pole_vectors_make(&table->member[member], member);
    }
    make_trees(table, VECTOR_SEED);
    for (int again = 0; again < 2; ++again) {
        for (int member = 0; member < MEMBERS; ++member) {
            bake_vectors(table, &options, member, again);
        }
    }
    bake_blocks(table, &options);
    scramble_lower_digits(table, VECTOR_SEED);
    rebase_labels(table);

    options.seed = TREE_SEED;
    make_trees(table, TREE_SEED);
    bake_blocks(table, &options);
    for (int member = 0; member < MEMBERS; ++member) bake_places(table, &options, member);
    scramble_lower_digits(table, TREE_SEED);
}

/* ---- The file ---- */

/* Packs the upper halves of four coordinates into two words. */
static void pack_digits(const uint32_t v[4], uint32_t out[2]) {
    out[0] = v[0] >> 16 | (v[1] & 0xffff0000u);
    out[1] = v[2] >> 16 | (v[3] & 0xffff0000u);
}

/* bn_draw.glsl documents the layout. */
static void pack(const bake_table *table, uint32_t words[BN_WORD_COUNT]) {
    memset(words, 0, BN_WORD_COUNT * sizeof *words);
    for (uint32_t p = 0; p < PIXELS; ++p) {
        for (uint32_t a = 0; a < MEMBERS; ++a) {
            words[BN_PIXELS_AT + p] |= (table->label[a][p] & 15u) << (8 * a);
        }
    }
    for (uint32_t a = 0; a < MEMBERS; ++a) {
        const pole_vectors *v = &table->member[a];
        uint32_t sum[4];
        for (uint32_t b = 0; b < BLOCKS; ++b) {
            pole_sum(v->label, table->label[0][bake_pixel_of((int)b, 0)] & ~15u, sum);
            pack_digits(sum, words + BN_BLOCKS_AT + (b * MEMBERS + a) * 2u);
        }
        for (uint32_t i = 0; i < 16u; ++i) {
            pole_sum(v->label, i, sum);
            pack_digits(sum, words + BN_PLACES_AT + (a * 16u + i) * 2u);
        }
        /* Tables for an index's lowest eight bits, then for four bits at a time, each reversed. */
        for (uint32_t i = 0; i < 256u; ++i) {
            const uint32_t index = bn_reverse_bits(i) >> 24;
            pole_sum(v->index, index, words + BN_POINTS_AT + (i * MEMBERS + a) * 4u);
        }
        for (uint32_t i = 0; i < 6u * 16u; ++i) {
            const uint32_t index = bn_reverse_bits(i & 15u) >> 28 << (8u + i / 16u * 4u);
            pole_sum(v->index, index, words + BN_LATER_AT + (i * MEMBERS + a) * 4u);
        }
    }
}

/* Writes little-endian words to the open file `part`, and renames it. */
static int write_table(const bake_table *table, FILE *file, const char *part, const char *path) {
    static uint32_t words[BN_WORD_COUNT];
    static unsigned char bytes[sizeof words];
    pack(table, words);
    for (size_t i = 0; i < sizeof bytes; ++i) {
        bytes[i] = (unsigned char)(words[i / 4] >> (8 * (i % 4)));
    }
    const int whole = fwrite(bytes, sizeof bytes, 1, file) == 1;
    return (fclose(file) == 0) & whole && rename(part, path) == 0;
}

int main(int argc, char **argv) {
    static bake_table table;
    static char part[PATH_SIZE];
    char *end = NULL;
    const double effort = argc == 3 ? strtod(argv[1], &end) : -1;
    if (!(effort >= 0 && effort <= 100) || end == argv[1] || *end != '\0' ||
        strlen(argv[2]) > PATH_SIZE - sizeof ".part") {
        fputs(
            "Usage: bn_bake_sampler EFFORT OUTPUT.u32\n"
            "EFFORT of the search is 0 to 100; 1 made the table of the library, in up to an hour\n",
            stderr);
        return 2;
    }
    strcat(strcpy(part, argv[2]), ".part");
    FILE *file = fopen(part, "wb"); /* opened before all the work */
    if (file != NULL) {
        make_table(&table, effort);
        if (write_table(&table, file, part, argv[2])) return 0;
    }
    fprintf(stderr, "bn_bake_sampler: cannot write %s: %s\n", argv[2], strerror(errno));
    remove(part);
    return 1;
}
