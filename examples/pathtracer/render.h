// SPDX-License-Identifier: Apache-2.0
// Rendering a picture, or a part of one, on all cores.
#pragma once

#include <cstdint>
#include <functional>

#include "image.h"
#include "integrator.h"

struct RenderSettings {
    Crop crop;                 // the pixels to render
    uint32_t first_sample = 0; // index of the first sample of each pixel
    uint32_t spp = 16;         // samples per pixel
    unsigned threads = 1;
};

struct RenderProgress {
    double fraction; // of the picture
    double seconds;  // since the start
    uint64_t ray_count;
    double cut_off; // at the end: the share of the paths' worth that ended at the greatest depth
};

// Calls `report` from the calling thread a few times a second while rendering, and once at the end.
// `done` gets the final figures. The picture does not depend on the number of threads or the crop.
Image render(const Integrator &integrator, const RenderSettings &settings,
             const std::function<void(const RenderProgress &)> &report, RenderProgress &done);
