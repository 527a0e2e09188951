// SPDX-License-Identifier: Apache-2.0
// GGX conductors and dielectrics; mixture.cpp has the metallic-roughness material of glTF.
//
// Microfacet formulas lose the light that scatters more than once. A wide lobe adds it back (Kulla
// and Conty, "Revisiting Physically Based Shading at Imageworks", 2017): the loss in direction o
// times the loss in direction i, which is reciprocal and restores exactly what was lost. The losses
// are tabulated at start-up: for conductors over cosine and roughness, with a white Fresnel term;
// for each rough dielectric over cosine. Rough materials are sampled as the mixture of both lobes,
// the wide one with the probability of the loss.
//
// Conductor Fresnel: Schlick's, with a tint towards grazing (Kutz et al., "Novel aspects of the
// Adobe Standard Material", 2021).
#include "material.h"

#include "facet_energy.h"
#include "medium.h"
#include "microfacet.h"

using namespace facet_energy;

namespace {

float alpha_of(const Material &m) {
    return m.roughness * m.roughness;
}

// ---- Conductors

// The energy tables interpolated to a material's roughness.
struct ConductorEnergy {
    const float *low, *high;
    float t;
    float mean_loss;
};

ConductorEnergy conductor_energy(const Material &m) {
    const ConductorTable &table = conductor_table();
    const float at = std::min(m.roughness, 1.0f) * (SIZE - 1);
    const auto below = static_cast<size_t>(std::min(static_cast<int>(at), SIZE - 2));
    const float t = at - static_cast<float>(below);
    return {table.energy[below].data(), table.energy[below + 1].data(), t,
            m.single_scatter ? 0
                             : (1 - t) * table.mean_loss[below] + t * table.mean_loss[below + 1]};
}

float loss(const ConductorEnergy &e, float cosine) {
    if (e.mean_loss < LEAST_LOSS) return 0;
    const float root = std::sqrt(std::abs(cosine));
    return std::max(0.0f,
                    1 - (1 - e.t) * interpolate(e.low, root) - e.t * interpolate(e.high, root));
}

Vec3 fresnel_conductor(const Material &m, float cosine) {
    // `edge` scales Schlick's reflectance at 82 degrees, cosine 1/7; the tint term subtracts the
    // rest.
    const float at_edge = 1.0f / 7;
    const float grazing = std::pow(1 - at_edge, 5.0f);
    const float scale = 1 / (at_edge * std::pow(1 - at_edge, 6.0f));
    const float c = std::min(std::max(cosine, 0.0f), 1.0f);
    const float s = (1 - c) * (1 - c), fifth = s * s * (1 - c);
    const auto one = [&](float f0, float edge) {
        const float tint = (f0 + (1 - f0) * grazing) * (1 - edge) * scale;
        return std::min(std::max(f0 + (1 - f0) * fifth - tint * c * fifth * (1 - c), 0.0f), 1.0f);
    };
    return {one(m.albedo.x, m.edge.x), one(m.albedo.y, m.edge.y), one(m.albedo.z, m.edge.z)};
}

// The Fresnel term of multiply scattered light: a geometric series in which every facet reflects
// the mean Fresnel term and a share mean_loss of that hits another facet.
Vec3 fresnel_multiple(const Material &m, float mean_loss) {
    const float grazing = std::pow(6.0f / 7, 5.0f), scale = 7 / std::pow(6.0f / 7, 6.0f);
    const auto one = [&](float f0, float edge) {
        const float tint = (f0 + (1 - f0) * grazing) * (1 - edge) * scale;
        const float mean = std::max(f0 + (1 - f0) / 21 - tint / 126, 0.0f);
        return mean * mean * (1 - mean_loss) / (1 - mean * mean_loss);
    };
    return {one(m.albedo.x, m.edge.x), one(m.albedo.y, m.edge.y), one(m.albedo.z, m.edge.z)};
}

Vec3 conductor_eval(const Material &m, Vec3 wo, Vec3 wi) {
    const float alpha = alpha_of(m);
    const Vec3 h = normalize_or(wo + wi, {0, 0, 1});
    const float facets = 0.25f * ggx_density(alpha, h) * ggx_shadowing(alpha, wo, wi) * wi.z;
    const ConductorEnergy e = conductor_energy(m);
    const float wide =
        e.mean_loss >= LEAST_LOSS ? loss(e, wo.z) * loss(e, wi.z) * wi.z / (PI * e.mean_loss) : 0;
    return facets * fresnel_conductor(m, dot(wo, h)) + wide * fresnel_multiple(m, e.mean_loss);
}

float conductor_pdf(const Material &m, Vec3 wo, Vec3 wi) {
    const float alpha = alpha_of(m);
    const Vec3 h = normalize_or(wo + wi, {0, 0, 1});
    const float wide = loss(conductor_energy(m), wo.z);
    return (1 - wide) * 0.25f * ggx_masking(alpha, wo) * ggx_density(alpha, h) + wide * wi.z / PI;
}

MaterialSample nothing() {
    return {{0, 0, 1}, {0, 0, 0}, 0, false};
}

// ---- Dielectrics

float relative_ior(const Material &m, bool front) {
    return front ? m.ior : 1 / m.ior;
}

float loss(const Material &m, bool front, float cosine) {
    return std::max(0.0f,
                    1 - interpolate(m.energy->kept[front ? 0 : 1], std::sqrt(std::abs(cosine))));
}

// The facet that scatters light from `wi` to `wo`. False if there is none.
bool dielectric_facet(Vec3 wo, Vec3 wi, float eta, Vec3 &h) {
    h = normalize_or(wi.z > 0 ? wo + wi : wo + eta * wi, {0, 0, 1});
    if (h.z < 0) h = -h;
    return dot(wo, h) > 0 && (dot(wi, h) > 0) == (wi.z > 0);
}

// The Jacobian from directions to facet normals: dh/dwi.
float dielectric_jacobian(Vec3 wo, Vec3 wi, Vec3 h, float eta) {
    const float wo_h = dot(wo, h), wi_h = dot(wi, h);
    if (wi.z > 0) return 1 / (4 * wo_h);
    const float sum = wo_h + eta * wi_h;
    return eta * eta * std::abs(wi_h) / (sum * sum);
}

Vec3 dielectric_eval(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    const bool reflected = wi.z > 0;
    const float eta = relative_ior(m, front), alpha = alpha_of(m);
    float facets = 0;
    Vec3 h;
    if (dielectric_facet(wo, wi, eta, h)) {
        const float fresnel = fresnel_dielectric(dot(wo, h), eta);
        facets = (reflected ? fresnel : 1 - fresnel) * ggx_density(alpha, h) *
                 ggx_shadowing(alpha, wo, wi) * std::abs(wi.z) * dot(wo, h) *
                 dielectric_jacobian(wo, wi, h, eta);
    }
    const int near = front ? 0 : 1, far = reflected ? near : 1 - near;
    const float passed = m.energy->passed_loss[near], mean_loss = m.energy->mean_loss[far];
    const float share = reflected ? 1 - passed : passed;
    const float wide = mean_loss > 0 ? share * loss(m, front, wo.z) * loss(m, far == 0, wi.z) *
                                           std::abs(wi.z) / (PI * mean_loss)
                                     : 0;
    return (facets + wide) * (reflected ? Vec3{1, 1, 1} : m.albedo);
}

float dielectric_pdf(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    const bool reflected = wi.z > 0;
    const float eta = relative_ior(m, front), alpha = alpha_of(m);
    const float wide = loss(m, front, wo.z);
    const float passed = m.energy->passed_loss[front ? 0 : 1];
    float facets = 0;
    Vec3 h;
    if (dielectric_facet(wo, wi, eta, h)) {
        const float fresnel = fresnel_dielectric(dot(wo, h), eta);
        facets = (reflected ? fresnel : 1 - fresnel) * ggx_visible_density(alpha, wo, h) *
                 dielectric_jacobian(wo, wi, h, eta);
    }
    return (1 - wide) * facets + wide * (reflected ? 1 - passed : passed) * std::abs(wi.z) / PI;
}

// ---- Sampling

MaterialSample sample_smooth(const Material &m, bool front, Vec3 wo, float lobe) {
    const Vec3 mirrored = {-wo.x, -wo.y, wo.z};
    if (m.kind == Material::CONDUCTOR) return {mirrored, fresnel_conductor(m, wo.z), 1, true};
    if (std::abs(m.ior - 1) < SAME_IOR) return {-wo, m.albedo, 1, true};
    const float eta = relative_ior(m, front);
    const float fresnel = fresnel_dielectric(wo.z, eta);
    if (lobe < fresnel) return {mirrored, {1, 1, 1}, fresnel, true};
    Vec3 wi;
    if (!refract(wo, {0, 0, 1}, eta, wi)) return nothing();
    return {wi, m.albedo, 1 - fresnel, true};
}

// Samples a direction from a rough material's mixture of lobes.
bool sample_rough(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe, Vec3 &wi) {
    const bool metal = m.kind == Material::CONDUCTOR;
    const float wide = metal ? loss(conductor_energy(m), wo.z) : loss(m, front, wo.z);
    if (u.x < wide) {
        wi = square_to_cosine_hemisphere({u.x / wide, u.y});
        if (!metal && lobe < m.energy->passed_loss[front ? 0 : 1]) wi.z = -wi.z;
        return true;
    }
    const Vec3 h =
        ggx_visible_normal(alpha_of(m), wo, square_to_disc({(u.x - wide) / (1 - wide), u.y}));
    const float cosine = dot(wo, h);
    if (!(cosine > 0)) return false;
    const float eta = relative_ior(m, front);
    if (metal || lobe < fresnel_dielectric(cosine, eta)) {
        wi = normalize(2 * cosine * h - wo);
        return wi.z > 0;
    }
    return refract(wo, h, eta, wi) && wi.z < 0;
}

} // namespace

