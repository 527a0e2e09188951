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

#include "film.h"
#include "sampler.h"

// The most pixels of a film held in memory: 7 GiB.
constexpr uint64_t MAX_PIXELS = 1u << 26;

// What a picture is made with, as the command line says or its EXR.
struct PictureSettings {
    std::string scene = "cornell";
    std::string environment; // an EXR file, or empty: the scene's own
    SamplerSettings sampler;
    uint32_t max_depth = 8;
    bool single_scatter = false, photometric = false;
    bool clamp = false;  // texels of the environment that are not finite
    NoiseSettings noise; // its exposure is only an EXR's
};

// Calls visit(name in the file, option, value in a, value in b) for each.
template <typename One, typename Other, typename Visit>
void visit_settings(One &a, Other &b, Visit visit) {
    visit("scene", "--scene", a.scene, b.scene);
    visit("environment", "--env", a.environment, b.environment);
    visit("mask", "--mask", a.sampler.mask, b.sampler.mask);
    visit("sampler", "--sampler", a.sampler.name, b.sampler.name);
    visit("declaredSpp", "--declare", a.sampler.declared_spp, b.sampler.declared_spp);
    visit("seed", "--seed", a.sampler.seed, b.sampler.seed);
    visit("maxDepth", "--max-depth", a.max_depth, b.max_depth);
    visit("noise", "--noise", a.noise.level, b.noise.level);
    visit("minSpp", "--min-spp", a.noise.min_spp, b.noise.min_spp);
    visit("singleScatter", "--single-scatter", a.single_scatter, b.single_scatter);
    visit("photometric", "--photometric", a.photometric, b.photometric);
    visit("clamp", "--clamp", a.clamp, b.clamp);
}

// The attributes of the header.
struct ExrAttributes : PictureSettings {
    std::string camera;
    std::string inputs; // InputRecord::text() of the files of scene, environment and mask
    uint32_t draws;     // BN_DRAW_TABLE_VERSION of what drew its samples
    uint32_t light_samples;

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
    visit_settings(a, a, [&](const char *name, auto, auto &value, auto &) { visit(name, value); });
    visit("inputs", a.inputs); // the rest may follow from what is in them
    visit("draws", a.draws);
    visit("camera", a.camera);
    visit("lightSamples", a.light_samples);
    visit("noiseExposure", a.noise.exposure);
}

// The bytes of an EXR file. Throws Error.
std::string exr_encode(const Film &film, const ExrAttributes &attributes);

// Reads the channels R, G and B of any EXR file that has them, as Rec. 709. Throws Error.
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
