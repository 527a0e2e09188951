// SPDX-License-Identifier: Apache-2.0
// The path integrator: what one sample of one pixel is worth.
#pragma once

#include <cstdint>
#include <vector>

#include "intersect.h"
#include "sampler.h"
#include "scene.h"

// Everything a path reads while it is traced. The domains of a ray do not depend on the path, so
// they are derived once.
struct Integrator {
    const Scene *scene;
    const Geometry *geometry;
    const Sampler *sampler;
    uint32_t max_depth; // surface bounces; 0 shows lights only
    struct RayDomains {
        uint32_t ray, choices;
        int dimensions; // of `ray`: 4 where it holds the light, or the lens, too
    };
    std::vector<RayDomains> rays; // the camera's, and one for each of max_depth bounces
    uint32_t first_light;
    bool first_light_apart; // in `first_light`, not in the camera ray's domain
};

Integrator integrator_create(const Scene &scene, const Geometry &geometry, const Sampler *sampler,
                             uint32_t max_depth);

// What tracing paths adds up beside the picture.
struct PathCounters {
    uint64_t rays = 0;
    uint64_t draws_2d = 0, draws_4d = 0; // from the sampler
    uint64_t lost = 0; // samples that were no finite numbers: there should be none
    // Paths that ended at max_depth, not by roulette nor by leaving the scene, as shares of a
    // sample: divided by the number of samples, what part of the paths' worth was cut off.
    double cut_off = 0;
};

inline PathCounters &operator+=(PathCounters &a, const PathCounters &b) {
    a.rays += b.rays;
    a.draws_2d += b.draws_2d;
    a.draws_4d += b.draws_4d;
    a.lost += b.lost;
    a.cut_off += b.cut_off;
    return a;
}

// What one sample of a pixel sees.
struct PathSample {
    Vec3 radiance;
    // Of the surface the camera ray hits, 0 when there is none: what denoisers ask for.
    bool hit;
    Vec3 albedo, normal; // the normal it is shaded with, in the world
    float depth;         // along the camera's axis, from its lens
};

// Sample `index` of pixel (x, y), top left is (0, 0). Adds to `counters`.
PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters);
