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

// The radiance of sample `index` of pixel (x, y), top left is (0, 0). Adds the rays it traces to
// `ray_count`.
Vec3 trace_path(const Integrator &integrator, int x, int y, uint32_t index, uint64_t &ray_count);
