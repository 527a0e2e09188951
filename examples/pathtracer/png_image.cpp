// SPDX-License-Identifier: Apache-2.0
// PNG through libpng's simplified interface: previews out, masks in.
#include "png_image.h"

#include <bn/bn.h>
#include <png.h>

#include <cmath>

#include "error.h"
#include "input_file.h"

namespace {

// Linear up to the shoulder, then an exponential that continues its slope and levels off at 1.
float tone_curve(float v) {
    const float shoulder = 0.6f, rest = 1 - shoulder;
    return v < shoulder ? v : 1 - rest * std::exp((shoulder - v) / rest);
}

float srgb_encode(float v) {
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

// A PNG being read. Frees libpng's memory even if an exception ends the read.
struct PngReader {
    png_image png{};
    PngReader() { png.version = PNG_IMAGE_VERSION; }
    PngReader(const PngReader &) = delete;
    PngReader &operator=(const PngReader &) = delete;
    ~PngReader() { png_image_free(&png); }
};

} // namespace

float preview_level(float linear) {
    return 255 * srgb_encode(tone_curve(linear));
}

std::vector<char> png_encode_preview(const Image &image, float exposure) {
    const float gain = std::exp2(exposure);
    constexpr int MASK = 64; // texels
    const uint16_t *ranks = bn_builtin_mask(MASK);
    // Each channel uses a shifted mask, so they do not all round up at the same pixels.
    constexpr int SHIFT_X[3] = {0, 21, 43}, SHIFT_Y[3] = {0, 37, 11};
    std::vector<uint8_t> pixels;
    pixels.reserve(image.rgb.size());
    for (int y = image.crop.y0; y < image.crop.y1; ++y)
        for (int x = image.crop.x0; x < image.crop.x1; ++x)
            for (int c = 0; c < 3; ++c) {
                const float level = preview_level(gain * image.rgb[pixels.size()]);
                const int texel = (y + SHIFT_Y[c]) % MASK * MASK + (x + SHIFT_X[c]) % MASK;
                const float threshold = bn_rank_to_float(ranks[texel], MASK * MASK);
                pixels.push_back(static_cast<uint8_t>(level + threshold));
            }

    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(width(image.crop));
    png.height = static_cast<png_uint_32>(height(image.crop));
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::vector<char> bytes(size);
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels.data(), 0, nullptr))
        throw Error(std::string("the preview cannot be encoded: ") + png.message);
    bytes.resize(size);
    return bytes;
}

GreyImage png_read_grey(const std::string &path) {
    std::vector<unsigned char> bytes;
    try {
        bytes = read_file(path);
    } catch (const Error &error) {
        throw Error("cannot read the PNG file " + path + ": " + error.what());
    }
    PngReader reader;
    png_image &png = reader.png;
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
        throw Error("cannot read the PNG file " + path + ": " + png.message);
    const uint64_t pixels = static_cast<uint64_t>(png.width) * png.height;
    if (pixels > 1u << 24) throw Error("the mask " + path + " is too large: at most 2^24 texels");
    png.format = PNG_FORMAT_LINEAR_Y;
    GreyImage image{png.width, png.height, std::vector<uint16_t>(pixels)};
    if (!png_image_finish_read(&png, nullptr, image.values.data(), 0, nullptr))
        throw Error("cannot read the PNG file " + path + ": " + png.message);
    return image;
}
