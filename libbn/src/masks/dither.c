/* SPDX-License-Identifier: Apache-2.0
 * Ordered dithering by one mask threshold per pixel and channel (Bayer, "An optimum method for
 * two-level rendition of continuous-tone pictures", 1973; with blue-noise masks: Ulichney 1993).
 *
 * Adding a threshold in (0, 1) before rounding down raises a share of the texels by one level: the fraction by
 * which the value exceeds the lower level. Takes a few nanoseconds per value, and with sRGB a fifth root. */
#include "base/assert.h"
#include "base/check.h"
#include "base/float_environment.h"
#include "base/memory.h"
#include "base/options.h"
#include <math.h>

/* Accessed directly, not through bn_builtin_mask(), so that programs that only dither do not link the other
 * masks. */
extern const uint16_t bn_data_mask_64[];

/* A channel's offset into the mask along one axis. The offsets form a low-discrepancy sequence (Roberts,
 * "The unreasonable effectiveness of quasirandom sequences", 2018), so they are far apart on the torus,
 * and distant values of a blue-noise mask are uncorrelated. */
static uint32_t channel_shift(uint32_t channel, uint32_t extent, double step) {
    double at = channel * step;
    return (uint32_t)((at - floor(at)) * extent);
}

/* ((v + 0.055) / 1.055)^2.4 as a square times its fifth root, which Newton's method finds from the
 * fourth root. The C library's pow() differs between systems. */
static double linear_of_srgb(double v) {
    if (v <= 0.04045) return v / 12.92;
    const double base = (v + 0.055) / 1.055, square = base * base;
    double root = sqrt(base);
    for (int i = 0; i < 5; ++i) {
        const double power = root * root;
        root -= (root - square / (power * power)) * 0.2;
    }
    return square * root;
}

typedef struct level_table {
    double steps;       /* levels - 1 */
    double linear[256]; /* linear light at each level, for sRGB */
    int srgb;
} level_table;

/* The level below or above a value, as the threshold decides. Values outside [0, 1] count as its ends. */
static float quantise(const level_table *l, float value, double threshold) {
    double v = value < 0 ? 0 : value > 1 ? 1 : value, scaled = v * l->steps, low = floor(scaled);
    double fraction = scaled - low;
    if (low >= l->steps) return 1;
    BN_ASSERT(fraction >= 0 && fraction < 1 && threshold > 0 && threshold < 1);
    if (l->srgb) {
        /* The fraction of the upper level that preserves the value's linear light. */
        double dark = l->linear[(int)low], light = l->linear[(int)low + 1];
        fraction = (linear_of_srgb(v) - dark) / (light - dark);
    }
    const double up = floor(fraction + threshold);
    BN_ASSERT(up == 0 || up == 1); /* also if rounding puts the fraction just outside [0, 1] */
    return (float)((low + up) / l->steps);
}

static BN_NOINLINE bn_result dither(const bn_dither_options *given, const float *image,
                                    uint32_t width, uint32_t height, uint32_t channels, float *out,
                                    size_t count) {
    bn_dither_options o = bn_dither_options_default();
    bn_result result = bn_options_read(&o, sizeof o, given);
    if (result != BN_SUCCESS) return result;
    if (image == NULL || out == NULL || width == 0 || height == 0 || channels == 0 ||
        o.levels < 2 || o.levels > 256) {
        return BN_ERROR_INVALID_ARGUMENT;
    }
    const uint32_t extents[4] = {width, height, channels, 1};
    uint64_t product;
    if (!bn_product(extents, SIZE_MAX / sizeof *image, &product)) return BN_ERROR_OUT_OF_MEMORY;
    if (count != product) return BN_ERROR_SIZE_MISMATCH;
    const bn_mask built_in = bn_mask_u16(bn_data_mask_64, 64, 64);
    const bn_mask *mask = o.mask != NULL ? o.mask : &built_in;
    result = bn_check_mask(mask);
    if (result != BN_SUCCESS) return result;
    const uint32_t mask_width = mask->width, mask_height = mask->height;
    const size_t texels = (size_t)mask_width * mask_height;
    if (bn_largest_bits(image, count) > BN_INFINITY_BITS) return BN_ERROR_BAD_DATA;
    double *thresholds = bn_allocate(texels, sizeof *thresholds);
    if (thresholds == NULL) return BN_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < texels; ++i) {
        thresholds[i] = (bn_mask_rank(mask, i) + 0.5) / (double)texels;
    }

    level_table l = {.steps = (double)(o.levels - 1), .srgb = o.srgb != 0};
    for (uint32_t i = 0; i < o.levels; ++i) l.linear[i] = linear_of_srgb(i / l.steps);
    for (uint32_t channel = 0; channel < channels; ++channel) {
        uint32_t shift_x = 0, shift_y = 0;
        if (o.channel_offset) {
            /* 1 / p and 1 / p^2, where p is the real root of p^3 = p + 1. */
            shift_x = channel_shift(channel, mask_width, 0.7548776662466927);
            shift_y = channel_shift(channel, mask_height, 0.5698402909980532);
        }
        for (uint32_t y = 0; y < height; ++y) {
            const double *row =
                thresholds + (size_t)(((uint64_t)y + shift_y) % mask_height) * mask_width;
            size_t i = (size_t)y * width * channels + channel;
            for (uint32_t x = 0, at = shift_x; x < width; ++x, i += channels) {
                out[i] = quantise(&l, image[i], row[at]);
                if (++at == mask_width) at = 0;
            }
        }
    }
    bn_free(thresholds);
    return BN_SUCCESS;
}

bn_result bn_dither(const bn_dither_options *options, const float *image, uint32_t width,
                    uint32_t height, uint32_t channels, float *out, size_t count) {
    BN_RETURN_IN_DEFAULT_ENVIRONMENT(dither(options, image, width, height, channels, out, count));
}
