/* SPDX-License-Identifier: Apache-2.0
 * bn_follow() adds motions exactly, for any number of frames and from any pan. The frames of a film share no index. */
#include <bn/bn_path.h>
#include <string.h>

#include "check.h"

enum { ONE_PIXEL = 1 << 24 };

static bn_pan pan_of(int64_t x, int64_t y) {
    const int64_t half = ONE_PIXEL / 2;
    const uint64_t left = (uint64_t)(x + half), down = (uint64_t)(y + half);
    bn_pan pan = {(uint32_t)(left >> 24), (uint32_t)(down >> 24),
                  (uint32_t)(left % ONE_PIXEL) - ONE_PIXEL / 2,
                  (uint32_t)(down % ONE_PIXEL) - ONE_PIXEL / 2};
    return pan;
}

static int same(bn_pan a, bn_pan b) {
    return memcmp(&a, &b, sizeof a) == 0;
}

/* One step from pan 0: the rounded coordinate. */
static int32_t rounded(float motion) {
    const bn_pan zero = {0, 0, 0, 0};
    const bn_pan pan = bn_follow(zero, motion, -1.0f);
    CHECK(pan.y == UINT32_MAX && pan.y_rest == 0);
    return (int32_t)pan.x;
}

static void known_values(void) {
    static const struct {
        float motion;
        int32_t rounded;
    } cases[] = {{0.0f, 0},
                 {-0.0f, 0},
                 {0.25f, 0},
                 {0.5f, 1},
                 {-0.5f, 0},
                 {-0.75f, -1},
                 {1.5f, 2},
                 {-1.5f, -1},
                 {-1.625f, -2},
                 {1e-30f, 0},
                 {-1e-30f, 0},
                 {0.49999997f, 0},
                 {-0.50000006f, -1},
                 {4095.75f, 4096},
                 {16777215.0f, 16777215},
                 {-16777215.0f, -16777215}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        CHECK(rounded(cases[i].motion) == cases[i].rounded);
}

static void useless_motions_count_as_zero(void) {
    static const uint32_t bits[] = {0x7fc00000u, 0xffc00000u, 0x7f800001u, 0x7f800000u,
                                    0xff800000u, 0x7f7fffffu, 0x4b800000u, 0xcb800000u,
                                    0x00000001u, 0x80000001u};
    const bn_pan before = pan_of(-5 * ONE_PIXEL + 77, 12345);
    for (size_t i = 0; i < sizeof bits / sizeof *bits; ++i) {
        CHECK(same(bn_follow(before, float_of(bits[i]), 0.0f), before));
        CHECK(same(bn_follow(before, 0.0f, float_of(bits[i])), before));
        CHECK(bn_follow(before, float_of(bits[i]), 3.0f).y == before.y + 3u);
    }
}

/* Motions of all sizes, compared with sums in 64-bit integers: long runs do not drift. */
static void sums_are_exact(void) {
    int64_t x = 0, y = 0;
    bn_pan pan = {0, 0, 0, 0};
    uint32_t state = 1;
    for (int i = 0; i < 1000000; ++i) {
        const float dx = float_of((next_random(&state) & 0x80ffffffu) +
                                  ((96u + next_random(&state) % 48u) << 23));
        const float dy = (float)(int32_t)next_random(&state) / (1 << 28);
        const bn_pan before = pan;
        pan = bn_follow(pan, dx, dy);
        x += (int64_t)((double)dx * ONE_PIXEL);
        y += (int64_t)((double)dy * ONE_PIXEL);
        CHECK(same(pan, pan_of(x, y)));
        CHECK(same(bn_follow(pan, -dx, -dy), before));
    }
}

static void pans_wrap(void) {
    const bn_pan last = {UINT32_MAX, INT32_MAX, 0, 0};
    const bn_pan next = bn_follow(last, 2.0f, 2.0f);
    CHECK(next.x == 1u && next.y == 0x80000001u);
}

static void frames_share_no_index(void) {
    static const uint32_t counts[] = {0,     1,           2,           3,           4,
                                      5,     100,         1023,        1024,        1025,
                                      65536, 0x7fffffffu, 0x80000000u, 0x80000001u, UINT32_MAX};
    static const uint32_t frames[] = {
        0, 1, 2, 3, 1000, 4194303, 4194304, 0x7fffffffu, UINT32_MAX - 1};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        const uint32_t most = counts[i];
        uint64_t stride = 1;
        while (stride < most) stride *= 2;
        for (size_t k = 0; k < sizeof frames / sizeof *frames; ++k) {
            const uint64_t first = frames[k] * stride, index = bn_frame_index(frames[k], most);
            CHECK(index == (uint32_t)first);
            CHECK(bn_frame_stream(frames[k], most) == first >> 32);
            CHECK(index + (most ? most : 1) <= UINT64_C(1) << 32);
        }
    }
    CHECK(bn_frame_index(3, 100) == 384 && bn_frame_stream(3, 100) == 0);
    CHECK(bn_frame_index(4194304, 1024) == 0 && bn_frame_stream(4194304, 1024) == 1);
}

int main(void) {
    known_values();
    useless_motions_count_as_zero();
    sums_are_exact();
    pans_wrap();
    frames_share_no_index();
    return check_result();
}
