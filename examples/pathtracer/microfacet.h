// SPDX-License-Identifier: Apache-2.0
// Shared by rough materials: the GGX distribution of microfacets with Smith's height-correlated
// shadowing and masking (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
// 2007; Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", 2014),
// Fresnel's equations, and tables of the energy that single scattering preserves. Directions are local,
// with the normal along +z; alpha is in (0, 1]. Masking and shadowing include the division by their
// cosines, so that nothing is divided by a vanishing cosine.
#pragma once

#include "material.h"

// D(h), the distribution of microfacet normals; its cosine-weighted integral is 1.
inline float ggx_density(float alpha, Vec3 h) {
    const float squared = alpha * alpha;
    const float t = (h.x * h.x + h.y * h.y) / squared + h.z * h.z;
    return 1 / (PI * squared * t * t);
}

// The denominator of Smith's G1 for one direction: |z| + sqrt(z^2 + (alpha sine)^2).
inline float ggx_smith(float alpha, Vec3 w) {
    return std::abs(w.z) + std::sqrt(w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y));
}

// Masking of one direction, divided by its cosine: G1(w) / |w.z|.
inline float ggx_masking(float alpha, Vec3 w) {
    return 2 / ggx_smith(alpha, w);
}

// Shadowing and masking of two directions, divided by their cosines: G2(o, i) / (|o.z| |i.z|).
inline float ggx_shadowing(float alpha, Vec3 o, Vec3 i) {
    const float zo = std::abs(o.z), zi = std::abs(i.z);
    return 2 / (zi * (ggx_smith(alpha, o) - zo) + zo * (ggx_smith(alpha, i) - zi));
}

// Maps a uniform point on the disc to a normal (Heitz, "Sampling the GGX Distribution of Visible Normals",
// 2018).
inline Vec3 ggx_visible_normal(float alpha, Vec3 o, Vec2 disc) {
    const Vec3 stretched = normalize(Vec3{alpha * o.x, alpha * o.y, o.z});
    const float squared = stretched.x * stretched.x + stretched.y * stretched.y;
    const Vec3 t1 =
        squared > 0 ? (1 / std::sqrt(squared)) * Vec3{-stretched.y, stretched.x, 0} : Vec3{1, 0, 0};
    const Vec3 t2 = cross(stretched, t1);
    const float s = 0.5f * (1 + stretched.z);
    const float x = disc.x;
    const float y = (1 - s) * std::sqrt(std::max(0.0f, 1 - x * x)) + s * disc.y;
    const float z = std::sqrt(std::max(0.0f, 1 - x * x - y * y));
    const Vec3 h = x * t1 + y * t2 + z * stretched;
    return normalize(Vec3{alpha * h.x, alpha * h.y, std::max(h.z, 1e-6f)});
}

// The fraction of light reflected. eta: index of refraction of the far side over the near side.
inline float fresnel_dielectric(float cosine, float eta) {
    const float squared_sine = (1 - cosine * cosine) / (eta * eta);
    if (squared_sine >= 1) return 1; // total internal reflection
    const float far_cosine = std::sqrt(1 - squared_sine);
    const float parallel = (eta * cosine - far_cosine) / (eta * cosine + far_cosine);
    const float perpendicular = (cosine - eta * far_cosine) / (cosine + eta * far_cosine);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// Refracts o through a facet of normal h. Returns false on total internal reflection.
inline bool refract(Vec3 o, Vec3 h, float eta, Vec3 &wi) {
    const float cosine = dot(o, h);
    const float squared_sine = (1 - cosine * cosine) / (eta * eta);
    if (squared_sine >= 1) return false;
    const float far_cosine = std::sqrt(1 - squared_sine);
    wi = normalize((-1 / eta) * o + (cosine / eta - far_cosine) * h);
    return true;
}

// Schlick's Fresnel term at this cosine, for a reflectance of 0 at normal incidence.
inline float schlick_edge(float cosine) {
    const float c = 1 - std::min(std::max(cosine, 0.0f), 1.0f);
    const float s = c * c;
    return s * s * c;
}

// ---- Tables of the energy that microfacets preserve in single scattering, indexed by the square root
// of the cosine, because it changes most at small cosines.

using EnergyTable = DielectricEnergy::Table;
constexpr int ENERGY_SIZE = DielectricEnergy::SIZE;
constexpr float LEAST_LOSS = 1e-3f; // mean over the hemisphere; less is ignored

// Looks up a table with linear interpolation at `position`, the square root of a cosine.
inline float interpolate(const EnergyTable &table, float position) {
    const float at = std::min(std::max(position, 0.0f), 1.0f) * (ENERGY_SIZE - 1);
    const auto below = size_t(std::min(int(at), ENERGY_SIZE - 2));
    return glm::mix(table[below], table[below + 1], at - float(below));
}

// For conductors with a white Fresnel term.
struct ConductorTable {
    std::array<EnergyTable, ENERGY_SIZE> energy; // [roughness][root of cosine]
    EnergyTable mean_loss;                       // [roughness]
    // Like `energy`, but with Schlick's Fresnel term for a reflectance of 0, and its mean.
    std::array<EnergyTable, ENERGY_SIZE> edge;
    EnergyTable mean_edge;
};

const ConductorTable &conductor_table();

struct ConductorRow {
    size_t row;
    float t; // from it to the next

    explicit ConductorRow(float roughness) {
        const float at = std::min(roughness, 1.0f) * (ENERGY_SIZE - 1);
        row = size_t(std::min(int(at), ENERGY_SIZE - 2));
        t = at - float(row);
    }
    float mean(const EnergyTable &of) const { return glm::mix(of[row], of[row + 1], t); }
};
