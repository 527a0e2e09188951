// SPDX-License-Identifier: Apache-2.0
// Pictures and textures. Blue noise moves error to high frequencies, where the eye and any later filter
// average it away: to measure what remains, blur the error first, by a separable Gaussian in double.
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

#include "files.h"

namespace {

std::vector<double> gaussian_weights(double sigma) {
    const int radius = static_cast<int>(4 * sigma + 0.5);
    std::vector<double> weights;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
        weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
        sum += weights.back();
    }
    for (double &weight : weights) weight /= sum;
    return weights;
}

// Mirrors an index into 0 .. size - 1, repeating the edge: c b a | a b c | c b a.
int mirror(int i, int size) {
    const int period = 2 * size;
    i = (i % period + period) % period;
    return i < size ? i : period - 1 - i;
}

// Filters `lines` lines of `size` elements. Element i of line j is data[j * line_step + i * step].
void filter_lines(std::vector<double> &data, const std::vector<double> &weights, int size,
                  size_t step, int lines, size_t line_step) {
    const int radius = static_cast<int>(weights.size() / 2);
    std::vector<double> line(static_cast<size_t>(size + 2 * radius));
    for (int j = 0; j < lines; ++j) {
        double *first = &data[static_cast<size_t>(j) * line_step];
        for (int i = -radius; i < size + radius; ++i)
            line[i + radius] = first[static_cast<size_t>(mirror(i, size)) * step];
        for (int i = 0; i < size; ++i) {
            double sum = 0;
            for (size_t k = 0; k < weights.size(); ++k)
                sum += weights[k] * line[static_cast<size_t>(i) + k];
            first[static_cast<size_t>(i) * step] = sum;
        }
    }
}

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

constexpr int MAX_SIDE = 32768;              // texels
constexpr int64_t MAX_TEXELS = 1 << 27;      // 512 MiB decoded
constexpr size_t MAX_FILE = size_t{1} << 30; // bytes
constexpr const char *DAMAGED = "is damaged: it cannot be decoded";

// Throws Error unless a texture may be that large.
void check_extent(int64_t width, int64_t height) {
    if (width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_TEXELS)
        throw Error("has ", width, "x", height, " texels; at most 2^27 are read, 32768 a side");
}

// Whether a file starts with these bytes.
template <size_t N>
bool starts_with(const std::vector<unsigned char> &b, const char (&start)[N]) {
    return b.size() >= N - 1 && std::memcmp(b.data(), start, N - 1) == 0;
}

// Makes room for the texels. Throws Error unless a texture may be that large.
void resize(Texture &texture, int64_t width, int64_t height) {
    check_extent(width, height);
    texture.width = static_cast<int>(width);
    texture.height = static_cast<int>(height);
    texture.rgba.resize(static_cast<size_t>(4 * width * height));
}

// False if it is damaged.
bool decode_png(const std::vector<unsigned char> &bytes, Texture &texture) {
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
    resize(texture, static_cast<int64_t>(width), static_cast<int64_t>(height));
    uint8_t *row = texture.rgba.data();
    for (size_t y = 0; y < height; ++y, row += 4 * width) stream.rows.push_back(row);
    png_read_image(png, stream.rows.data());
    return true;
}

// Data that end early leave texels grey, and set `cut_short`.
void decode_jpeg(const std::vector<unsigned char> &bytes, Texture &texture) {
    const std::unique_ptr<void, int (*)(tjhandle)> handle{tjInitDecompress(), tjDestroy};
    if (!handle) throw std::bad_alloc();
    int width = 0, height = 0, subsampling = 0, colours = 0;
    if (tjDecompressHeader3(handle.get(), bytes.data(), bytes.size(), &width, &height, &subsampling,
                            &colours) != 0)
        throw Error(DAMAGED);
    if (colours == TJCS_CMYK || colours == TJCS_YCCK)
        throw Error("is a JPEG in CMYK, for print; save it in RGB");
    resize(texture, width, height);
    // Each scan of a progressive JPEG goes over the whole image again, even if it has no data.
    const int flags = TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS;
    if (tjDecompress2(handle.get(), bytes.data(), bytes.size(), texture.rgba.data(), width, 0,
                      height, TJPF_RGBA, flags) == 0)
        return;
    // Viewers show what a warning is about, too. An error after a warning counts as one, but leaves
    // texels unwritten.
    if (tjGetErrorCode(handle.get()) != TJERR_WARNING || texture.rgba.back() != 255)
        throw Error(DAMAGED);
    // libjpeg's words, the only sign of it.
    texture.cut_short =
        std::strstr(tjGetErrorStr2(handle.get()), "Premature end of JPEG") != nullptr;
}

// Decodes a byte of sRGB to linear.
const std::array<float, 256> &srgb_table() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t;
        for (size_t i = 0; i < 256; ++i) {
            const float v = static_cast<float>(i) / 255;
            t[i] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
        }
        return t;
    }();
    return table;
}

