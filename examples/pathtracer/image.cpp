// SPDX-License-Identifier: Apache-2.0
#include "image.h"

#include <bn/bn.h>

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

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

    int size = 0;
    const std::unique_ptr<uint8_t, void (*)(void *)> bytes(
        stbi_write_png_to_mem(pixels.data(), 0, width(image.crop), height(image.crop), 3, &size),
        std::free);
    if (!bytes) throw std::bad_alloc();
    return {reinterpret_cast<const char *>(bytes.get()), size_t(size)};
}

Texture texture_decode(const std::vector<unsigned char> &bytes) {
    // stb_image ignores gamma and colour profiles, as glTF requires. 16 bits keep the rounding correct.
    Texture texture;
    const int size = bytes.size() > INT_MAX ? 0 : int(bytes.size());
    const std::unique_ptr<uint16_t, void (*)(void *)> texels(
        stbi_load_16_from_memory(bytes.data(), size, &texture.width, &texture.height, nullptr, 4),
        stbi_image_free);
    if (!texels) throw Error("is damaged, too large, or neither PNG nor JPEG");
    const size_t count = 4 * size_t(texture.width) * size_t(texture.height);
    texture.rgba.reserve(count);
    for (size_t i = 0; i < count; ++i)
        texture.rgba.push_back(uint8_t((255u * texels.get()[i] + 32767) / 65535));
    for (size_t i = 3; i < count && !texture.has_alpha; i += 4)
        texture.has_alpha = texture.rgba[i] != 255;
    return texture;
}

glm::vec4 texture_at(const Texture &t, Vec2 uv) {
    // Non-finite and huge coordinates map to the top-left corner.
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
