// SPDX-License-Identifier: Apache-2.0
// The tone curve and dithering of previews, PNG and JPEG files through libpng and libjpeg, and bilinear
// lookups.
#include "image.h"

#include <bn/bn.h>

// In this order: jpeglib.h uses FILE and size_t.
#include <cstdio>
#include <jpeglib.h>

#include <jerror.h>
#include <png.h>

#include <array>
#include <cstring>
#include <new>
#include <set>

#include "files.h"

namespace {

// Linear up to the shoulder, then an exponential that continues its slope and levels off at 1.
float tone_curve(float v) {
    const float shoulder = 0.6f, rest = 1 - shoulder;
    return v < shoulder ? v : 1 - rest * std::exp((shoulder - v) / rest);
}

float srgb_encode(float v) {
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

// Decodes an sRGB byte to linear light.
const std::array<float, 256> &srgb_table() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t;
        for (size_t i = 0; i < 256; ++i) {
            const float v = float(i) / 255;
            t[i] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
        }
        return t;
    }();
    return table;
}

// Wraps a texel index along one axis; it may be negative or exceed the side.
int wrapped(int64_t i, int side, Texture::Wrap wrap) {
    if (wrap == Texture::CLAMP) return int(std::clamp<int64_t>(i, 0, side - 1));
    const int64_t period = wrap == Texture::MIRROR ? int64_t{2} * side : side;
    const int64_t rest = (i % period + period) % period;
    return int(rest < side ? rest : period - 1 - rest);
}

glm::vec4 texel(const Texture &t, int64_t x, int64_t y) {
    const Texels &texels = *t.texels;
    const auto column = size_t(wrapped(x, texels.width, t.wrap_u));
    const auto row = size_t(wrapped(y, texels.height, t.wrap_v));
    const uint8_t *p = &texels.rgba[4 * (row * size_t(texels.width) + column)];
    const std::array<float, 256> &light = srgb_table();
    const glm::vec4 linear = glm::vec4(p[0], p[1], p[2], p[3]) / 255.0f;
    return t.srgb ? glm::vec4(light[p[0]], light[p[1]], light[p[2]], linear.a) : linear;
}

// ---- Decoding. Errors are thrown through the libraries.

using Bytes = std::vector<unsigned char>;

Texels texels_of(uint32_t width, uint32_t height) {
    return {int(width), int(height), false, std::vector<uint8_t>(size_t{4} * width * height)};
}

struct Jpeg : jpeg_decompress_struct {
    jpeg_error_mgr errors;
    ~Jpeg() { jpeg_destroy_decompress(this); }
};

[[noreturn]] void jpeg_fail(j_common_ptr info) {
    if (info->err->msg_code == JERR_OUT_OF_MEMORY) throw std::bad_alloc();
    char message[JMSG_LENGTH_MAX];
    info->err->format_message(info, message);
    throw Error("is damaged or not supported: ", message);
}

// Data that is missing or wrong is an error; stray bytes between segments are not. If only the end marker
// is missing, a file with a single scan is still complete.
void jpeg_warn(j_common_ptr info, int level) {
    const auto &jpeg = *reinterpret_cast<j_decompress_ptr>(info);
    const bool one_scan = !jpeg.progressive_mode && jpeg.comps_in_scan == jpeg.num_components;
    std::set<int> errors = {JWRN_HIT_MARKER, JWRN_HUFF_BAD_CODE, JWRN_ARITH_BAD_CODE,
                            JWRN_MUST_RESYNC};
    if (!one_scan) errors.insert(JWRN_JPEG_EOF);
    if (level < 0 && errors.count(info->err->msg_code) > 0) jpeg_fail(info);
}

Texels jpeg_decode(const Bytes &bytes) {
    Jpeg jpeg{};
    jpeg.err = jpeg_std_error(&jpeg.errors);
    jpeg.errors.error_exit = jpeg_fail;
    jpeg.errors.emit_message = jpeg_warn;
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
    jpeg_read_header(&jpeg, TRUE);
    const bool cmyk = jpeg.num_components == 4; // inverted, as all programs write it
    jpeg.out_color_space = cmyk ? JCS_CMYK : JCS_EXT_RGBA;
    Texels texels = texels_of(jpeg.image_width, jpeg.image_height);
    jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < jpeg.output_height) {
        JSAMPROW row = &texels.rgba[size_t{4} * jpeg.output_width * jpeg.output_scanline];
        jpeg_read_scanlines(&jpeg, &row, 1);
    }
    for (size_t i = 0; i < texels.rgba.size() && cmyk; ++i)
        texels.rgba[i] =
            uint8_t(i % 4 == 3 ? 255 : (texels.rgba[i] * texels.rgba[i | 3] + 127) / 255);
    return texels;
}

