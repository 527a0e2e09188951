// SPDX-License-Identifier: Apache-2.0
// The path integrator: the value of one sample of one pixel.
#pragma once

#include <cstdint>
#include <vector>

#include "intersect.h"
#include "sampler.h"
#include "scene.h"

// Everything a path reads while it is traced.
struct Integrator {
    const Scene *scene;
    const Geometry *geometry;
    const Sampler *sampler;
    uint32_t max_depth; // bounces, off surfaces and in a medium; 0 shows lights only
};

// Statistics of the paths traced.
struct PathCounters {
    uint64_t rays = 0;
    uint64_t draws_2d = 0, draws_4d = 0; // from the sampler
    uint64_t lost = 0;                   // non-finite samples: there should be none
    // The total throughput of paths cut off at max_depth. Divided by the number of samples, the
    // share of throughput lost.
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

// The result of one sample of a pixel.
struct PathSample {
    Vec3 radiance;
    // The first surface the camera ray hits, for denoisers; 0 if there is none.
    bool hit;
    Vec3 albedo, normal; // `normal` is the shading normal in world space
    float depth;         // along the camera's axis, from its lens
};

// Traces sample `index` of pixel (x, y); (0, 0) is top left. Adds to `counters`.
PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters);