void material_prepare(Material &m) {
    if (m.kind != Material::DIELECTRIC || material_is_smooth(m)) return;
    const auto energy = std::make_shared<DielectricEnergy>();
    DielectricEnergy &e = *energy;
    m.energy = energy;
    const float alpha = alpha_of(m);
    float passed[2];
    for (int side = 0; side < 2; ++side) {
        const float eta = relative_ior(m, side == 0);
        float transmitted[SIZE];
        for (int c = 0; c < SIZE; ++c) {
            const float cosine = cosine_of_entry(c);
            const Vec3 o = direction_of_cosine(cosine);
            transmitted[c] = 1 - fresnel_dielectric(cosine, eta);
            e.kept[side][c] = mean_over_normals(alpha, o, [&](Vec3 h) {
                const float fresnel = fresnel_dielectric(std::max(0.0f, dot(o, h)), eta);
                const Vec3 mirrored = 2 * dot(o, h) * h - o;
                Vec3 refracted;
                float sum = mirrored.z > 0 ? fresnel * kept(alpha, o, mirrored) : 0;
                if (refract(o, h, eta, refracted) && refracted.z < 0)
                    sum += (1 - fresnel) * kept(alpha, o, refracted);
                return sum;
            });
        }
        e.mean_loss[side] = 1 - hemispherical_mean(e.kept[side]);
        passed[side] = hemispherical_mean(transmitted);
    }
    const float larger = std::max(e.mean_loss[0], e.mean_loss[1]);
    if (m.single_scatter || std::min(e.mean_loss[0], e.mean_loss[1]) < LEAST_LOSS) {
        for (int side = 0; side < 2; ++side) {
            std::fill(e.kept[side], e.kept[side] + SIZE, 1.0f);
            e.mean_loss[side] = e.passed_loss[side] = 0;
        }
        return;
    }
    // Reciprocity fixes the ratio of the two shares. Each is proportional to the far side's mean
    // loss times the mean transmittance of a smooth interface, and those transmittances differ by
    // the squared index of refraction.
    passed[1] = passed[0] / (m.ior * m.ior);
    e.passed_loss[0] = passed[0] * e.mean_loss[1] / larger;
    e.passed_loss[1] = passed[1] * e.mean_loss[0] / larger;
}

