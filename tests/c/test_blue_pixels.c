/* SPDX-License-Identifier: Apache-2.0
 * How the pixels and families of BLUE differ: the pixels of a copy of the tile, shifted and reflected,
 * share the order of their samples, copies do not; so each sample by itself is as blue as the first.
 * False-alarm rates are for fresh seeds. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <math.h>

enum { MEMBERS = 4, TILE = 64, ORDERED = 64 };

/* ---- Copies */

enum { SIDE = 192 };

typedef struct pixel_look {
    uint64_t first_16, first_64; /* hashes of the order of these samples */
    uint32_t low[4];             /* the lower 16 digits of sample 0 */
} pixel_look;

static pixel_look look_at(const bn_sampler *s, int32_t x, int32_t y, uint32_t domain) {
    pixel_look look = {0, 0, {0}};
    uint32_t u[4], v[4];
    uint64_t hash = 0;
    bn_sample_4d_u32(s, x, y, 0, domain, u);
    for (int d = 0; d < 4; ++d) look.low[d] = u[d] & 0xffffu;
    for (uint32_t i = 1; i < ORDERED; ++i) {
        bn_sample_4d_u32(s, x, y, i, domain, v);
        /* Relative to sample 0 the pixel's own digits cancel, and what remains is the point. */
        hash = (hash ^ (v[0] ^ u[0])) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
        if (i == 15) look.first_16 = hash;
    }
    look.first_64 = hash;
    return look;
}

/* Six deviations above what is expected, and six more: below 1e-7 by chance. */
static int is_chance(int equal, double expected) {
    return equal <= expected + 6.0 * sqrt(expected) + 6.0;
}

/* Pixels of a copy have one order, and low digits of their own. Over 128 x 128 pixels orders change at
 * two columns and two rows, a tile apart. */
static void test_copy(const bn_sampler *s, uint32_t domain, int32_t x0, int32_t y0) {
    enum { EXTENT = 2 * TILE };
    static pixel_look looks[EXTENT][EXTENT];
    int low = 0, bits[4][16] = {{0}}, column = 0, row = 0;
    for (int32_t i = 0; i < EXTENT * EXTENT; ++i) {
        looks[i / EXTENT][i % EXTENT] = look_at(s, x0 + i % EXTENT, y0 + i / EXTENT, domain);
    }
    for (int i = 1; i < TILE; ++i) {
        if (column == 0 && looks[0][i].first_64 != looks[0][0].first_64) column = i;
        if (row == 0 && looks[i][0].first_64 != looks[0][0].first_64) row = i;
    }
    for (int i = 0; i < EXTENT * EXTENT; ++i) {
        const int x = i % EXTENT, y = i / EXTENT;
        const pixel_look *look = &looks[y][x], *left = &looks[y][x > 0 ? x - 1 : x],
                         *above = &looks[y > 0 ? y - 1 : y][x];
        CHECK((look->first_64 != left->first_64) == (x > 0 && x % TILE == column));
        CHECK((look->first_64 != above->first_64) == (y > 0 && y % TILE == row));
        for (int d = 0; d < 4 && x > 0; ++d) {
            low += look->low[d] == left->low[d];
            for (int bit = 0; bit < 16; ++bit) {
                bits[d][bit] += 1 & (int)((look->low[d] ^ left->low[d]) >> bit);
            }
        }
    }
    const double pairs = (EXTENT - 1) * EXTENT;
    CHECK(is_chance(low, 4.0 * pairs / 65536.0));
    for (int i = 0; i < 4 * 16; ++i) {
        CHECK(fabs(bits[i / 16][i % 16] - 0.5 * pairs) < 6.0 * 0.5 * sqrt(pairs));
    }
}

/* Copies share their order as often as chance has it. */
static void test_copies(const bn_sampler *s, uint32_t domain) {
    static const int steps[][2] = {{1, 0},  {0, 1}, {1, 1},  {1, -1}, {2, 1},
                                   {2, -1}, {1, 2}, {1, -2}, {2, 0},  {0, 2}};
    enum { STEPS = sizeof steps / sizeof *steps };
    static pixel_look looks[SIDE][SIDE];
    for (int32_t i = 0; i < SIDE * SIDE; ++i) {
        const int32_t x = i % SIDE - SIDE / 2, y = i / SIDE - SIDE / 2;
        looks[i / SIDE][i % SIDE] = look_at(s, TILE * x, TILE * y, domain);
    }
    for (int step = 0; step < STEPS; ++step) {
        int orders_16 = 0, orders_64 = 0, pairs = 0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            int x = i % SIDE, y = i / SIDE, x2 = x + steps[step][0], y2 = y + steps[step][1];
            if (x2 >= SIDE || y2 < 0 || y2 >= SIDE) continue;
            ++pairs;
            orders_16 += looks[y][x].first_16 == looks[y2][x2].first_16;
            orders_64 += looks[y][x].first_64 == looks[y2][x2].first_64;
        }
        /* The order of 16 samples is one of 2^9, that of 64 one of 2^20. */
        CHECK(is_chance(orders_16, pairs / 512.0));
        CHECK(is_chance(orders_64, pairs / 1048576.0));
        printf("copies (%d, %d) apart: of %d, %d share the order of 16 samples, %d of 64\n",
               steps[step][0], steps[step][1], pairs, orders_16, orders_64);
    }
}

