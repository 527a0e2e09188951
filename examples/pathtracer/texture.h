// SPDX-License-Identifier: Apache-2.0
// Textures: pictures of 8 bits a channel, read from PNG, JPEG, BMP or TGA, and looked up between
// their texels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "math.h"

struct Texture {
    enum Wrap : uint8_t { REPEAT, MIRROR, CLAMP };
    int width = 0, height = 0;
    Wrap wrap_u = REPEAT, wrap_v = REPEAT;
    bool nearest = false;      // the nearest texel instead of four, weighed
    bool srgb = false;         // red, green and blue are decoded; alpha never is
    bool has_alpha = false;    // the file has
    std::vector<uint8_t> rgba; // height rows of width texels, the first row on top
};

struct TextureColour {
    Vec3 rgb;
    float alpha;
};

// Reads a picture out of the bytes of its file. Throws Error, its text to follow the picture's
// name.
Texture texture_decode(const std::vector<unsigned char> &bytes);

// At (0, 0) is the top left corner of the picture, at (1, 1) the bottom right one.
TextureColour texture_at(const Texture &texture, Vec2 uv);

// The mean of all texels: above zero when any of them is.
Vec3 texture_mean(const Texture &texture);
