// SPDX-License-Identifier: Apache-2.0
// Vectors (from GLM), orthonormal frames and maps from the unit square.
//
// The choice of map decides how much of a sampler's quality survives. The concentric map to the disc
// (Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997) is continuous.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

constexpr float PI = 3.14159265358979f;

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Point3d = glm::dvec3;

inline float luminance(Vec3 rgb) {
    return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
}
template <typename Number>
Number max_component(glm::tvec3<Number> v) {
    return std::max(v.x, std::max(v.y, v.z));
}
template <typename Number>
Number max_magnitude(glm::tvec3<Number> v) {
    return max_component(abs(v));
}

template <typename Number>
bool is_finite(glm::tvec3<Number> v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// The unit vector along v, for any length of v; `fallback` if v is zero or not finite.
inline Vec3 normalize_or(Vec3 v, Vec3 fallback) {
    const float squared = dot(v, v);
    if (squared > 1e-30f && squared < 1e30f) return (1 / std::sqrt(squared)) * v;
    const float largest = max_magnitude(v);
    if (!(largest > 0) || !std::isfinite(largest)) return fallback;
    // Takes two steps, because a single division could overflow for the shortest vectors.
    return normalize(v / largest);
}

// Tangent, bitangent and unit normal as columns: `frame * v` is v in world space, and `v * frame` is
// the inverse (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
inline glm::mat3 frame_around(Vec3 n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

// Sine and cosine of an angle in [-pi/4, pi/4], accurate to a float's last bits.
inline void small_sin_cos(float angle, float &sine, float &cosine) {
    const float s = angle * angle;
    sine = angle * (1 + s * (-1.0f / 6 + s * (1.0f / 120 + s * (-1.0f / 5040))));
    cosine = 1 + s * (-0.5f + s * (1.0f / 24 + s * (-1.0f / 720 + s * (1.0f / 40320))));
}

// The concentric map. Preserves area.
inline Vec2 square_to_disc(Vec2 u) {
    const float a = 2 * u.x - 1, b = 2 * u.y - 1;
    float sine, cosine;
    if (std::abs(a) > std::abs(b)) {
        small_sin_cos(PI / 4 * (b / a), sine, cosine);
        return {a * cosine, a * sine};
    }
    if (b == 0) return {0, 0};
    small_sin_cos(PI / 4 * (a / b), sine, cosine);
    return {b * sine, b * cosine};
}

// Maps to barycentric coordinates. Preserves area (Heitz, "A Low-Distortion Map Between Triangle and
// Square", 2019).
inline Vec2 square_to_triangle(Vec2 u) {
    if (u.y > u.x) return {0.5f * u.x, u.y - 0.5f * u.x};
    return {u.x - 0.5f * u.y, 0.5f * u.y};
}

// Samples directions around +z with density cosine / pi per steradian.
inline Vec3 square_to_cosine_hemisphere(Vec2 u) {
    const Vec2 d = square_to_disc(u);
    return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}
