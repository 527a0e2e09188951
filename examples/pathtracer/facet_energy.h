// SPDX-License-Identifier: Apache-2.0
// How much light microfacets keep in single scattering, integrated into tables at start-up.
// Materials add the rest back. Tables are indexed by the square root of the cosine, because they
// change most at small cosines.
#pragma once

#include <array>

#include "material.h"
#include "microfacet.h"

namespace facet_energy {

constexpr int SIZE = DielectricEnergy::SIZE;
constexpr int RINGS = 40, SECTORS = 12; // facets integrated per table entry
constexpr float LEAST_LOSS = 1e-3f;     // mean over the hemisphere; less is ignored

// Looks up a table, linearly, at `position`, the root of a cosine.
inline float interpolate(const float *table, float position) {
    const float at = std::min(std::max(position, 0.0f), 1.0f) * (SIZE - 1);
    const int below = std::min(static_cast<int>(at), SIZE - 2);
    const float t = at - static_cast<float>(below);
    return (1 - t) * table[below] + t * table[below + 1];
}

inline float cosine_of_entry(int entry) {
    const float root = static_cast<float>(entry) / (SIZE - 1);
    return std::max(root * root, 1e-4f);
}

inline Vec3 direction_of_cosine(float cosine) {
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// The share of light kept by a facet drawn from the visible normals that scatters from o to `wi`:
// G2 / G1.
inline float kept(float alpha, Vec3 o, Vec3 wi) {
    return std::abs(wi.z) * ggx_shadowing(alpha, o, wi) / ggx_masking(alpha, o);
}

// The mean of a function over the normals visible from o, which lies in the xz-plane. The facets
// that matter are steep and rare, at the rim of the disc, so its rings get thinner towards the rim.
template <typename Function>
float mean_over_normals(float alpha, Vec3 o, const Function &function) {
    double sum = 0, weights = 0;
    for (int ring = 0; ring < RINGS; ++ring) {
        const float v = (static_cast<float>(ring) + 0.5f) / RINGS;
        const float radius = std::sqrt(1 - v * v * v);
        for (int sector = 0; sector < SECTORS; ++sector) {
            // The two halves of the disc are mirror images; one is enough.
            const float angle = PI * ((static_cast<float>(sector) + 0.5f) / SECTORS - 0.5f);
            const Vec2 disc = {radius * std::cos(angle), radius * std::sin(angle)};
            const double weight = static_cast<double>(v * v);
            sum += weight * static_cast<double>(function(ggx_visible_normal(alpha, o, disc)));
            weights += weight;
        }
    }
    return static_cast<float>(sum / weights);
}

// The cosine-weighted mean over the hemisphere: twice the integral of the table times the cosine,
// over the cosine. Between entries the table is linear in the root, as in interpolate().
float hemispherical_mean(const float *table);

// What Schlick's formula adds at this cosine to a reflectance of 0.
inline float schlick_edge(float cosine) {
    const float c = 1 - std::min(std::max(cosine, 0.0f), 1.0f);
    return c * c * c * c * c;
}

// For conductors with a white Fresnel term.
struct ConductorTable {
    std::array<std::array<float, SIZE>, SIZE> energy; // [roughness][root of cosine]
    std::array<float, SIZE> mean_loss;                // [roughness]
    // `energy` with Schlick's Fresnel term at a reflectance of 0 instead, and its mean.
    std::array<std::array<float, SIZE>, SIZE> edge;
    std::array<float, SIZE> mean_edge;
};

const ConductorTable &conductor_table();

} // namespace facet_energy

// ---- mixture.cpp: the metallic-roughness material of glTF. Directions are as in material.h, above the
// surface.

// The BRDF times the cosine of `wi`, and the density with which mixture_sample() chooses it.
struct MixtureValue {
    Vec3 eval;
    float pdf;
};

MixtureValue mixture_value(const Material &material, Vec3 wo, Vec3 wi);

MaterialSample mixture_sample(const Material &material, Vec3 wo, Vec2 u);
