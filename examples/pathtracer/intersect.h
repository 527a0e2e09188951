// SPDX-License-Identifier: Apache-2.0
// Finding what a ray hits. Every Embree call of the program is behind this header.
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

// The acceleration structure of a scene. It refers to a scene with cut-outs or single-sided
// materials, and to no other.
struct Geometry;
struct GeometryDelete {
    void operator()(Geometry *geometry) const;
};
using GeometryPointer = std::unique_ptr<Geometry, GeometryDelete>;

// Throws Error.
GeometryPointer geometry_build(const Scene &scene);

// To be called once by each thread that traces rays: makes it flush denormal numbers to zero.
void geometry_thread_begin();

// The nearest hit, but for the backs of single-sided surfaces where `seen` says that the camera
// looks along the ray. False when there is none.
bool intersect(const Geometry &geometry, const Ray &ray, bool seen, Hit &hit);

// Whether anything lies between the two points.
bool occluded(const Geometry &geometry, Vec3 from, Vec3 to);

// A point on a surface moved off it, to the side of the unit normal, so that rays from it do not
// hit the surface itself: by a few times the rounding error of the hit, which grows with the larger
// of the coordinates and the distance the ray came.
inline Vec3 offset_point(Vec3 point, Vec3 normal, float distance) {
    const float rounding = 32 * 1.1920929e-7f;
    return point + (rounding * std::max(max_magnitude(point), distance)) * normal;
}
