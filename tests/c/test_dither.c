/* SPDX-License-Identifier: Apache-2.0
 * Dithering: its formula, exact values 0 and 1, independent channels, linear light, invalid input. */
#include "check.h"
#include "masks.h"
#include <math.h>

static double light(double v) {
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

/* Checks every texel of a three-channel image with and without sRGB, out of place and in place. The mask
 * has odd extents. The values cover the whole range, both limits and, densely, the knee of the sRGB curve.
 * The few texels so close to a threshold that rounding may decide are skipped. */
static void test_formula(void) {
    enum { width = 251, height = 97, channels = 3, mask_width = 7, mask_height = 5 };
    enum { texels = mask_width * mask_height, count = width * height * channels };
    static const uint32_t counts[] = {2, 3, 5, 256};
    static float image[count], out[count], copy[count];
    uint32_t mask[texels], state = 9;
    fill_white(mask, texels, 8);
    for (int i = 0; i < count; ++i) {
        const float v = (float)(next_random(&state) >> 8) * 0x1p-24f;
        image[i] = i % 2 == 0 ? v : 0.03f + 0.02f * v;
        if (i % 11 == 0) image[i] = (float)(i % 2);
    }
    for (int c = 0; c < 4 * 2 * 2; ++c) {
        bn_dither_options options = bn_dither_options_default();
        const double steps = (options.levels = counts[c % 4]) - 1.0;
        options.srgb = c / 4 % 2;
        options.channel_offset = c / 8;
        const bn_mask given = bn_mask_u32(mask, mask_width, mask_height);
        options.mask = &given;
        CHECK(bn_dither(&options, image, width, height, channels, out, count) == BN_SUCCESS);
        int wrong = 0, left_out = 0;
        for (int i = 0; i < count; ++i) {
            const int channel = i % channels, x = i / channels % width, y = i / channels / width;
            /* Channel offsets follow the R2 sequence along both axes of the mask. */
            const double along[2] = {channel * 0.7548776662466927, channel * 0.5698402909980532};
            int shift[2] = {0, 0};
            if (options.channel_offset) {
                shift[0] = (int)((along[0] - floor(along[0])) * mask_width);
                shift[1] = (int)((along[1] - floor(along[1])) * mask_height);
            }
            const int at = (y + shift[1]) % mask_height * mask_width + (x + shift[0]) % mask_width;
            const double t = (mask[at] + 0.5) / texels, v = image[i], low = floor(v * steps);
            double share = v * steps - low;
            if (options.srgb) {
                const double dark = light(low / steps), bright = light((low + 1) / steps);
                share = (light(v) - dark) / (bright - dark);
            }
            if (fabs(share + t - 1) < 1e-9) {
                ++left_out;
                continue;
            }
            wrong += out[i] != (float)((low + (share + t >= 1)) / steps);
        }
        CHECK(wrong == 0 && left_out < 20);
        memcpy(copy, image, sizeof copy);
        CHECK(bn_dither(&options, copy, width, height, channels, copy, count) == BN_SUCCESS);
        CHECK(memcmp(copy, out, sizeof copy) == 0);
    }
}

/* With offsets, the dithered channels of a flat colour are uncorrelated. For 4096 independent texels, the
 * standard deviation of their covariance is 0.25 / 64; a limit of six deviations has a false-alarm rate
 * below 1e-8 for each of the 3 pairs. Without offsets, the channels are identical. */
static void test_channels(void) {
    enum { size = 64 };
    static float image[size * size * 3], out[size * size * 3];
    for (int i = 0; i < size * size * 3; ++i) image[i] = 0.5f;
    bn_dither_options options = bn_dither_options_default();
    CHECK(bn_dither(&options, image, size, size, 3, out, size * size * 3) == BN_SUCCESS);
    for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < a; ++b) {
            double both = 0;
            for (int i = 0; i < size * size; ++i) both += out[3 * i + a] * out[3 * i + b];
            CHECK(fabs(both / (size * size) - 0.25) < 6 * 0.25 / 64);
        }
    }
    options.channel_offset = 0;
    CHECK(bn_dither(&options, image, size, size, 3, out, size * size * 3) == BN_SUCCESS);
    for (int i = 0; i < size * size; ++i) CHECK(out[3 * i] == out[3 * i + 2]);
}

/* test_arguments.c tests invalid masks and NaNs. */
static void test_bad_input(void) {
    float image[6] = {0, 0.5f, 1, 2, -1, 0.25f}, out[6] = {7, 7, 7, 7, 7, 7};
    bn_dither_options options = bn_dither_options_default();
    CHECK(bn_dither(NULL, NULL, 3, 2, 1, out, 6) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_dither(NULL, image, 3, 2, 1, NULL, 6) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_dither(NULL, image, 0, 2, 1, out, 0) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_dither(NULL, image, 3, 0, 1, out, 0) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_dither(NULL, image, 3, 2, 0, out, 0) == BN_ERROR_INVALID_ARGUMENT);
    CHECK(bn_dither(NULL, image, 3, 2, 1, out, 5) == BN_ERROR_SIZE_MISMATCH);
    CHECK(bn_dither(NULL, image, UINT32_MAX, UINT32_MAX, UINT32_MAX, out, 6) ==
          BN_ERROR_OUT_OF_MEMORY);
    for (uint32_t levels = 0; levels <= 257; levels += levels == 1 ? 256 : 1) {
        options.levels = levels;
        CHECK(bn_dither(&options, image, 3, 2, 1, out, 6) == BN_ERROR_INVALID_ARGUMENT);
    }
    for (int i = 0; i < 6; ++i) CHECK(out[i] == 7);
    image[2] = INFINITY;
    CHECK(bn_dither(NULL, image, 3, 2, 1, out, 6) == BN_SUCCESS);
    CHECK(out[0] == 0 && out[2] == 1 && out[3] == 1 && out[4] == 0);
}

int main(void) {
    test_formula();
    test_channels();
    test_bad_input();
    return check_result();
}
