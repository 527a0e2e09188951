// SPDX-License-Identifier: Apache-2.0
// The path integrator, which computes one sample of one pixel.
#pragma once

#include "intersect.h"
#include "sampler.h"
#include "scene.h"

struct Integrator {
    const Scene *scene;
    const Geometry *geometry;
    const Sampler *sampler;
    uint32_t max_depth;           // bounces, off surfaces and in a medium; 0 shows only lights
    int draw_dx = 0, draw_dy = 0; // pixel (x, y) uses the draws of pixel (x - dx, y - dy)
    bool gaussian_filter = false; // instead of a box of one pixel
};

struct PathCounters {
    uint64_t paths = 0, rays = 0;
    uint64_t lost = 0;  // non-finite samples: there should be none
    double cut_off = 0; // the throughput of all paths that were cut off at max_depth
};

inline PathCounters &operator+=(PathCounters &a, const PathCounters &b) {
    a.paths += b.paths;
    a.rays += b.rays;
    a.lost += b.lost;
    a.cut_off += b.cut_off;
    return a;
}

struct PathSample {
    Vec3 radiance;
    // The first surface the camera ray hits, for denoisers; 0 if there is none.
    bool hit;
    Vec3 albedo, normal; // `normal` is the shading normal in world space
    float depth;         // along the camera's axis, from its lens
};

// The MIS weight of a sample with density pdf > 0.
inline float power_heuristic(float pdf, float other_pdf) {
    const float ratio = other_pdf / pdf;
    return 1 / (1 + ratio * ratio);
}

// Traces sample `index` of pixel (x, y); (0, 0) is at the top left. Adds to `counters`.
PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters);
