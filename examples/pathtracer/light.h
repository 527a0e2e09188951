// SPDX-License-Identifier: Apache-2.0
// Lights: parallelograms and triangles that emit from the front (the side of the normal) or from both
// sides; the environment; and punctual lights, which no ray can hit. Densities are per steradian at the
// lit point, as for materials; for punctual lights they are 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "math.h"

// ---- Choosing one of n items with probability proportional to its weight, by inversion. Unlike an
// alias table, inversion is monotonic: stratified numbers stay stratified and blue noise stays blue.
// Draws and the limits between items are multiples of 2^-24, so the returned probabilities are exact.

constexpr float DRAW_STEP = 1.0f / (1 << 24);

// Writes count + 1 limits, from 0 to 1, at least one step apart around every weight above zero. Weights
// must be finite and non-negative, 2^23 at most; if all are zero, the first item is always chosen.
inline void distribution_build(const double *weights, size_t count, float *limits) {
    const double total = std::accumulate(weights, weights + count, 0.0);
    const auto used = std::count_if(weights, weights + count, [](double w) { return w > 0; });
    const double shared = double((1 << 24) - used); // steps left once each item has one
    double sum = 0;
    uint32_t before = 0;
    limits[0] = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += weights[i]; // in the same order as `total`, so that both end at the same value
        before += weights[i] > 0 ? 1 : 0;
        const double share = total > 0 ? sum / total : 1;
        limits[i + 1] = float(uint32_t(share * shared) + before) * DRAW_STEP;
    }
}

struct Choice {
    size_t index;
    float rest;        // where the number falls between the item's limits, in [0, 1)
    float probability; // probability of choosing this item
};

inline Choice distribution_choose(const float *limits, size_t count, float u) {
    const float *above = std::upper_bound(limits + 1, limits + count, u);
    const float low = above[-1], width = *above - low;
    // The centre of the step, so that samples of very narrow items are not all at their start.
    const float rest = std::min((u - low + 0.5f * DRAW_STEP) / width, 1 - DRAW_STEP);
    return {size_t(above - 1 - limits), rest, width};
}

// ---- The environment

// Row 0 is straight up (+y); the centre of a row is +z, with +x to its left, as in OpenEXR's
// latitude-longitude maps. Radiance is constant over each texel.
struct Environment {
    int width, height;
    std::vector<Vec3> texels;         // radiance, row by row
    std::vector<float> row_limits;    // between rows, for sampling: height + 1
    std::vector<float> column_limits; // between columns: height rows of width + 1
    std::vector<float> row_cosines;   // height + 1: of the angle to +y, from 1 to -1
    float irradiance; // from luminance above the mean; 0: too uniform to be worth sampling
};

// Negative values become 0. Throws Error with the position if a texel is not finite; with `clamp`,
// infinity becomes the largest half float and NaN black.
Environment environment_create(int width, int height, std::vector<Vec3> texels, bool clamp = false);

// A clear sky with a sun that is wider than the real one, and ground below.
Environment environment_sky(Vec3 to_sun);

// Reads a latitude-longitude EXR file, or makes "sky" or "none" (black). Throws Error.
Environment environment_read(const std::string &path, bool clamp = false);

Vec3 environment_radiance(const Environment &environment, Vec3 direction);

// The density per steradian with which environment_sample chooses a direction. It is 0 where the
// environment is darker than the mean, so combine it with scattered rays.
float environment_pdf(const Environment &environment, Vec3 direction);

struct EnvironmentSample {
    Vec3 direction;
    float pdf; // per steradian
};

EnvironmentSample environment_sample(const Environment &environment, Vec2 u);

// ---- One light

struct Light {
    enum Kind { PARALLELOGRAM, TRIANGLE, ENVIRONMENT, POINT, SPOT, DIRECTIONAL };
    Kind kind;
    Vec3 corner, edge_u, edge_v; // POINT, SPOT: the corner is the position
    Vec3 normal;                 // unit. SPOT, DIRECTIONAL: the direction it shines in
    float area;
    Vec3 radiance; // POINT, SPOT: radiant intensity. DIRECTIONAL: irradiance at normal incidence
    const Environment *environment = nullptr; // ENVIRONMENT: the scene's, in place of `radiance`
    float distance = 0;      // ENVIRONMENT, DIRECTIONAL: beyond everything in the scene
    bool both_sides = false; // PARALLELOGRAM, TRIANGLE: the back emits too
    bool mapped = false;     // TRIANGLE: `radiance` is a mean; emission_at() gives it at a point
    uint32_t triangle = 0;   // TRIANGLE: its index in the scene; set by scene_finish
    float cosine_inner = 1, cosine_outer = 0; // SPOT: full inside, none outside, smooth between