// Wraps a texel index along one axis; it may be negative or past the side.
int wrapped(int64_t i, int side, Texture::Wrap wrap) {
    if (wrap == Texture::CLAMP) return static_cast<int>(std::clamp<int64_t>(i, 0, side - 1));
    const int64_t period = wrap == Texture::MIRROR ? int64_t{2} * side : side;
    const int64_t rest = (i % period + period) % period;
    return static_cast<int>(rest < side ? rest : period - 1 - rest);
}

glm::vec4 texel(const Texture &t, int64_t x, int64_t y) {
    const auto column = static_cast<size_t>(wrapped(x, t.width, t.wrap_u));
    const auto row = static_cast<size_t>(wrapped(y, t.height, t.wrap_v));
    const uint8_t *p = &t.rgba[4 * (row * static_cast<size_t>(t.width) + column)];
    const std::array<float, 256> &light = srgb_table();
    const glm::vec4 linear = glm::vec4(p[0], p[1], p[2], p[3]) / 255.0f;
    return t.srgb ? glm::vec4(light[p[0]], light[p[1]], light[p[2]], linear.a) : linear;
}

} // namespace

double blurred_rmse(const Image &image, const Image &reference, double sigma) {
    const int columns = width(image.crop), rows = height(image.crop);
    const size_t count = pixel_count(image.crop);
    double total = 0;
    for (int c = 0; c < 3; ++c) {
        std::vector<double> error(count);
        for (size_t i = 0; i < count; ++i) error[i] = double{image.rgb[i][c]} - reference.rgb[i][c];
        if (sigma > 0) {
            const std::vector<double> weights = gaussian_weights(sigma);
            const auto row_length = static_cast<size_t>(columns);
            filter_lines(error, weights, columns, 1, rows, row_length);
            filter_lines(error, weights, rows, row_length, columns, 1);
        }
        for (double e : error) total += e * e;
    }
    return std::sqrt(total / (3 * static_cast<double>(count)));
}

Image image_crop(const Image &image, const Crop &crop) {
    Image result{image.full_width, image.full_height, crop, {}};
    for (int y = crop.y0; y < crop.y1; ++y) {
        const Crop &have = image.crop;
        const size_t first = (y - have.y0) * width(have) + crop.x0 - have.x0;
        const auto from = image.rgb.begin() + static_cast<std::ptrdiff_t>(first);
        result.rgb.insert(result.rgb.end(), from, from + width(crop));
    }
    return result;
}

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

Texture texture_decode(const std::vector<unsigned char> &bytes) {
    if (bytes.empty()) throw Error("is empty");
    if (bytes.size() > MAX_FILE) throw Error("is too large: at most 1 GiB is read");
    Texture texture;
    if (starts_with(bytes, "\x89PNG\r\n\x1a\n")) {
        if (!decode_png(bytes, texture)) throw Error(DAMAGED);
    } else if (starts_with(bytes, "\xff\xd8")) {
        decode_jpeg(bytes, texture);
    } else {
        throw Error("is not an image that can be read (PNG or JPEG)");
    }
    for (size_t i = 3; i < texture.rgba.size() && !texture.has_alpha; i += 4)
        texture.has_alpha = texture.rgba[i] != 255;
    return texture;
}

glm::vec4 texture_at(const Texture &t, Vec2 uv) {
    // Non-finite and huge coordinates map to the corner.
    const auto place = [](float v, int side) {
        return std::abs(v) < 1e6f ? static_cast<double>(v) * side : 0.0;
    };
    const double x = place(uv.x, t.width), y = place(uv.y, t.height);
    if (t.nearest)
        return texel(t, static_cast<int64_t>(std::floor(x)), static_cast<int64_t>(std::floor(y)));
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const auto s = static_cast<float>(x - 0.5 - left), r = static_cast<float>(y - 0.5 - top);
    const auto column = static_cast<int64_t>(left), row = static_cast<int64_t>(top);
    const glm::vec4 a = texel(t, column, row), b = texel(t, column + 1, row);
    const glm::vec4 c = texel(t, column, row + 1), d = texel(t, column + 1, row + 1);
    const float wa = (1 - s) * (1 - r), wb = s * (1 - r), wc = (1 - s) * r, wd = s * r;
    return wa * a + wb * b + wc * c + wd * d;
}

Vec3 texture_mean(const Texture &t) {
    glm::dvec3 sum(0);
    for (size_t i = 0; i < t.rgba.size(); i += 4)
        for (int c = 0; c < 3; ++c) {
            const uint8_t value = t.rgba[i + static_cast<size_t>(c)];
            sum[c] += t.srgb ? static_cast<double>(srgb_table()[value]) : value / 255.0;
        }
    return sum / static_cast<double>(t.rgba.size() / 4);
}
