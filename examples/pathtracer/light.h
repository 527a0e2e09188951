// SPDX-License-Identifier: Apache-2.0
// Lights: parallelograms and triangles that shine from their front, the side of the normal, and the
// environment. Densities are per steradian as seen from the lit point, so that they compare with
// those of materials.
#pragma once

#include "environment.h"
#include "math.h"

struct Light {
    enum Kind { PARALLELOGRAM, TRIANGLE, ENVIRONMENT };
    Kind kind;
    Vec3 corner, edge_u, edge_v;
    Vec3 normal; // unit
    float area;
    Vec3 radiance;
    const Environment *environment; // of the scene; its own radiance counts
    float distance;                 // ENVIRONMENT: that is beyond everything in the scene
    float probability;              // of being chosen among the lights; scene_finish sets it
};

struct LightSample {
    Vec3 point;     // where it comes from
    Vec3 direction; // unit, from the lit point to it
    Vec3 radiance;
    float pdf; // per steradian; 0: the light does not shine there
};

// A point chosen evenly on the light's area, or a direction by the light of the environment.
inline LightSample light_sample(const Light &light, Vec3 lit_point, Vec2 u) {
    if (light.kind == Light::ENVIRONMENT) {
        const EnvironmentSample s = environment_sample(*light.environment, u);
        return {lit_point + light.distance * s.direction, s.direction,
                environment_radiance(*light.environment, s.direction), s.pdf};
    }
    if (light.kind == Light::TRIANGLE) u = square_to_triangle(u);
    const Vec3 point = light.corner + u.x * light.edge_u + u.y * light.edge_v;
    const Vec3 to_light = point - lit_point;
    const float squared = dot(to_light, to_light);
    const float along_normal = -dot(light.normal, to_light);
    if (!(along_normal > 0)) return {point, {}, {}, 0};
    const float distance = std::sqrt(squared);
    return {point, (1 / distance) * to_light, light.radiance,
            squared * distance / (along_normal * light.area)};
}

// The density with which light_sample chooses a point of an area light at that distance, seen under
// cosine > 0.
inline float light_pdf(const Light &light, float distance, float cosine) {
    return distance * distance / (cosine * light.area);
}

// What makes it worth choosing: the power it sends into a scene of that radius, as luminance.
inline float light_power(const Light &light, float scene_radius) {
    if (light.kind == Light::ENVIRONMENT)
        return light.environment->irradiance * PI * scene_radius * scene_radius;
    return luminance(light.radiance) * PI * light.area;
}
