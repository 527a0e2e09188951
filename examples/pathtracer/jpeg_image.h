// SPDX-License-Identifier: Apache-2.0
// JPEG textures.
#pragma once

#include <cstdint>
#include <vector>

// Decodes a JPEG to rows of 8-bit red, green, blue and alpha, which is 255. Its extent, not 0, is
// what its header states. Data that end early leave texels grey, and set `cut_short`. Throws Error,
// its text to follow the image's name.
std::vector<uint8_t> jpeg_decode_rgba(const std::vector<unsigned char> &bytes, int width,
                                      int height, bool &cut_short);