    bool has_extent() const { return kind < POINT; } // scattered rays can hit it
    bool is_distant() const { return kind == ENVIRONMENT || kind == DIRECTIONAL; }
};

inline Light area_light(Light::Kind kind, Vec3 corner, Vec3 edge_u, Vec3 edge_v, Vec3 radiance) {
    const Vec3 normal = cross(edge_u, edge_v);
    // The square of a huge or a tiny area does not fit in a float.
    const float squared = dot(normal, normal);
    const float parallelogram = squared > 1e-30f && squared < 1e30f
                                    ? std::sqrt(squared)
                                    : float(length(glm::dvec3(normal)));
    const float area = (kind == Light::TRIANGLE ? 0.5f : 1.0f) * parallelogram;
    return {kind, corner, edge_u, edge_v, normalize_or(normal, {0, 0, 1}), area, radiance};
}

struct LightSample {
    Vec3 point;     // on the light
    Vec3 direction; // unit, from the lit point to it
    Vec3 radiance;
    float pdf;  // per steradian; 0: no light reaches the lit point
    Vec2 place; // TRIANGLE: barycentric weights of its second and third vertices
};

// Samples a point uniformly over the light's area, or a direction with environment_sample.
inline LightSample light_sample(const Light &light, Vec3 lit_point, Vec2 u) {
    if (light.kind == Light::ENVIRONMENT) {
        const EnvironmentSample s = environment_sample(*light.environment, u);
        return {lit_point + light.distance * s.direction, s.direction,
                environment_radiance(*light.environment, s.direction), s.pdf, u};
    }
    if (light.kind == Light::DIRECTIONAL)
        return {lit_point - light.distance * light.normal, -light.normal, light.radiance, 1, u};
    if (light.kind == Light::TRIANGLE) u = square_to_triangle(u);
    const Vec3 point = light.corner + u.x * light.edge_u + u.y * light.edge_v;
    const Vec3 to_light = point - lit_point;
    const float squared = dot(to_light, to_light), distance = std::sqrt(squared);
    if (!(squared > 0)) return {point, {}, {}, 0, u};
    const Vec3 direction = (1 / distance) * to_light;
    if (!light.has_extent()) {
        float share = 1; // fraction of the intensity that a spot emits in this direction
        if (light.kind == Light::SPOT) {
            const float range = std::max(light.cosine_inner - light.cosine_outer, 1e-3f);
            const float beyond = -dot(direction, light.normal) - light.cosine_outer;
            const float ramp = std::clamp(beyond / range, 0.0f, 1.0f);
            share = ramp * ramp;
        }
        return {point, direction, (share / squared) * light.radiance, share > 0 ? 1.0f : 0.0f, u};
    }
    const float facing = -dot(light.normal, to_light);
    const float along_normal = light.both_sides ? std::abs(facing) : facing;
    if (!(along_normal > 0)) return {point, {}, {}, 0, u};
    const float pdf = squared * distance / (along_normal * light.area);
    return {point, direction, light.radiance, pdf, u};
}

// The density with which light_sample chooses a point at this distance and non-zero cosine.
inline float light_pdf(const Light &light, float distance, float cosine) {
    return distance * distance / (std::abs(cosine) * light.area);
}

// ---- Choosing a light for a point, by a bound on its contribution: power over squared distance, times
// bounds on both cosines (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive
// Tree Splitting", 2018). At each node of a tree, one number chooses one of up to eight children; its
// remainder is still stratified.

// A lit point, and the side that can be lit, if there is only one.
struct Receiver {
    Vec3 point = {0, 0, 0}, normal = {0, 0, 0};
    bool one_side = false;
};

struct LightNode {
    Vec3 low = Vec3(0), high = Vec3(0); // bounds of its lights
    Vec3 axis = Vec3(0);                // the middle of the directions they shine in
    float cosine = -1;                  // cosine of the largest angle to it; -1: all directions
    float power = 0;      // luminance of the intensity, or of a distant light's irradiance
    bool distant = false; // whether any of its lights has no position
    uint32_t parent = 0, first = 0, count = 0; // children
    int32_t light = -1;                        // light of a node without children
};

struct LightTree {
    std::vector<LightNode> nodes;  // the root first
    std::vector<uint32_t> node_of; // node of each light; 0: it never shines
};

LightTree light_tree(const std::vector<Light> &lights);

struct LightChoice {
    int32_t light; // -1: none can light the point
    float probability;
};

// Chooses a light with u in [0, 1), which becomes its remainder, also in [0, 1).
LightChoice light_choose(const LightTree &tree, const Receiver &receiver, float &u);

// The probability with which light_choose chooses this light.
float light_probability(const LightTree &tree, const Receiver &receiver, uint32_t light);

// The maximum luminance of a light at unit distance; 0 for a light that never shines.
float light_power(const Light &light);
