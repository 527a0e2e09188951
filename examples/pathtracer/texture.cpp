// SPDX-License-Identifier: Apache-2.0
// libpng decodes PNG, and libjpeg-turbo JPEG.
#include "texture.h"

#include <turbojpeg.h>

#include <array>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#include "error.h"
#include "image.h"

namespace {

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

Texture texture_decode(const std::vector<unsigned char> &bytes) {
    if (bytes.empty()) throw Error("is empty");
    if (bytes.size() > MAX_FILE) throw Error("is too large: at most 1 GiB is read");
    Texture texture;
    if (starts_with(bytes, "\x89PNG\r\n\x1a\n")) {
        const auto make_room = [&](int64_t width, int64_t height) {
            resize(texture, width, height);
            return texture.rgba.data();
        };
        if (!png_decode_rgba(bytes, make_room)) throw Error(DAMAGED);
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
