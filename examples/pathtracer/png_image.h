// SPDX-License-Identifier: Apache-2.0
// PNG: previews out, masks and textures in.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "image.h"

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
