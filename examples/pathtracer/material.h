// SPDX-License-Identifier: Apache-2.0
// Surface scattering: three functions, eval, sample and pdf, with a case for each kind of material.
//
// Directions are unit vectors that point away from the surface, in a local frame whose +z is the
// normal on the side of `wo`. `wo` points along the path back to the camera, `wi` to where the
// light comes from. Densities are per steradian. `front` says whether `wo` is on the front of the
// surface.
//
// Paths carry radiance over the squared index of refraction, which is constant along a refracted
// ray. So dielectrics need no factor for the compression of radiance in the denser medium, and
// lights look as bright inside glass as in air.
#pragma once

#include <cstdint>
#include <memory>

#include "math.h"

// How much light a single reflection or transmission by the microfacets of a rough dielectric
// keeps, from the front [0] and from the back [1].
struct DielectricEnergy {
    static constexpr int SIZE = 32;
    float kept[2][SIZE];  // by the root of the cosine
    float mean_loss[2];   // 1 - the mean of `kept` over the hemisphere
    float passed_loss[2]; // the share of what is lost that comes out on the other side
};

struct Material {
    enum Kind : uint32_t {
        DIFFUSE,           // Lambert, on both sides alike
        CONDUCTOR,         // metal: GGX, on both sides alike
        DIELECTRIC,        // glass: GGX, reflects and transmits; the back is the inside
        METALLIC_ROUGHNESS // of glTF: from a coat of GGX over Lambert to metal, on both sides alike
    };
    Kind kind = DIFFUSE;
    Vec3 albedo = {0.5f, 0.5f, 0.5f}; // DIFFUSE: reflectance. CONDUCTOR: reflectance seen straight.
                                      // DIELECTRIC: what is left of light that passes.
                                      // METALLIC_ROUGHNESS: the base colour
    Vec3 edge = {1, 1, 1};            // CONDUCTOR: reflectance at 82 degrees over Schlick's
    float roughness = 0; // in [0, 1]; alpha is its square. Below SMOOTH: a mirror, but for
                         // METALLIC_ROUGHNESS, which stays at SMOOTH
    float metallic = 0;  // METALLIC_ROUGHNESS: the share of metal, in [0, 1]
    float ior = 1.5f;    // index of refraction of the inside over the outside. DIELECTRIC, and the
                         // coat of METALLIC_ROUGHNESS
    bool single_sided = false;   // the camera does not see its back
    bool single_scatter = false; // what rough facets scatter more than once stays lost
    int32_t maps = -1;           // what differs from place to place: index into Scene::maps, or -1

    std::shared_ptr<const DielectricEnergy> energy; // DIELECTRIC, rough: see material_prepare
};

// Below this roughness a surface is a mirror: float directions are not precise enough for its
// microfacets.
constexpr float SMOOTH = 0.01f;
// An index of refraction this close to 1 does not refract.
constexpr float SAME_IOR = 1e-3f;

// Call this once for each material before using it: it makes the tables of rough dielectrics.
void material_prepare(Material &material);

// Whether the material scatters into discrete directions only. Then eval and pdf are 0, and samples
// are marked as smooth.
inline bool material_is_smooth(const Material &m) {
    const bool specular = m.kind == Material::CONDUCTOR || m.kind == Material::DIELECTRIC;
    return (specular && m.roughness < SMOOTH) ||
           (m.kind == Material::DIELECTRIC && std::abs(m.ior - 1) < SAME_IOR);
}

struct MaterialSample {
    Vec3 wi;
    Vec3 weight; // eval / pdf
    float pdf;   // 0: no direction was found and the path ends
    bool smooth; // pdf is a probability, and nothing else finds this direction
};

// The same three for all kinds but the diffuse.
Vec3 specular_eval(const Material &m, bool front, Vec3 wo, Vec3 wi);
float specular_pdf(const Material &m, bool front, Vec3 wo, Vec3 wi);
MaterialSample specular_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe);

// The scattering function times the cosine of `wi`.
inline Vec3 material_eval(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (m.kind != Material::DIFFUSE) return specular_eval(m, front, wo, wi);
    return (std::max(0.0f, wi.z) / PI) * m.albedo;
}

// The density with which material_sample chooses `wi`.
inline float material_pdf(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (m.kind != Material::DIFFUSE) return specular_pdf(m, front, wo, wi);
    return std::max(0.0f, wi.z) / PI;
}

// Lobes are chosen by u.x, which is then stretched over the lobe. Rough glass alone cannot: its
// Fresnel term depends on the facet that u chose, so `lobe` decides between reflection and
// transmission there.
inline MaterialSample material_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe) {
    if (m.kind != Material::DIFFUSE) return specular_sample(m, front, wo, u, lobe);
    const Vec3 wi = square_to_cosine_hemisphere(u);
    return {wi, m.albedo, wi.z / PI, false};
}

// The approximate albedo, for the albedo layer. White for glass.
inline Vec3 material_albedo(const Material &m) {
    return m.kind == Material::DIELECTRIC ? Vec3{1, 1, 1} : m.albedo;
}

inline bool material_reads_lobe(const Material &m) {
    return m.kind == Material::DIELECTRIC && !material_is_smooth(m);
}