Vec3 specular_eval(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (material_is_smooth(m) || wi.z == 0) return {0, 0, 0};
    if (m.kind == Material::PHASE) return phase_pdf(m.anisotropy, wi) * m.albedo;
    if (m.kind == Material::DIELECTRIC) return dielectric_eval(m, front, wo, wi);
    if (m.kind == Material::METALLIC_ROUGHNESS)
        return wi.z > 0 ? mixture_value(m, wo, wi).eval : Vec3{0, 0, 0};
    return wi.z > 0 ? conductor_eval(m, wo, wi) : Vec3{0, 0, 0};
}

float specular_pdf(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (material_is_smooth(m) || wi.z == 0) return 0;
    if (m.kind == Material::PHASE) return phase_pdf(m.anisotropy, wi);
    if (m.kind == Material::DIELECTRIC) return dielectric_pdf(m, front, wo, wi);
    if (m.kind == Material::METALLIC_ROUGHNESS) return wi.z > 0 ? mixture_value(m, wo, wi).pdf : 0;
    return wi.z > 0 ? conductor_pdf(m, wo, wi) : 0;
}

MaterialSample specular_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe) {
    if (material_is_smooth(m)) return sample_smooth(m, front, wo, u.x);
    if (m.kind == Material::METALLIC_ROUGHNESS) return mixture_sample(m, wo, u);
    if (m.kind == Material::PHASE) {
        const Vec3 wi = phase_sample(m.anisotropy, u);
        return {wi, m.albedo, phase_pdf(m.anisotropy, wi), false};
    }
    Vec3 wi;
    if (!sample_rough(m, front, wo, u, lobe, wi)) return nothing();
    const float pdf = specular_pdf(m, front, wo, wi);
    if (!(pdf > 0) || !std::isfinite(pdf)) return nothing();
    return {wi, (1 / pdf) * specular_eval(m, front, wo, wi), pdf, false};
}
