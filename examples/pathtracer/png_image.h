// SPDX-License-Identifier: Apache-2.0
// PNG: previews out, masks in.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image.h"

// An 8-bit sRGB preview as the bytes of a PNG file: exposure in stops, then a curve that leaves
// middle greys alone and rolls highlights off, then rounding up or down by a blue-noise mask of
// libbn, so that smooth gradients show no bands. Throws Error.
std::vector<char> png_encode_preview(const Image &image, float exposure);

// The level, from 0 to 255, that a preview shows a linear value with, before it is rounded.
float preview_level(float linear);

struct GreyImage {
    uint32_t width, height;
    std::vector<uint16_t> values;
};

// Reads a PNG as 16-bit greys. Throws Error.
GreyImage png_read_grey(const std::string &path);
