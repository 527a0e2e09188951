// SPDX-License-Identifier: Apache-2.0
// PNG through libpng: previews out, masks and textures in.
#include "image.h"

#include <bn/bn.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <new>

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

// A PNG being read through libpng's low-level interface. Its errors jump: nothing on their way may
// need a destructor.
struct PngStream {
    png_structp png;
    png_infop info = nullptr;
    const unsigned char *next;
    size_t left;
    std::vector<png_bytep> rows = {};

    explicit PngStream(const std::vector<unsigned char> &bytes)
        : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore)),
          next(bytes.data()), left(bytes.size()) {
        if (!png) return;
        info = png_create_info_struct(png);
        png_set_read_fn(png, this, read);
    }
    ~PngStream() { png_destroy_read_struct(&png, &info, nullptr); }

  private:
    static void fail(png_structp png, png_const_charp) { png_longjmp(png, 1); }
    static void ignore(png_structp, png_const_charp) {}
    static void read(png_structp png, png_bytep to, size_t count) {
        auto &stream = *static_cast<PngStream *>(png_get_io_ptr(png));
        if (count > stream.left) fail(png, nullptr);
        std::memcpy(to, stream.next, count);
        stream.next += count;
        stream.left -= count;
    }
};

} // namespace

std::string png_encode_preview(const Image &image, float exposure) {
    const float gain = std::exp2(exposure);
    constexpr int MASK = 64; // texels
    const uint16_t *ranks = bn_builtin_mask(MASK);
    // Each channel uses a shifted mask, so they do not all round up at the same pixels.
    constexpr int SHIFT_X[3] = {0, 21, 43}, SHIFT_Y[3] = {0, 37, 11};
    std::vector<uint8_t> pixels;
    for (int y = image.crop.y0; y < image.crop.y1; ++y)
        for (int x = image.crop.x0; x < image.crop.x1; ++x)
            for (int c = 0; c < 3; ++c) {
                const float level =
                    255 * srgb_encode(tone_curve(gain * image.rgb[pixels.size() / 3][c]));
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
    std::string bytes(size, '\0');
    if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels.data(), 0, nullptr))
        throw Error("the preview cannot be encoded: ", png.message);
    bytes.resize(size);
    return bytes;
}

GreyImage png_read_grey(const std::string &path) {
    std::vector<unsigned char> bytes;
    try {
        bytes = read_file(path);
    } catch (const Error &error) {
        throw Error("cannot read the PNG file ", path, ": ", error.what());
    }
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    const std::unique_ptr<png_image, void (*)(png_image *)> freed{&png, png_image_free};
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
        throw Error("cannot read the PNG file ", path, ": ", png.message);
    const uint64_t pixels = static_cast<uint64_t>(png.width) * png.height;
    if (pixels > 1u << 24) throw Error("the mask ", path, " is too large: at most 2^24 texels");
    png.format = PNG_FORMAT_LINEAR_Y;
    GreyImage image{png.width, png.height, std::vector<uint16_t>(pixels)};
    if (!png_image_finish_read(&png, nullptr, image.values.data(), 0, nullptr))
        throw Error("cannot read the PNG file ", path, ": ", png.message);
    return image;
}

bool png_decode_rgba(const std::vector<unsigned char> &bytes,
                     const std::function<uint8_t *(int64_t, int64_t)> &make_room) {
    PngStream stream(bytes);
    const png_structp png = stream.png;
    const png_infop info = stream.info;
    if (!info) throw std::bad_alloc();
    if (setjmp(png_jmpbuf(png))) return false;
    // A wrong checksum is no reason to refuse a file. glTF asks to ignore gamma and colour profiles.
    png_set_crc_action(png, PNG_CRC_QUIET_USE, PNG_CRC_QUIET_USE);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png, info);
    png_set_expand(png); // palettes, fewer than 8 bits, a transparent colour
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    const size_t width = png_get_image_width(png, info), height = png_get_image_height(png, info);
    if (png_get_rowbytes(png, info) != 4 * width) return false;
    uint8_t *row = make_room(static_cast<int64_t>(width), static_cast<int64_t>(height));
    for (size_t y = 0; y < height; ++y, row += 4 * width) stream.rows.push_back(row);
    png_read_image(png, stream.rows.data());
    return true;
}
