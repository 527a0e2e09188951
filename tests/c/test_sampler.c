/* SPDX-License-Identifier: Apache-2.0
 * Samplers: initialisation, ranges, agreement of all draw functions, nets. tests/quality measures how blue
 * and how independent the samples are. */
#include "check.h"
#include "samplers.h"
#include <bn/bn_draw.h>
#include <string.h>

static uint32_t points[MOST_POINTS][4];

static uint32_t random_state = 1;

static int equal(const bn_sampler *a, const bn_sampler *b) {
    uint32_t u[4], v[4];
    bn_sample_4d_u32(a, 1, 2, 3, 4, u);
    bn_sample_4d_u32(b, 1, 2, 3, 4, v);
    return memcmp(u, v, sizeof u) == 0;
}

/* A failed initialisation leaves the sampler unchanged. */
static void test_initialisation(void) {
    bn_sampler sampler = bn_sampler_make(99);
    const bn_sampler before = sampler, blue = bn_sampler_make(5);
    const bn_result invalid = BN_ERROR_INVALID_ARGUMENT;
    uint32_t ranks[6] = {3, 1, 0, 5, 4, 2};
    uint16_t narrow[6] = {3, 1, 0, 5, 4, 2};
    const bn_mask mask = bn_mask_u32(ranks, 3, 2), other = bn_mask_u16(narrow, 3, 2);
    for (int32_t type = -3; type < 9; ++type) {
        if (type < 0 || type >= TYPES) CHECK(bn_sampler_init(&sampler, type, 5) == invalid);
    }
    CHECK(bn_sampler_init_mask(&sampler, NULL, 0) == invalid);
    ranks[0] = 6; /* test_arguments.c tests other invalid masks */
    CHECK(bn_sampler_init_mask(&sampler, &mask, 0) == BN_ERROR_BAD_DATA);
    ranks[0] = 3;
    CHECK(memcmp(&sampler, &before, sizeof sampler) == 0);
    CHECK(bn_sampler_init(NULL, BN_SAMPLER_BLUE, 0) == invalid);
    CHECK(bn_sampler_init_zorder(NULL, 4, 0) == invalid);
    CHECK(bn_sampler_init_mask(NULL, &mask, 0) == invalid);

    CHECK(bn_sampler_init(&sampler, BN_SAMPLER_BLUE, 5) == BN_SUCCESS && equal(&sampler, &blue));
    CHECK(bn_sampler_init(&sampler, BN_SAMPLER_SOBOL, 5) == BN_SUCCESS && !equal(&sampler, &blue));
    bn_sampler zorder = make_sampler(BN_SAMPLER_ZORDER, 16, 5);
    CHECK(bn_sampler_init(&sampler, BN_SAMPLER_ZORDER, 5) == BN_SUCCESS);
    CHECK(!equal(&sampler, &zorder));
    zorder = make_sampler(BN_SAMPLER_ZORDER, 255, 5);
    CHECK(equal(&sampler, &zorder));

    /* 16-bit ranks give the same draws as 32-bit ranks. */
    bn_sampler wide;
    CHECK(bn_sampler_init_mask(&wide, &mask, 5) == BN_SUCCESS);
    CHECK(bn_sampler_init_mask(&sampler, &other, 5) == BN_SUCCESS && equal(&sampler, &wide));
    const bn_mask built_in = bn_builtin_mask(64);
    CHECK(bn_sampler_init_mask(&wide, &built_in, 5) == BN_SUCCESS);
    CHECK(bn_sampler_init(&sampler, BN_SAMPLER_MASK, 5) == BN_SUCCESS && equal(&sampler, &wide));
}

/* All draw functions return the same numbers at ordinary and extreme arguments. test_draw_hashes.c tests the
 * bits of the inline functions. */
