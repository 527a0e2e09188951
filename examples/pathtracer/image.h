// SPDX-License-Identifier: Apache-2.0
// Pictures: linear RGB, or the part of one inside a crop; PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

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

// ---- difference.cpp

// The part of an image inside a crop, which must lie within the image's own crop.
Image image_crop(const Image &image, const Crop &crop);

// The RMS of image - reference over pixels and channels, after a Gaussian of sigma pixels that is
// cut off at four sigma and mirrors the picture at its edges. Sigma 0 is the plain RMSE. Both
// images must cover the same pixels.
double blurred_rmse(const Image &image, const Image &reference, double sigma);

// ---- png_image.cpp

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

// Decodes a PNG as rows of 8-bit red, green, blue and alpha, into what make_room(width, height)
// returns. False if it is damaged.
bool png_decode_rgba(const std::vector<unsigned char> &bytes,
                     const std::function<uint8_t *(int64_t, int64_t)> &make_room);
