// SPDX-License-Identifier: Apache-2.0
// Lights: parallelograms and triangles that emit from the front (the side of the normal) or from
// both sides; the environment; and punctual lights, which no ray can hit. Densities are per
// steradian as seen from the lit point, like those of materials; for punctual lights they are 1.
#pragma once

#include "environment.h"
#include "math.h"

struct Light {
    enum Kind { PARALLELOGRAM, TRIANGLE, ENVIRONMENT, POINT, SPOT, DIRECTIONAL };
    Kind kind;
    Vec3 corner, edge_u, edge_v; // POINT, SPOT: the corner is the position
    Vec3 normal;                 // unit. SPOT, DIRECTIONAL: the direction it shines in
    float area;
    Vec3 radiance;                  // POINT, SPOT: radiant intensity. DIRECTIONAL: irradiance at
                                    // normal incidence
    const Environment *environment; // ENVIRONMENT: the scene's; used instead of `radiance`
    float distance;                 // ENVIRONMENT, DIRECTIONAL: beyond everything in the scene
    float probability;              // of being chosen among all lights; set by scene_finish
    bool both_sides = false;        // PARALLELOGRAM, TRIANGLE: the back emits too
    bool mapped = false;   // TRIANGLE: `radiance` is a mean; emission_at() gives it at a point
    uint32_t triangle = 0; // TRIANGLE: its index in the scene; set by scene_finish
    float cosine_inner = 1, cosine_outer = 0; // SPOT: full inside, none outside, smooth between
};

// A parallelogram or a triangle that emits from its front.
inline Light area_light(Light::Kind kind, Vec3 corner, Vec3 edge_u, Vec3 edge_v, Vec3 radiance) {
    Light light{};
    const Vec3 normal = cross(edge_u, edge_v);
    light.kind = kind;
    light.corner = corner;
    light.edge_u = edge_u;
    light.edge_v = edge_v;
    light.normal = normalize_or(normal, {0, 0, 1});
    light.area = (kind == Light::TRIANGLE ? 0.5f : 1.0f) * length(normal);
    light.radiance = radiance;
    return light;
}

// Whether scattered rays can hit the light.
inline bool light_has_extent(const Light &light) {
    return light.kind < Light::POINT;
}

struct LightSample {
    Vec3 point;     // on the light
    Vec3 direction; // unit, from the lit point to it
    Vec3 radiance;
    float pdf;  // per steradian; 0: no light reaches the lit point
    Vec2 place; // TRIANGLE: barycentric weights of its second and third vertices
};

// The fraction of its intensity that a spot emits at this cosine to its axis.
inline float spot_share(const Light &light, float cosine) {
    const float range = std::max(light.cosine_inner - light.cosine_outer, 1e-3f);
    const float t = std::clamp((cosine - light.cosine_outer) / range, 0.0f, 1.0f);
    return t * t;
}

// Samples a point uniformly on the light's area, or a direction by the environment's radiance.
inline LightSample light_sample(const Light &light, Vec3 lit_point, Vec2 u) {
    if (light.kind == Light::ENVIRONMENT) {
        const EnvironmentSample s = environment_sample(*light.environment, u);
        return {lit_point + light.distance * s.direction, s.direction,
                environment_radiance(*light.environment, s.direction), s.pdf, u};
    }
    if (light.kind == Light::DIRECTIONAL)
        return {lit_point - light.distance * light.normal, -light.normal, light.radiance, 1, u};
    if (!light_has_extent(light)) {
        const Vec3 to_light = light.corner - lit_point;
        const float squared = dot(to_light, to_light);
        if (!(squared > 0)) return {light.corner, {}, {}, 0, u};
        const Vec3 direction = (1 / std::sqrt(squared)) * to_light;
        const float share =
            light.kind == Light::SPOT ? spot_share(light, -dot(direction, light.normal)) : 1;
        return {light.corner, direction, (share / squared) * light.radiance,
                share > 0 ? 1.0f : 0.0f, u};
    }
    if (light.kind == Light::TRIANGLE) u = square_to_triangle(u);
    const Vec3 point = light.corner + u.x * light.edge_u + u.y * light.edge_v;
    const Vec3 to_light = point - lit_point;
    const float squared = dot(to_light, to_light);
    const float facing = -dot(light.normal, to_light);
    const float along_normal = light.both_sides ? std::abs(facing) : facing;
    if (!(along_normal > 0)) return {point, {}, {}, 0, u};
    const float distance = std::sqrt(squared);
    return {point, (1 / distance) * to_light, light.radiance,
            squared * distance / (along_normal * light.area), u};
}

// The density with which light_sample chooses a point of an area light, at this distance and
// non-zero cosine.
inline float light_pdf(const Light &light, float distance, float cosine) {
    return distance * distance / (std::abs(cosine) * light.area);
}

// The density with which light_sample chooses a direction, whatever hides the light. 0 for punctual
// lights.
inline float light_pdf_towards(const Light &light, Vec3 lit_point, Vec3 direction) {
    if (light.kind == Light::ENVIRONMENT) return environment_pdf(*light.environment, direction);
    const float cosine = -dot(light.normal, direction);
    if (!light_has_extent(light) || !(light.both_sides ? cosine != 0 : cosine > 0)) return 0;
    const float distance = dot(light.normal, lit_point - light.corner) / cosine;
    if (!(distance > 0)) return 0;
    const Vec3 place = lit_point + distance * direction - light.corner;
    const float uu = dot(light.edge_u, light.edge_u), uv = dot(light.edge_u, light.edge_v);
    const float vv = dot(light.edge_v, light.edge_v), determinant = uu * vv - uv * uv;
    const float pu = dot(light.edge_u, place), pv = dot(light.edge_v, place);
    const float u = (vv * pu - uv * pv) / determinant, v = (uu * pv - uv * pu) / determinant;
    const bool hit =
        u >= 0 && v >= 0 && (light.kind == Light::TRIANGLE ? u + v : std::max(u, v)) <= 1;
    return hit ? light_pdf(light, distance, cosine) : 0;
}

// The weight for choosing this light: the power, as luminance, it sends into a scene of this
// radius.
inline float light_power(const Light &light, float scene_radius) {
    if (light.kind == Light::ENVIRONMENT)
        return light.environment->irradiance * PI * scene_radius * scene_radius;
    const float bright = luminance(light.radiance);
    if (light.kind == Light::DIRECTIONAL) return bright * PI * scene_radius * scene_radius;
    if (light.kind == Light::POINT) return bright * 4 * PI;
    if (light.kind == Light::SPOT)
        return bright * 2 * PI * (1 - 0.5f * (light.cosine_inner + light.cosine_outer));
    return bright * PI * light.area * (light.both_sides ? 2.0f : 1.0f);
}
