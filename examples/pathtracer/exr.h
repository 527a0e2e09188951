// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures: float RGB, ZIP, the data window is the crop.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image.h"

// What is written into the header beside the picture, under these names.
struct ExrAttributes {
    std::string scene, sampler;
    uint32_t spp, declared_spp, first_sample, max_depth;
    uint64_t seed;
    double seconds;
    uint64_t ray_count;
    unsigned threads;
};

// The bytes of an EXR file. Throws Error.
std::vector<char> exr_encode(const Image &image, const ExrAttributes &attributes);

// Reads the channels R, G and B of any EXR file that has them. Throws Error.
Image exr_read(const std::string &path);
