// SPDX-License-Identifier: Apache-2.0
// Textures with 8 bits per channel, read from PNG or JPEG and looked up with bilinear
// interpolation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "math.h"

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
