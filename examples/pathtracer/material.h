// SPDX-License-Identifier: Apache-2.0
// Surface scattering: diffuse (Lambert) on both sides. A further material adds its parameters here
// and a case in each of the three functions.
//
// Directions are unit vectors in world space that point away from the surface; the frame's normal
// lies on the side of `out`. Densities are per steradian.
#pragma once

#include "math.h"

struct Material {
    Vec3 albedo;
};

// The scattering function times the cosine of `in`.
inline Vec3 material_eval(const Material &m, const Frame &frame, Vec3 in) {
    return (std::max(0.0f, dot(frame.normal, in)) / PI) * m.albedo;
}

// The density with which material_sample chooses `in`.
inline float material_pdf(const Material &, const Frame &frame, Vec3 in) {
    return std::max(0.0f, dot(frame.normal, in)) / PI;
}

struct MaterialSample {
    Vec3 in;
    Vec3 weight; // eval / pdf
    float pdf;   // 0: no direction found, the path ends
};

inline MaterialSample material_sample(const Material &m, const Frame &frame, Vec2 u) {
    const Vec3 local = square_to_cosine_hemisphere(u);
    return {to_world(frame, local), m.albedo, local.z / PI};
}
