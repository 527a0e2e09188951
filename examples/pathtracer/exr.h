// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures: layers in one part, 32 bits a channel, ZIP, the data window is the crop.
//
//     R, G, B         mean radiance          A           share of camera rays that hit a surface
//     albedo.R, G, B  of what they hit       normal.X, Y, Z   of it, in the world, mean
//     depth.Z         along the camera's axis, mean over those that hit
//     count           samples taken (the only integer channel)
//     variance.R, G, B  of single samples, unbiased; 0 below two samples
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "film.h"
#include "scene_camera.h"

// Films larger than this are not held at once: 7 GiB.
constexpr uint64_t MAX_PIXELS = 1u << 26;

// The attributes of the header.
struct ExrAttributes {
    std::string scene, camera, environment, sampler, mask;
    CameraMatrices matrices;
    uint32_t spp; // the largest of all pixels
    uint32_t declared_spp, first_sample, max_depth, light_samples;
    bool single_scatter, photometric;
    uint64_t end_sample; // no sample has this number or a higher one
    uint64_t seed;
    float exposure; // of the preview, in stops
    double seconds; // of rendering
    uint64_t ray_count;
    unsigned threads;
    double sampling_share; // of that time, spent in drawing samples; about
    uint64_t fireflies;    // pixels, see film.h
};

// The bytes of an EXR file. Throws Error.
std::vector<char> exr_encode(const Film &film, const ExrAttributes &attributes);

// Reads the channels R, G and B of any EXR file that has them. Throws Error.
Image exr_read(const std::string &path);

// The header of a file that this program wrote.
struct ExrHead {
    int full_width, full_height;
    Crop crop;
    ExrAttributes attributes;
};

// These read files made by exr_encode. They throw Error for all others.
ExrHead exr_read_head(const std::string &path);
Film exr_read_film(const std::string &path);
