// SPDX-License-Identifier: Apache-2.0
// Adaptive sampling (--noise): where a picture has enough samples.
//
// Pixels stop together, in blocks of 8x8 that lie on the whole picture's grid, whatever the crop.
// So a decision rests on thousands of samples, of which a pixel's own are a 64th: a pixel cannot
// stop because its own few samples happen to agree, which would make pictures too dark. Noise stays
// blue inside blocks, as their pixels have equal counts. Blocks are looked at when they have a power
// of two of samples, where all samplers are at their best, and where few looks are enough.
#pragma once

#include <cstdint>

#include "film.h"

constexpr int BLOCK_SIZE = 8; // pixels per side; blocks at the picture's edges may be smaller

struct NoiseSettings {
    float level = 0;       // relative error as displayed at which a block stops; 0: never
    uint32_t min_spp = 16; // the first look is at the first power of two from here on
    float exposure = 0;    // of the display, in stops
};

// The part of the picture that consists of whole blocks around a crop.
Crop whole_blocks(const Crop &crop, int full_width, int full_height);

// The count after `count` samples at which blocks are looked at, or UINT32_MAX.
uint32_t next_look(const NoiseSettings &noise, uint32_t count);

// An estimate of the relative error of a block, all of whose pixels have the same count, 2 or more:
// the root mean square, over pixels and channels, of the standard error of the mean as displayed,
// over the mean as displayed plus a fiftieth of white. As displayed: exposed and clipped. The
// standard error is that of independent samples, so that of most samplers is smaller. Uses layers
// as the EXR stores them, so pictures that are resumed get the same answers.
double displayed_error(const Film &film, const Crop &block, float exposure);

// Whether a block with `count` samples in each pixel needs no more: always false between looks.
bool is_done(const NoiseSettings &noise, const Film &film, const Crop &block, uint32_t count);
