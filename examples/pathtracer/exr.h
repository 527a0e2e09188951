// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures: layers in one part, 32 bits per channel, ZIP; the data window is the crop.
//
//     R, G, B         mean radiance          A           fraction of camera rays that hit a surface
//     albedo.R, G, B  mean; 0 for misses     normal.X, Y, Z   mean, in world space; 0 for misses
//     depth.Z         along the camera's axis, mean over the hits
//     count           samples taken (the only integer channel)
//     variance.R, G, B  of single samples, unbiased; 0 below two samples
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "adaptive.h"
#include "film.h"

// The most pixels of a film held in memory: 7 GiB.
constexpr uint64_t MAX_PIXELS = 1u << 26;

// The attributes of the header.
struct ExrAttributes {
    std::string scene, camera, environment, sampler, mask;
    std::string inputs; // InputRecord::text() of the files of scene, environment and mask
    uint32_t draws;     // BN_DRAW_TABLE_VERSION of what drew its samples
    uint64_t declared_spp, seed;
    uint32_t max_depth, light_samples;
    bool single_scatter, photometric;
    NoiseSettings noise; // its level is 0 without adaptive sampling

    uint32_t spp;                      // the highest count of any pixel
    uint64_t first_sample, end_sample; // all sample numbers are below the latter
    float exposure;                    // of the preview, in stops
    double seconds;                    // of rendering
    uint64_t ray_count;
    unsigned threads;
    double sampling_share; // of that time spent drawing samples, approximately
};

// Calls visit(name in the file, value) for the attributes that parts of one picture share.
template <typename Attributes, typename Visit>
void exr_settings(Attributes &a, Visit visit) {
    visit("scene", a.scene);
    visit("environment", a.environment);
    visit("mask", a.mask);
    visit("inputs", a.inputs); // the rest may follow from what is in them
    visit("sampler", a.sampler);
    visit("draws", a.draws);
    visit("camera", a.camera);
    visit("declaredSpp", a.declared_spp);
    visit("seed", a.seed);
    visit("maxDepth", a.max_depth);
    visit("lightSamples", a.light_samples);
    visit("noise", a.noise.level);
    visit("minSpp", a.noise.min_spp);
    visit("noiseExposure", a.noise.exposure);
    visit("singleScatter", a.single_scatter);
    visit("photometric", a.photometric);
}

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

// These read files made by exr_encode. They throw Error for any other file.
ExrHead exr_read_head(const std::string &path);
Film exr_read_film(const std::string &path);
