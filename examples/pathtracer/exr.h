// SPDX-License-Identifier: Apache-2.0
// OpenEXR images: layers in one part, 32 bits per channel, ZIP; the data window is the crop.
//
//     R, G, B         mean radiance          A           fraction of camera rays that hit a surface
//     albedo.R, G, B  mean; 0 for misses     normal.X, Y, Z   mean, in world space; 0 for misses
//     depth.Z         along the camera's axis, mean over the hits
//     count           samples taken (the only integer channel)
//     variance.R, G, B  of single samples, unbiased; 0 below two samples
//
// Attributes are texts.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "film.h"

// The most pixels of a film held in memory: 7 GiB.
constexpr uint64_t MAX_PIXELS = 1u << 26;

// What an image cost and holds: attributes in which its parts differ.
struct ImageStatistics {
    uint32_t spp = 0;                          // the highest count of any pixel
    uint64_t first_sample = 0, end_sample = 0; // all sample numbers are below the latter
    float exposure = 0;                        // of the preview, in stops
    double seconds = 0;                        // of rendering
    uint64_t ray_count = 0;
    unsigned threads = 0;
};

// The header of a file that this program wrote. Settings, which parts of one image share, are what
// decided its samples.
struct ExrHead {
    int full_width = 0, full_height = 0;
    Crop crop = {};
    std::map<std::string, std::string> settings = {};
    ImageStatistics statistics = {};
};

// The bytes of an EXR file of the film; the size and the crop are the film's. Throws Error.
std::string exr_encode(const Film &film, const ExrHead &head);

// Reads the channels R, G and B of any EXR file that has them, as Rec. 709. Throws Error.
Image exr_read(const std::string &path);

// These read files made by exr_encode. They throw Error for any other file.
ExrHead exr_read_head(const std::string &path);
Film exr_read_film(const std::string &path);