static void test_draw_functions(void) {
    static const int32_t coordinates[] = {0, 1, -1, 127, 128, 4095, 4096, INT32_MAX, INT32_MIN};
    static const uint32_t indices[] = {0, 1, 2, 255, 256, 257, 65535, 65536, 1u << 31, UINT32_MAX};
    enum { NC = sizeof coordinates / sizeof *coordinates, NI = sizeof indices / sizeof *indices };
    for (int32_t type = 0; type < TYPES; ++type) {
        const bn_sampler s = make_sampler(type, type == BN_SAMPLER_ZORDER ? 16 : 0, 5);
        for (int i = 0; i < NC * NC * NI; ++i) {
            int32_t x = coordinates[i % NC], y = coordinates[i / NC % NC];
            uint32_t index = indices[i / NC / NC], domain = bn_domain_child(7, (uint32_t)i);
            uint32_t bits[4];
            float four[4], two[2], inline_four[4];
            bn_sample_4d_u32(&s, x, y, index, domain, bits);
            bn_sample_4d(&s, x, y, index, domain, four);
            bn_draw_4d(&s, x, y, index, domain, inline_four);
            CHECK(memcmp(four, inline_four, sizeof four) == 0);
            for (int d = 0; d < 4; ++d) {
                CHECK(four[d] == (float)(bits[d] >> 8) * 0x1p-24f);
                CHECK(four[d] >= 0.0f && four[d] < 1.0f);
            }
            CHECK(bn_sample_1d(&s, x, y, index, domain) == four[0]);
            CHECK(bn_draw_1d(&s, x, y, index, domain) == four[0]);
            /* Only the lowest bit of `pair` is used. */
            for (uint32_t pair = 0; pair < 4u; ++pair) {
                bn_sample_2d(&s, x, y, index, domain, pair, two);
                CHECK(memcmp(two, four + 2u * (pair & 1u), sizeof two) == 0);
                bn_draw_2d(&s, x, y, index, domain, pair, two);
                CHECK(memcmp(two, four + 2u * (pair & 1u), sizeof two) == 0);
            }
        }
    }
}

/* tests/simd/many_equals_single.c tests the bits of blocks. */
static void test_block_arguments(void) {
    enum { W = 37, H = 11, N = 7, COUNT = W * H * N * 4 };
    static float out[COUNT];
    const bn_sampler s = make_sampler(BN_SAMPLER_BLUE, 0, 0);
    const bn_result invalid = BN_ERROR_INVALID_ARGUMENT, mismatch = BN_ERROR_SIZE_MISMATCH;
    CHECK(bn_sample_block(NULL, 0, 0, W, H, 0, N, 0, out, COUNT) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, W, H, 0, N, 0, NULL, COUNT) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, 0, H, 0, N, 0, out, 0) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, W, 0, 0, N, 0, out, 0) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, W, H, 0, 0, 0, out, 0) == invalid);
    CHECK(bn_sample_block(&s, INT32_MAX - W + 2, 0, W, H, 0, N, 0, out, COUNT) == invalid);
    CHECK(bn_sample_block(&s, 0, INT32_MAX - H + 2, W, H, 0, N, 0, out, COUNT) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, W, H, UINT32_MAX - N + 2, N, 0, out, COUNT) == invalid);
    CHECK(bn_sample_block(&s, 0, 0, W, H, 0, N, 0, out, COUNT - 1) == mismatch);
    CHECK(bn_sample_block(&s, 0, 0, W, H, 0, N, 0, out, COUNT + 4) == mismatch);
    /* The product of these extents overflows to the count that is passed. */
    CHECK(bn_sample_block(&s, INT32_MIN, INT32_MIN, 1u << 31, 1u << 31, 0, 4, 0, out, 0) ==
          mismatch);
}

/* Every power-of-two prefix of a pixel's samples, and every later aligned block of this length, is a
 * (0,m,2)-net in both pairs. test_pole_order.c tests BLUE's nets in four dimensions. */
static void test_nets(void) {
    static const int32_t types[] = {BN_SAMPLER_BLUE, BN_SAMPLER_SOBOL, BN_SAMPLER_ZORDER,
                                    BN_SAMPLER_MASK};
    for (int k = 0; k < 4; ++k) {
        const bn_sampler s = make_sampler(types[k], 64, 3);
        for (int pixel = 0; pixel < 24; ++pixel) {
            int32_t x = (int32_t)next_random(&random_state),
                    y = (int32_t)next_random(&random_state);
            uint32_t domain = next_random(&random_state);
            for (int m = 0; m <= 12; ++m) {
                for (uint32_t block = 0; block <= 5; block += 5) {
                    draw_points(points, &s, x, y, 0, m, block << m, domain);
                    CHECK(are_nets_in_pairs(points, m));
                }
            }
        }
    }
}

/* Tests ZORDER at its largest sample count, to which larger counts are clamped. If an aligned square of
 * pixels has n samples, each of n intervals contains one of them. */
static void test_largest_zorder_count(void) {
    enum { COUNT = 1 << 16, POINTS = 4 * COUNT };
    static unsigned char seen[POINTS];
    const bn_sampler s = make_sampler(BN_SAMPLER_ZORDER, COUNT, 3);
    const bn_sampler above = make_sampler(BN_SAMPLER_ZORDER, UINT32_MAX, 3);
    CHECK(equal(&s, &above));
    int repeats = 0;
    for (uint32_t i = 0; i < POINTS; ++i) {
        uint32_t u[4];
        bn_sample_4d_u32(&s, (int32_t)(i & 1), (int32_t)(i >> 1 & 1), i >> 2, 5, u);
        repeats += seen[u[0] >> 14]++;
    }
    CHECK(repeats == 0);
}

