// SPDX-License-Identifier: Apache-2.0
// Ray intersection. This header hides all calls to Embree.
#pragma once

#include "camera.h"
#include "scene.h"

struct Hit {
    float distance;
    SurfacePoint point;
    Vec3 normal; // geometric, unit, on the front of the triangle
};

// A scene's acceleration structure. The scene must outlive it and must not move.
struct Geometry;
using GeometryPointer = std::shared_ptr<const Geometry>;

GeometryPointer geometry_build(const Scene &scene);

// Makes the calling thread flush denormals to zero, which rays need.
void geometry_thread_begin();

// Finds the nearest hit; returns false if there is none. Rays that are `seen_by_camera` pass
// through the backs of single-sided surfaces.
bool intersect(const Geometry &geometry, const Ray &ray, bool seen_by_camera, Hit &hit);

// Whether anything blocks the segment between two points at the given time.
bool occluded(const Geometry &geometry, Vec3 from, Vec3 to, float time);

// Moves a point off its surface, along the unit normal, by a few times its rounding error, so that
// rays from it do not hit the surface again.
inline Vec3 offset_point(Vec3 point, Vec3 normal, float distance) {
    const float rounding = 32 * 1.1920929e-7f;
    return point + (rounding * std::max(max_magnitude(point), distance)) * normal;
}
