// SPDX-License-Identifier: Apache-2.0
// The path integrator: what one sample of one pixel is worth.
#pragma once

#include <cstdint>
#include <vector>

#include "intersect.h"
#include "sampler.h"
#include "scene.h"

// Everything a path reads while it is traced. The domains of a bounce do not depend on the path, so
// they are derived once.
struct Integrator {
    const Scene *scene;
    const Geometry *geometry;
    const bn_sampler *sampler;
    uint32_t max_depth; // surface bounces; 0 shows lights only
    struct BounceDomains {
        uint32_t light, scatter;
    };
    uint32_t pixel;
    std::vector<BounceDomains> bounces; // max_depth of them
};

Integrator integrator_create(const Scene &scene, const Geometry &geometry,
                             const bn_sampler *sampler, uint32_t max_depth);

// What tracing paths adds up beside the picture.
struct PathCounters {
    uint64_t rays = 0;
    // Paths that ended at max_depth, not by roulette nor by leaving the scene, as shares of a
    // sample: divided by the number of samples, what part of the paths' worth was cut off.
    double cut_off = 0;
};

// The radiance of sample `index` of pixel (x, y), top left is (0, 0). Adds to `counters`.
Vec3 trace_path(const Integrator &integrator, int x, int y, uint32_t index, PathCounters &counters);
