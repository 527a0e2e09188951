// SPDX-License-Identifier: Apache-2.0
// libpng reads and writes PNG, and libjpeg-turbo reads JPEG.
#include "image.h"

#include <bn/bn.h>
#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>

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

constexpr const char *DAMAGED = "is damaged: it cannot be decoded";

// Makes room for the texels.
void resize(Texture &texture, size_t width, size_t height) {
    if (width > 1 << 20 || height > 1 << 20) throw Error("has more than 2^20 texels in a row");
    texture.width = int(width);
    texture.height = int(height);
    texture.rgba.resize(4 * width * height);
}

// A PNG being read. libpng reports errors by longjmp, so no destructor may be skipped.
struct PngReader {
    const unsigned char *next;
    size_t left;
    std::vector<png_bytep> rows = {};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : nullptr;

    ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
    static void fail(png_structp png, png_const_charp) { png_longjmp(png, 1); }
    static void ignore(png_structp, png_const_charp) {}
    static void read(png_structp png, png_bytep to, size_t count) {
        auto &reader = *static_cast<PngReader *>(png_get_io_ptr(png));
        if (count > reader.left) fail(png, nullptr);
        std::memcpy(to, reader.next, count);
        reader.next += count;
        reader.left -= count;
    }
};

// Returns false if the file is damaged. Ignores gamma and colour profiles, as glTF requires.
bool decode_png(const std::vector<unsigned char> &bytes, Texture &texture) {
    PngReader reader{bytes.data(), bytes.size()};
    const png_structp png = reader.png;
    const png_infop info = reader.info;
    if (!info) throw std::bad_alloc();
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_read_fn(png, &reader, PngReader::read);
    // Accept files with a wrong checksum.
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
    resize(texture, width, height);
    for (size_t y = 0; y < height; ++y) reader.rows.push_back(&texture.rgba[4 * width * y]);
    png_read_image(png, reader.rows.data());
    return true;
}

// If the data end early, the missing texels are grey, and `cut_short` is set.
void decode_jpeg(const std::vector<unsigned char> &bytes, Texture &texture) {
    const std::unique_ptr<void, int (*)(tjhandle)> handle{tjInitDecompress(), tjDestroy};
    int width = 0, height = 0, subsampling = 0, colours = 0;
    if (tjDecompressHeader3(handle.get(), bytes.data(), bytes.size(), &width, &height, &subsampling,
                            &colours) != 0)
        throw Error(DAMAGED);
    if (colours == TJCS_CMYK || colours == TJCS_YCCK)
        throw Error("is a JPEG in CMYK, for print; save it in RGB");
    resize(texture, size_t(width), size_t(height));
    // Each scan of a progressive JPEG goes over the whole image again, even if it has no data.
    if (tjDecompress2(handle.get(), bytes.data(), bytes.size(), texture.rgba.data(), width, 0,
                      height, TJPF_RGBA, TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) == 0)
        return;
    // Viewers also show images with warnings. An error after a warning counts as a warning, but leaves
    // texels unwritten.
    if (tjGetErrorCode(handle.get()) != TJERR_WARNING || texture.rgba.back() != 255)
        throw Error(DAMAGED);
    // libjpeg's message is the only indication.
    texture.cut_short = std::strstr(tjGetErrorStr2(handle.get()), "Premature end of JPEG");
}

// Decodes a byte of sRGB to linear.
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

// Wraps a texel index along one axis; it may be negative or past the side.
int wrapped(int64_t i, int side, Texture::Wrap wrap) {
    if (wrap == Texture::CLAMP) return int(std::clamp<int64_t>(i, 0, side - 1));
    const int64_t period = wrap == Texture::MIRROR ? int64_t{2} * side : side;
    const int64_t rest = (i % period + period) % period;
    return int(rest < side ? rest : period - 1 - rest);
}

glm::vec4 texel(const Texture &t, int64_t x, int64_t y) {
    const auto column = size_t(wrapped(x, t.width, t.wrap_u));
    const auto row = size_t(wrapped(y, t.height, t.wrap_v));
    const uint8_t *p = &t.rgba[4 * (row * size_t(t.width) + column)];
    const std::array<float, 256> &light = srgb_table();
    const glm::vec4 linear = glm::vec4(p[0], p[1], p[2], p[3]) / 255.0f;
    return t.srgb ? glm::vec4(light[p[0]], light[p[1]], light[p[2]], linear.a) : linear;
}

} // namespace

std::string png_encode_preview(const Image &image, float exposure) {
    const float gain = std::exp2(exposure);
    constexpr int MASK = 64; // texels
    const auto *ranks = static_cast<const uint16_t *>(bn_builtin_mask(MASK).ranks);
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

Texture texture_decode(const std::vector<unsigned char> &bytes) {
    const std::string_view data(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    Texture texture;
    if (data.substr(0, 2) == "\xff\xd8")
        decode_jpeg(bytes, texture);
    else if (data.substr(0, 6) != "\x89PNG\r\n")
        throw Error("is not an image that can be read (PNG or JPEG)");
    else if (!decode_png(bytes, texture))
        throw Error(DAMAGED);
    for (size_t i = 3; i < texture.rgba.size() && !texture.has_alpha; i += 4)
        texture.has_alpha = texture.rgba[i] != 255;
    return texture;
}

glm::vec4 texture_at(const Texture &t, Vec2 uv) {
    // Non-finite and huge coordinates map to the corner.
    const auto place = [](float v, int side) {
        return std::abs(v) < 1e6f ? double(v) * side : 0.0;
    };
    const double x = place(uv.x, t.width), y = place(uv.y, t.height);
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
    glm::dvec3 sum(0);
    for (size_t i = 0; i < t.rgba.size(); i += 4)
        for (int c = 0; c < 3; ++c) {
            const uint8_t value = t.rgba[i + size_t(c)];
            sum[c] += t.srgb ? double(srgb_table()[value]) : value / 255.0;
        }
    return sum / double(t.rgba.size() / 4);
}