struct Png {
    const unsigned char *at, *end;
    png_structp png;
    png_infop info = png_create_info_struct(png);
    ~Png() { png_destroy_read_struct(&png, &info, nullptr); }
};

void png_fail(png_structp, png_const_charp message) {
    throw Error("is damaged or not supported: ", message);
}

void png_take(png_structp png, png_bytep to, size_t size) {
    Png &from = *static_cast<Png *>(png_get_io_ptr(png));
    if (size > size_t(from.end - from.at)) throw Error("is damaged: it is cut short");
    std::memcpy(to, from.at, size);
    from.at += size;
}

Texels png_decode(const Bytes &bytes) {
    Png file = {bytes.data(), bytes.data() + bytes.size(),
                png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, png_fail,
                                       [](png_structp, png_const_charp) {})};
    const png_structp png = file.png;
    png_set_read_fn(png, &file, png_take);
    png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
    png_read_info(png, file.info);
    png_set_expand(png);   // palettes, fewer than 8 bits, transparent colours
    png_set_scale_16(png); // rounds to 8 bits
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    const int passes = png_set_interlace_handling(png);
    const png_uint_32 width = png_get_image_width(png, file.info);
    Texels texels = texels_of(width, png_get_image_height(png, file.info));
    png_read_update_info(png, file.info);
    for (int pass = 0; pass < passes; ++pass)
        for (size_t row = 0; row < texels.rgba.size(); row += size_t{4} * width)
            png_read_row(png, &texels.rgba[row], nullptr);
    png_read_end(png, nullptr);
    return texels;
}

} // namespace

std::string png_encode_preview(const Image &image, float exposure) {
    const float gain = std::exp2(exposure);
    constexpr int MASK = 64; // texels
    const auto *ranks = static_cast<const uint16_t *>(bn_builtin_mask(MASK).ranks);
    // Each channel uses a shifted mask, so that they do not all round up at the same pixels.
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

    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    png.format = PNG_FORMAT_RGB;
    png.width = uint32_t(width(image.crop));
    png.height = uint32_t(height(image.crop));
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string file(size, 0);
    if (!png_image_write_to_memory(&png, file.data(), &size, 0, pixels.data(), 0, nullptr))
        throw Error("cannot encode the preview: ", png.message);
    file.resize(size);
    return file;
}

Texels image_decode(const Bytes &bytes) {
    const bool png = bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
    if (!png && (bytes.size() < 2 || bytes[0] != 0xFF || bytes[1] != 0xD8))
        throw Error("is neither PNG nor JPEG");
    Texels texels = png ? png_decode(bytes) : jpeg_decode(bytes);
    for (size_t i = 3; i < texels.rgba.size() && !texels.has_alpha; i += 4)
        texels.has_alpha = texels.rgba[i] != 255;
    return texels;
}

glm::vec4 texture_at(const Texture &t, Vec2 uv) {
    // Non-finite and huge coordinates map to the top-left corner.
    const auto place = [](float v, int side) {
        return std::abs(v) < 1e6f ? double(v) * side : 0.0;
    };
    const double x = place(uv.x, t.texels->width), y = place(uv.y, t.texels->height);
    if (t.nearest) return texel(t, int64_t(std::floor(x)), int64_t(std::floor(y)));
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const auto s = float(x - 0.5 - left), r = float(y - 0.5 - top);
    const auto column = int64_t(left), row = int64_t(top);
    const glm::vec4 a = texel(t, column, row), b = texel(t, column + 1, row);
    const glm::vec4 c = texel(t, column, row + 1), d = texel(t, column + 1, row + 1);
    const float wa = (1 - s) * (1 - r), wb = s * (1 - r), wc = (1 - s) * r, wd = s * r;
    return wa * a + wb * b + wc * c + wd * d;
}

Vec3 texture_mean(const Texture &t) {
    const int width = t.texels->width, height = t.texels->height;
    glm::dvec3 sum(0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) sum += glm::dvec3(texel(t, x, y));
    return sum / (double(width) * height);
}
