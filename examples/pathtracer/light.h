// SPDX-License-Identifier: Apache-2.0
// Area lights: parallelograms that shine from their front, the side of the normal. Densities are
// per steradian as seen from the lit point, so that they compare with those of materials.
#pragma once

#include "math.h"

struct Light {
    Vec3 corner, edge_u, edge_v;
    Vec3 normal; // unit
    float area;
    Vec3 radiance;
};

struct LightSample {
    Vec3 point;     // on the light
    Vec3 direction; // unit, from the lit point to it
    float pdf;      // 0: the light does not shine there
};

// A point chosen evenly on the light's area.
inline LightSample light_sample(const Light &light, Vec3 lit_point, Vec2 u) {
    const Vec3 point = light.corner + u.x * light.edge_u + u.y * light.edge_v;
    const Vec3 to_light = point - lit_point;
    const float squared = dot(to_light, to_light);
    const float along_normal = -dot(light.normal, to_light);
    if (!(along_normal > 0)) return {point, {}, 0};
    const float distance = std::sqrt(squared);
    return {point, (1 / distance) * to_light, squared * distance / (along_normal * light.area)};
}

// The density with which light_sample chooses a point at that distance, seen under cosine > 0.
inline float light_pdf(const Light &light, float distance, float cosine) {
    return distance * distance / (cosine * light.area);
}
