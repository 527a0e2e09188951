// SPDX-License-Identifier: Apache-2.0
// Pictures: linear RGB, or the part of one inside a crop; PNG; textures with 8 bits per channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "math.h"

// The pixels x0 <= x < x1, y0 <= y < y1 of a picture; y grows downwards.
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
    return static_cast<size_t>(width(crop)) * static_cast<size_t>(height(crop));
}

struct Image {
    int full_width, full_height; // of the whole picture
    Crop crop;                   // the pixels held
    std::vector<Vec3> rgb;       // height(crop) rows of width(crop) pixels
};

// The part of an image inside a crop, which must lie within the image's own crop.
Image image_crop(const Image &image, const Crop &crop);

// The RMS of image - reference over pixels and channels, after a Gaussian of sigma pixels that is
// cut off at four sigma and mirrors the picture at its edges. Sigma 0 is the plain RMSE. Both
// images must cover the same pixels.
double blurred_rmse(const Image &image, const Image &reference, double sigma);

// Encodes an 8-bit sRGB preview as a PNG file: applies the exposure in stops, a tone curve that
// keeps middle greys and rolls off highlights, and dithering with one of libbn's blue-noise masks,
// so that smooth gradients show no bands. Throws Error.
std::string png_encode_preview(const Image &image, float exposure);

struct GreyImage {
    uint32_t width, height;
    std::vector<uint16_t> values;
};

// Reads a PNG as 16-bit grey. Throws Error.
GreyImage png_read_grey(const std::string &path);

// ---- Textures, looked up with bilinear interpolation

struct Texture {
    enum Wrap : uint8_t { REPEAT, MIRROR, CLAMP };
    int width = 0, height = 0;
    Wrap wrap_u = REPEAT, wrap_v = REPEAT;
    bool nearest = false;      // the nearest texel, not bilinear
    bool srgb = false;         // decode red, green and blue; alpha is always linear
    bool has_alpha = false;    // some texel is not opaque
    bool cut_short = false;    // the file ends early: the rest is guessed
    std::vector<uint8_t> rgba; // height rows of width texels, top row first
};

// Decodes the bytes of an image file. Throws Error, its text to follow the image's name.
Texture texture_decode(const std::vector<unsigned char> &bytes);

// The colour at uv: (0, 0) is the top left corner of the image, (1, 1) the bottom right.
glm::vec4 texture_at(const Texture &texture, Vec2 uv);

// The mean of all texels: above zero if any of them is.
Vec3 texture_mean(const Texture &texture);
