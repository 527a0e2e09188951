/* SPDX-License-Identifier: Apache-2.0
 * The guarantees of BLUE's pole order. In every aligned square of 2^s x 2^s pixels, the first 2^k samples
 * of each pixel form a (0, k + 2 s, 2)-net in base 2 in both pairs, for each of a family's four domains.
 * Within a pixel, the samples form nets at all sample counts. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <stdlib.h>
#include <string.h>

enum { MEMBERS = 4, TILE = 64 };

static uint32_t points[MOST_POINTS][4];

/* Whether the first 2^k samples of all pixels in a square of 2^s x 2^s pixels at (x, y) form nets. */
static int block_is_net(const bn_sampler *sampler, int32_t x, int32_t y, int s, int k,
                        uint32_t domain) {
    draw_points(points, sampler, x, y, s, k, 0, domain);
    return are_nets_in_pairs(points, k + 2 * s);
}

/* Finds the origin of the aligned squares of 2^s x 2^s pixels. The alignment of the next smaller squares
 * leaves four candidates. With only one of them, the first samples of multiple squares form nets. */
static void find_alignment(const bn_sampler *sampler, int s, uint32_t domain, int32_t corner[2]) {
    enum { BLOCKS = 8 };
    const int32_t side = 1 << s;
    int32_t found[2] = {0, 0};
    int count = 0;
    for (int32_t i = 0; i < 4; ++i) {
        int32_t x = corner[0] + i % 2 * (side / 2), y = corner[1] + i / 2 * (side / 2);
        int net = 1;
        for (int32_t block = 0; block < BLOCKS && net; ++block) {
            net = block_is_net(sampler, x + block * side, y - 3 * block * side, s, 0, domain);
        }
        if (!net) continue;
        found[0] = x;
        found[1] = y;
        ++count;
    }
    CHECK(count == 1);
    memcpy(corner, found, sizeof found);
}

static void test_nets(void) {
    enum { FAMILIES = 3, LEVELS = 6 };
    const bn_sampler sampler = make_sampler(BN_SAMPLER_BLUE, 0, 8);
    for (uint32_t family = 0; family < FAMILIES; ++family) {
        int32_t corner[LEVELS + 1][2] = {{-100, 1000}};
        uint32_t first = bn_domain_child(family, 4u * family);
        for (int s = 1; s <= LEVELS; ++s) {
            memcpy(corner[s], corner[s - 1], sizeof corner[s]);
            find_alignment(&sampler, s, first, corner[s]);
        }
        for (uint32_t member = 0; member < MEMBERS; ++member) {
            uint32_t domain = bn_domain_child(family, 4u * family + member);
            for (int s = 0; s <= LEVELS; ++s) {
                const int32_t side = 1 << s, across = TILE / side;
                for (int32_t i = 0; i < across * across; ++i) {
                    int32_t x = corner[s][0] + i % across * side,
                            y = corner[s][1] + i / across * side;
                    const int most = i % 37 == 0 ? 12 - 2 * s : 1;
                    for (int k = 0; k <= most && k <= 12 - 2 * s; ++k) {
                        CHECK(block_is_net(&sampler, x, y, s, k < 6 ? k : 6, domain));
                    }
                }
            }
        }
    }
}

/* ---- Nets at sample counts too large to draw, checked by linear algebra over the bits of an index */

enum { BITS = 32 };

/* column[k] is the vector that bit k of an index adds to a sample's four coordinates, mixed with the vectors
 * of lower bits. The mixing does not change the rank of the first k + 1 vectors. */
typedef struct matrices {
    uint32_t column[BITS][4];
} matrices;

static matrices matrices_of(const bn_sampler *s, int32_t x, int32_t y, uint32_t domain) {
    matrices m;
    uint32_t zero[4];
    bn_sample_4d_u32(s, x, y, 0, domain, zero);
    for (uint32_t bit = 0; bit < BITS; ++bit) {
        bn_sample_4d_u32(s, x, y, 1u << bit, domain, m.column[bit]);
        for (int d = 0; d < 4; ++d) m.column[bit][d] ^= zero[d];
    }
    return m;
}

