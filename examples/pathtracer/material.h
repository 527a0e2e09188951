// SPDX-License-Identifier: Apache-2.0
// Surface scattering: value (eval and pdf) and sample, with a case for each material type.
//
// Directions are unit vectors pointing away from the surface, in a local frame whose +z is the normal
// on the side of `wo`, which points back along the path; `wi` points to where light comes from.
// `front` means that `wo` is in front. Densities are per steradian. Paths carry radiance over the
// squared index of refraction, which refraction preserves, so lights look equally bright inside glass.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "math.h"

// The share of light that a rough dielectric's microfacets reflect or transmit in single scattering, from
// the front [0] and from the back [1].
struct DielectricEnergy {
    static constexpr int SIZE = 32;
    using Table = std::array<float, SIZE>;
    Table kept[2];        // indexed by the root of the cosine
    float mean_loss[2];   // 1 - the mean of `kept` over the hemisphere
    float passed_loss[2]; // the share of the loss that leaves on the other side
};

struct Material {
    enum Kind : uint32_t {
        DIFFUSE,            // Lambert, the same on both sides
        METALLIC_ROUGHNESS, // glTF: from GGX-coated Lambert to GGX metal, the same on both sides
        DIELECTRIC,         // glass: GGX, reflects and transmits; the back is the inside
        PHASE               // no surface, but a particle of a medium: medium.h. `wo` is +z
    };
    Kind kind = DIFFUSE;
    Vec3 albedo = {0.5f, 0.5f, 0.5f}; // DIFFUSE: reflectance. METALLIC_ROUGHNESS: base colour.
                                      // DIELECTRIC: transmission tint. PHASE: scattered share
    Vec3 coat_colour = {1, 1, 1};     // METALLIC_ROUGHNESS: times the reflectance from `ior`
    float roughness =
        0; // in [0, 1]; alpha is its square. Below SMOOTH, metal and glass are mirrors,
           // and a coat is as rough as SMOOTH
    float metallic = 1;   // METALLIC_ROUGHNESS: fraction of metal, in [0, 1]
    float ior = 1.5f;     // index of refraction, inside over outside. DIELECTRIC, and the coat of
                          // METALLIC_ROUGHNESS
    float coat_edge = 1;  // METALLIC_ROUGHNESS: the coat's reflectance at grazing angles
    float anisotropy = 0; // PHASE: the mean cosine of the scattering angle
    bool single_sided = false; // the camera does not see its back
    int32_t maps = -1;         // varying properties: index into Scene::maps, or -1

    std::shared_ptr<const DielectricEnergy> energy = {}; // DIELECTRIC, rough: see material_prepare
};

// Below this roughness, surfaces are mirrors: float directions are too coarse for microfacets.
constexpr float SMOOTH = 0.01f;
// An index of refraction this close to 1 does not refract.
constexpr float SAME_IOR = 1e-3f;

// Call this once for each material before use. It builds the tables of rough dielectrics.
void material_prepare(Material &material);

// Whether the material scatters only into discrete directions: the value is 0, samples are smooth.
inline bool material_is_smooth(const Material &m) {
    if (m.kind == Material::METALLIC_ROUGHNESS) return m.metallic == 1 && m.roughness < SMOOTH;
    return m.kind == Material::DIELECTRIC &&
           (m.roughness < SMOOTH || std::abs(m.ior - 1) < SAME_IOR);
}

struct MaterialSample {
    Vec3 wi = {0, 0, 1};
    Vec3 weight = {0, 0, 0}; // eval / pdf
    float pdf = 0;           // 0: no direction found; the path ends. Smooth: a probability
};

// The BSDF times the cosine of `wi`, and the density with which material_sample chooses `wi`.
struct MaterialValue {
    Vec3 eval;
    float pdf;
};

// The same two functions for every type except DIFFUSE.
MaterialValue specular_value(const Material &m, bool front, Vec3 wo, Vec3 wi);
MaterialSample specular_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe);

inline MaterialValue material_value(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (m.kind != Material::DIFFUSE) return specular_value(m, front, wo, wi);
    const float flat = std::max(0.0f, wi.z) / PI;
    return {flat * m.albedo, flat};
}

// u.x chooses the lobe and is then rescaled. Rough glass uses `lobe` instead, because its Fresnel term
// depends on the facet that u chose.
inline MaterialSample material_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe) {
    if (m.kind != Material::DIFFUSE) return specular_sample(m, front, wo, u, lobe);
    const Vec3 wi = square_to_cosine_hemisphere(u);
    return {wi, m.albedo, wi.z / PI};
}