/* ---- Each sample by itself */

/* The error of one sample a pixel after a blur, over that of white noise: a half-plane, whose
 * indicator has a known mean. */
static double single_error(const bn_sampler *s, uint32_t index, int function) {
    enum { EXTENT = 128, RADIUS = 7, GRID = 256 };
    static double value[EXTENT][EXTENT], rows[EXTENT][EXTENT];
    const double angle = 2.4 * function, c = cos(angle), d = sin(angle);
    const double offset = 0.5 * (c + d) + 0.15 * sin(5.0 * angle);
    const uint32_t domain = bn_domain_child(11, (uint32_t)function);
    double weight[2 * RADIUS + 1], weights = 0.0, squares = 0.0, mean = 0.0, error = 0.0;
    for (int i = -RADIUS; i <= RADIUS; ++i) {
        weight[i + RADIUS] = exp(-0.5 * i * i / (2.1 * 2.1));
        weights += weight[i + RADIUS];
    }
    for (int i = 0; i <= 2 * RADIUS; ++i) {
        weight[i] /= weights;
        squares += weight[i] * weight[i];
    }
    for (int i = 0; i < GRID * GRID; ++i) {
        mean += c * (i % GRID + 0.5) / GRID + d * (i / GRID + 0.5) / GRID < offset;
    }
    mean /= GRID * GRID;
    for (int32_t i = 0; i < EXTENT * EXTENT; ++i) {
        float u[2];
        bn_sample_pair(s, i % EXTENT, i / EXTENT, index, domain, (uint32_t)function / 2u, u);
        value[i / EXTENT][i % EXTENT] = (c * u[0] + d * u[1] < offset) - mean;
    }
    for (int y = 0; y < EXTENT; ++y) {
        for (int x = RADIUS; x < EXTENT - RADIUS; ++x) {
            rows[y][x] = 0.0;
            for (int i = -RADIUS; i <= RADIUS; ++i) {
                rows[y][x] += weight[i + RADIUS] * value[y][x + i];
            }
        }
    }
    for (int y = RADIUS; y < EXTENT - RADIUS; ++y) {
        for (int x = RADIUS; x < EXTENT - RADIUS; ++x) {
            double sum = 0.0;
            for (int i = -RADIUS; i <= RADIUS; ++i) sum += weight[i + RADIUS] * rows[y + i][x];
            error += sum * sum;
        }
    }
    error /= pow(EXTENT - 2 * RADIUS, 2.0);
    return error / (mean * (1.0 - mean) * squares * squares);
}

/* In the middle of an octave a sample is as blue as the first, over copies with different orders
 * too. With an order of its own in each pixel it would be white. */
static void test_single_samples(const bn_sampler *s) {
    static const uint32_t indices[] = {0, 1, 2, 3, 5, 6, 11, 23, 47, 100, 200, 255};
    enum { FUNCTIONS = 12 };
    for (size_t i = 0; i < sizeof indices / sizeof *indices; ++i) {
        double square = 0.0;
        for (int f = 0; f < FUNCTIONS; ++f) square += single_error(s, indices[i], f) / FUNCTIONS;
        printf("sample %u alone: %.3f of white noise after a blur\n", indices[i], sqrt(square));
        CHECK(sqrt(square) < 0.65);
    }
}

/* ---- The tile */

/* The upper 16 digits of the four coordinates of a place of the tile, from the lowest bits up. */
static uint64_t tile[MEMBERS][TILE * TILE];

static void read_tile(const uint32_t *words) {
    for (uint32_t i = 0; i < MEMBERS * TILE * TILE; ++i) {
        uint32_t member = i / (TILE * TILE), row = i / TILE % TILE, column = i % TILE;
        uint32_t place = words[BN_PIXELS_AT + row * TILE + column] >> 8 * member & 15u;
        const uint32_t *places = words + BN_PLACES_AT + (member * 16u + place) * 2u;
        const uint32_t *blocks =
            words + BN_BLOCKS_AT + ((row / 4u * 16u + column / 4u) * MEMBERS + member) * 2u;
        tile[member][row * TILE + column] =
            (places[0] ^ blocks[0]) | (uint64_t)(places[1] ^ blocks[1]) << 32;
    }
}

/* Over the 4,096 labels the first three digits of the four coordinates are each of 8^4 cells once. */
static void test_cells(void) {
    read_tile(bn_tables(NULL, NULL));
    for (int member = 0; member < MEMBERS; ++member) {
        unsigned char seen[TILE * TILE] = {0};
        for (int at = 0; at < TILE * TILE; ++at) {
            const uint64_t v = tile[member][at];
            const uint32_t cell = (uint32_t)(v >> 13 & 7u) | (uint32_t)(v >> 29 & 7u) << 3 |
                                  (uint32_t)(v >> 45 & 7u) << 6 | (uint32_t)(v >> 61) << 9;
            CHECK(seen[cell]++ == 0);
        }
    }
}

int main(void) {
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 21);
    for (int32_t i = 0; i < 4; ++i) {
        test_copy(&s, bn_domain_child(4, (uint32_t)i), 77 * i - 200, 777 * i * i - 1000);
    }
    test_copies(&s, BN_DOMAIN_ROOT);
    test_copies(&s, bn_domain_child(3, 6));
    test_single_samples(&s);
    test_cells();
    return check_result();
}