/* Whether the first digits[d] digits of each coordinate d, `bits` in total, are linearly independent
 * functions of the lowest `bits` bits of an index. If so, each box with these numbers of digits contains one
 * of the first 2^bits samples. */
static int is_net(const matrices *m, const int digits[4], int bits) {
    uint32_t rows[BITS]; /* one per column; Gaussian elimination proceeds from the first */
    for (int k = 0; k < bits; ++k) {
        uint64_t packed = 0;
        int at = 0;
        for (int d = 0; d < 4; ++d) {
            if (digits[d] > 0) packed |= (uint64_t)(m->column[k][d] >> (32 - digits[d])) << at;
            at += digits[d];
        }
        rows[k] = (uint32_t)packed;
    }
    for (int k = 0; k < bits; ++k) {
        if (rows[k] == 0) return 0;
        const uint32_t lowest = rows[k] & (0u - rows[k]);
        for (int i = k + 1; i < bits; ++i) {
            if (rows[i] & lowest) rows[i] ^= rows[k];
        }
    }
    return 1;
}

/* Tests all powers of two up to 2^32 in both pairs, and all powers of four in four dimensions. */
static void test_nets_of_all_counts(const bn_sampler *s) {
    for (uint32_t member = 0; member < MEMBERS; ++member) {
        const uint32_t domain = bn_domain_child(5, member);
        for (int pixel = 0; pixel < 3; ++pixel) {
            const matrices m = matrices_of(s, 1000 * pixel, 7 - 77 * pixel, domain);
            int pairs = 0, fours = 0;
            for (int bits = 1; bits <= BITS; ++bits) {
                for (int a = 0; a <= bits; ++a) {
                    pairs += !is_net(&m, (const int[4]){a, bits - a, 0, 0}, bits);
                    pairs += !is_net(&m, (const int[4]){0, 0, a, bits - a}, bits);
                }
            }
            for (int n = 1; n <= BITS / 2; ++n) {
                for (int a = 0; a <= n; ++a) {
                    for (int b = 0; a + b <= n; ++b) {
                        for (int c = 0; a + b + c <= n; ++c) {
                            const int digits[4] = {2 * a, 2 * b, 2 * c, 2 * (n - a - b - c)};
                            fours += !is_net(&m, digits, 2 * n);
                        }
                    }
                }
            }
            CHECK(pairs == 0);
            CHECK(fours == 0);
        }
    }
}

/* The tables match the data file and are available under the symbol names used in bn_draw.h. */
static void test_tables(void) {
    size_t count = 0;
    uint32_t version = 0;
    const uint32_t *words = bn_tables(&count, &version);
    CHECK(words == bn_tables_7 && bn_tables(NULL, NULL) == words);
    CHECK(count == BN_WORD_COUNT && version == BN_DRAW_TABLE_VERSION && version == 7);
    CHECK(count * sizeof *words <= 48u * 1024u && sizeof(bn_sampler) <= 48u);
    FILE *file = fopen(BN_TESTS_DIR "/../libbn/data/blue.u32", "rb");
    CHECK(file != NULL);
    if (file == NULL) return;
    for (size_t i = 0; i < count; ++i) {
        unsigned char b[4] = {0};
        CHECK(fread(b, 1, 4, file) == 4);
        CHECK(words[i] ==
              (b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24));
    }
    CHECK(fgetc(file) == EOF);
    fclose(file);
    for (uint32_t i = 0; i < 256; ++i) {
        CHECK(bn_index_digits_7[i].reversed == bn_reverse_bits(i));
        CHECK(bn_index_digits_7[i].flip == bn_draw_flip(i));
    }
}

int main(void) {
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 3);
    test_nets();
    test_nets_of_all_counts(&s);
    test_tables();
    return check_result();
}
