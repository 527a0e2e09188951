// SPDX-License-Identifier: Apache-2.0
// Images: linear RGB, whole or cropped; PNG; textures with 8 bits per channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "math.h"

// The pixels x0 <= x < x1, y0 <= y < y1 of an image; y grows downwards.
struct Crop {
    int x0, y0, x1, y1;
};

inline int width(const Crop &crop) {
    return crop.x1 - crop.x0;
}
inline int height(const Crop &crop) {
    return crop.y1 - crop.y0;
}
inline size_t pixel_count(const Crop &crop) {
    return size_t(width(crop)) * size_t(height(crop));
}

struct Window {
    int full_width = 0, full_height = 0; // whole image
    Crop crop = {};                      // the pixels held
};

struct Image : Window {
    std::vector<Vec3> rgb; // height(crop) rows of width(crop) pixels
};

// Encodes an 8-bit sRGB preview as a PNG file: applies the exposure in stops, a tone curve that
// keeps middle greys and rolls off highlights, and dithering with one of libbn's blue-noise masks,
// so that smooth gradients show no bands. Throws Error.
std::string png_encode_preview(const Image &image, float exposure);

// ---- Textures, looked up with bilinear interpolation

// An image file's texels, which textures share.
struct Texels {
    int width = 0, height = 0;
    bool has_alpha = false;    // some texel is not opaque
    std::vector<uint8_t> rgba; // height rows of width texels, top row first
};

struct Texture {
    enum Wrap : uint8_t { REPEAT, MIRROR, CLAMP };
    std::shared_ptr<const Texels> texels;
    Wrap wrap_u = REPEAT, wrap_v = REPEAT;
    bool nearest = false; // use the nearest texel
    bool srgb = false;    // decode red, green and blue; alpha is always linear
};

// Decodes the bytes of a PNG or JPEG file. As glTF requires, gamma and colour profiles are ignored. Throws
// Error with a message that continues the image's name.
Texels image_decode(const std::vector<unsigned char> &bytes);

// The colour at uv: (0, 0) is the image's top-left corner, (1, 1) the bottom-right.
glm::vec4 texture_at(const Texture &texture, Vec2 uv);

// The mean of all texels: above zero if any texel is.
Vec3 texture_mean(const Texture &texture);
