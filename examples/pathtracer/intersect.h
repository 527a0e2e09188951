// SPDX-License-Identifier: Apache-2.0
// Ray intersection. All Embree calls of the program are behind this header.
#pragma once

#include <cstdint>
#include <memory>

#include "camera.h"
#include "scene.h"

struct Hit {
    float distance;
    uint32_t triangle; // index into Scene::triangles
    Vec3 normal;       // geometric, unit, on the front of the triangle
    float u, v;        // weights of the second and the third vertex
};

// A scene's acceleration structure. The scene must outlive it and must not move.
struct Geometry;
using GeometryPointer = std::shared_ptr<const Geometry>;

// Throws Error.
GeometryPointer geometry_build(const Scene &scene);

// Call this once in each thread that traces rays: it makes the thread flush denormals to zero.
void geometry_thread_begin();

// Finds the nearest hit; returns false if there is none. Rays that are `seen_by_camera` pass
// through the backs of single-sided surfaces.
bool intersect(const Geometry &geometry, const Ray &ray, bool seen_by_camera, Hit &hit);

// Whether anything blocks the segment between two points at this time.
bool occluded(const Geometry &geometry, Vec3 from, Vec3 to, float time);

// Moves a point off its surface, along the unit normal, so that rays from it do not hit the
// surface again. The distance is a few times the rounding error of the hit point, which grows with
// the coordinates and the length of the ray.
inline Vec3 offset_point(Vec3 point, Vec3 normal, float distance) {
    const float rounding = 32 * 1.1920929e-7f;
    return point + (rounding * std::max(max_magnitude(point), distance)) * normal;
}