/* With ZORDER, the samples of all pixels in an aligned square form a net in all four dimensions, because
 * both pairs follow the same curve. */
static void test_nets_of_zorder_squares(void) {
    for (int log4_side = 0; log4_side <= 3; ++log4_side) {
        for (int log4_block = 0; log4_block <= 3; ++log4_block) {
            const uint32_t align = ~((1u << log4_side) - 1u);
            const bn_sampler s = make_sampler(BN_SAMPLER_ZORDER, 1u << 2 * log4_block, 12);
            for (uint32_t square = 0; square < 12; ++square) {
                const int32_t x = (int32_t)(next_random(&random_state) & align);
                const int32_t y = (int32_t)(next_random(&random_state) & align);
                draw_points(points, &s, x, y, log4_side, 2 * log4_block, 0,
                            next_random(&random_state));
                CHECK(are_net_in_four(points, log4_side + log4_block));
            }
        }
    }
}

/* At index 0, MASK returns the mask, shifted differently for each domain and dimension. */
static void test_mask_values(void) {
    enum { W = 6, H = 4, COUNT = W * H };
    uint32_t ranks[COUNT], u[COUNT][4];
    for (uint32_t i = 0; i < COUNT; ++i) ranks[i] = i * 7u % COUNT;
    const bn_mask mask = bn_mask_u32(ranks, W, H);
    bn_sampler s;
    CHECK(bn_sampler_init_mask(&s, &mask, 0) == BN_SUCCESS);
    for (uint32_t domain = 0; domain < 20; ++domain) {
        int shifts[4] = {0};
        for (int i = 0; i < COUNT; ++i)
            bn_sample_4d_u32(&s, -3 + i % W, 5 + i / W, 0, domain, u[i]);
        for (int k = 0; k < 4 * COUNT; ++k) {
            const int d = k % 4, shift = k / 4;
            int equal = 0;
            for (int i = 0; i < COUNT; ++i) {
                const int x = (i % W + shift % W) % W, y = (i / W + shift / W) % H;
                const uint64_t twice = (uint64_t)ranks[y * W + x] * 2 + 1;
                /* Five digits distinguish 24 values; the lower digits are random. */
                equal += (uint32_t)((twice << 31) / COUNT) >> 27 == u[i][d] >> 27;
            }
            shifts[d] += equal == COUNT;
        }
        for (int d = 0; d < 4; ++d) CHECK(shifts[d] == 1);
    }
}

enum { ORDERED = 16 };

/* How many of the points are at different indices in two orders of the same points; -1 for other points. */
static int moved_points(const uint64_t one[ORDERED], const uint64_t other[ORDERED]) {
    int found = 0, moved = 0;
    for (int i = 0; i < ORDERED * ORDERED; ++i) {
        const int equal = one[i / ORDERED] == other[i % ORDERED];
        found += equal;
        moved += equal && i / ORDERED != i % ORDERED;
    }
    return found == ORDERED ? moved : -1;
}

/* Rank scrambling: MASK takes the same 16 points in all pixels and pairs, up to a digital shift, but in
 * different orders. There are eight orders, so two agree with a probability of 1 / 8. */
static void test_mask_orders(void) {
    enum { PIXELS = 64 };
    static uint64_t points_of[PIXELS][2][ORDERED];
    const bn_sampler s = make_sampler(BN_SAMPLER_MASK, 0, 3);
    int next_pixel = 0, other_pair = 0;
    for (int x = 0; x < PIXELS; ++x) {
        for (int i = 0; i < ORDERED; ++i) {
            uint32_t u[4], zero[4];
            bn_sample_4d_u32(&s, x, 7, (uint32_t)i, 5, u);
            bn_sample_4d_u32(&s, x, 7, 0, 5, zero);
            for (int d = 0; d < 4; ++d) u[d] ^= zero[d];
            points_of[x][0][i] = (uint64_t)u[0] << 32 | u[1];
            points_of[x][1][i] = (uint64_t)u[2] << 32 | u[3];
        }
        for (int pair = 0; x > 0 && pair < 2; ++pair) {
            const int moved = moved_points(points_of[x][pair], points_of[x - 1][pair]);
            CHECK(moved >= 0);
            next_pixel += moved > 0;
        }
        const int moved = moved_points(points_of[x][0], points_of[x][1]);
        CHECK(moved >= 0);
        other_pair += moved > 0;
    }
    CHECK(next_pixel > 2 * PIXELS * 3 / 4);
    CHECK(other_pair > PIXELS * 3 / 4);
}

int main(void) {
    test_mask_values();
    test_mask_orders();
    test_initialisation();
    test_draw_functions();
    test_block_arguments();
    test_nets();
    test_nets_of_zorder_squares();
    test_largest_zorder_count();
    return check_result();
}
