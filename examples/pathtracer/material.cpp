// SPDX-License-Identifier: Apache-2.0
// GGX conductors, dielectrics, and the metallic-roughness material of glTF.
//
// A wide lobe adds back multiple scattering (Kulla and Conty, "Revisiting Physically Based Shading at
// Imageworks", 2017): the energy loss in direction o times the loss in direction i, tabulated at
// start-up. Rough materials are sampled as a mixture of both lobes, where the loss is the wide lobe's
// probability. Conductors use Schlick's Fresnel term.
#include "material.h"

#include "medium.h"
#include "microfacet.h"

namespace {

// ---- Metal, blended with a coated diffuse base. Schlick's formula is linear in its reflectance, so
// one GGX lobe serves both. The base is scaled by the coat's transmission towards the light and towards
// the eye, normalised by the mean (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled
// Specular-Matte BRDF Model", 2001), so white stays white for any blend.

// The colour of multiply scattered light: a geometric series in which every facet reflects the mean
// Fresnel term, and a share mean_loss of that light hits another facet.
Vec3 multiple_colour(Vec3 albedo, float edge, float mean_loss) {
    if (mean_loss < LEAST_LOSS) return Vec3(0);
    const Vec3 mean = albedo + (edge - albedo) / 21.0f;
    return mean * mean * (1 - mean_loss) / (1.0f - mean * mean_loss);
}

// A material, with the tables interpolated at its roughness.
struct Mixture : ConductorRow {
    float metallic, alpha;
    Vec3 reflectance;    // at normal incidence
    float grazing;       // reflectance at grazing angles
    Vec3 multiple;       // colour of multiple scattering
    float mean_loss;     // mean energy loss of facets
    float coat = 0;      // reflectance of the coat alone, at normal incidence
    float coat_edge;     // and at grazing angles
    float coat_multiple; // colour of its multiple scattering
    float mean_left;     // mean share that the coat leaves to the base
    Vec3 ground;         // albedo of the base, over mean_left

    explicit Mixture(const Material &m)
        : ConductorRow(std::clamp(m.roughness, SMOOTH, 1.0f)), metallic(m.metallic) {
        const float roughness = std::clamp(m.roughness, SMOOTH, 1.0f);
        alpha = roughness * roughness;
        mean_loss = mean(conductor_table().mean_loss);
        const float mean_edge = mean(conductor_table().mean_edge);
        const float root = (m.ior - 1) / (m.ior + 1);
        coat = root * root;
        coat_edge = m.coat_edge;
        coat_multiple = multiple_colour(Vec3(coat), coat_edge, mean_loss).x;
        mean_left = std::max(1 - coat * (1 - mean_loss - mean_edge) - coat_edge * mean_edge -
                                 coat_multiple * mean_loss,
                             1e-4f);
        grazing = 1 - (1 - metallic) * (1 - coat_edge);
        reflectance = metallic * m.albedo + (1 - metallic) * coat * m.coat_colour;
        multiple =
            metallic * multiple_colour(m.albedo, 1, mean_loss) + (1 - metallic) * coat_multiple;
        ground = ((1 - metallic) / mean_left) * m.albedo;
    }
};

// The energy that facets lose in single scattering.
float loss(const Mixture &x, float cosine) {
    if (x.mean_loss < LEAST_LOSS) return 0;
    const float root = std::sqrt(std::abs(cosine));
    const EnergyTable *rows = &conductor_table().energy[x.row];
    return std::max(0.0f,
                    1 - (1 - x.t) * interpolate(rows[0], root) - x.t * interpolate(rows[1], root));
}

// The share of reflected light that Schlick's formula adds at any reflectance.
float edge_at(const Mixture &x, float cosine) {
    const float root = std::sqrt(std::abs(cosine));
    const EnergyTable *rows = &conductor_table().edge[x.row];
    return glm::mix(interpolate(rows[0], root), interpolate(rows[1], root), x.t);
}

// The share of light that the coat transmits to the base.
float left(const Mixture &x, float cosine) {
    const float lost = loss(x, cosine), edge = edge_at(x, cosine);
    return std::max(0.0f,
                    1 - x.coat * (1 - lost - edge) - x.coat_edge * edge - x.coat_multiple * lost);
}

// The probability of sampling the cosine lobe: metal's energy loss, or the share of light that facets
// do not reflect.
float wide_share(const Mixture &x, float cosine) {
    const float lost = loss(x, cosine);
    if (x.metallic == 1) return lost;
    const float edge = edge_at(x, cosine);
    const float facets = luminance(x.reflectance) * (1 - lost - edge) + x.grazing * edge;
    const float rest =
        luminance(x.ground) * left(x, cosine) * x.mean_left + luminance(x.multiple) * lost;
    return rest > 0 ? std::clamp(rest / (facets + rest), 0.01f, 0.9f) : 0;
}

// `grazing`: the reflectance at grazing angles.
Vec3 fresnel_schlick(Vec3 reflectance, float grazing, float cosine) {
    return clamp(reflectance + (grazing - reflectance) * schlick_edge(cosine), 0.0f, 1.0f);
}

MaterialValue mixture_value(const Material &m, Vec3 wo, Vec3 wi) {
    const Mixture x(m);
    const Vec3 h = normalize_or(wo + wi, {0, 0, 1});
    const float density = ggx_density(x.alpha, h);
    const float facets = 0.25f * density * ggx_shadowing(x.alpha, wo, wi) * wi.z;
    const float share = wide_share(x, wo.z);
    const float wide =
        x.mean_loss >= LEAST_LOSS ? loss(x, wo.z) * loss(x, wi.z) * wi.z / (PI * x.mean_loss) : 0;
    Vec3 eval = facets * fresnel_schlick(x.reflectance, x.grazing, dot(wo, h)) + wide * x.multiple;
    if (x.metallic < 1) eval += left(x, wo.z) * left(x, wi.z) * wi.z / PI * x.ground;
    return {eval, (1 - share) * 0.25f * ggx_masking(x.alpha, wo) * density + share * wi.z / PI};
}

// ---- Dielectrics

float relative_ior(const Material &m, bool front) {
    return front ? m.ior : 1 / m.ior;
}

float loss(const Material &m, bool front, float cosine) {
    return std::max(0.0f,
                    1 - interpolate(m.energy->kept[front ? 0 : 1], std::sqrt(std::abs(cosine))));
}

MaterialValue dielectric_value(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    const bool reflected = wi.z > 0;
    const float eta = relative_ior(m, front), alpha = m.roughness * m.roughness;
    float facets = 0, facet_pdf = 0;
    // The facet that scatters light from `wi` to `wo`, if there is one.
    Vec3 h = normalize_or(reflected ? wo + wi : wo + eta * wi, {0, 0, 1});
    if (h.z < 0) h = -h;
    const float wo_h = dot(wo, h), wi_h = dot(wi, h);
    if (wo_h > 0 && (wi_h > 0) == reflected) {
        const float fresnel = fresnel_dielectric(wo_h, eta), sum = wo_h + eta * wi_h;
        const float chosen = reflected ? fresnel : 1 - fresnel;
        // From directions to facet normals: dh/dwi.
        const float jacobian =
            reflected ? 1 / (4 * wo_h) : eta * eta * std::abs(wi_h) / (sum * sum);
        const float density = ggx_density(alpha, h);
        facets = chosen * density * ggx_shadowing(alpha, wo, wi) * std::abs(wi.z) * wo_h * jacobian;
        // The density of the normals visible from `wo`: G1(wo) max(0, wo.h) D(h) / wo.z.
        facet_pdf = chosen * (ggx_masking(alpha, wo) * wo_h * density) * jacobian;
    }
    const int near = front ? 0 : 1, far = reflected ? near : 1 - near;
    const float passed = m.energy->passed_loss[near], mean_loss = m.energy->mean_loss[far];
    const float share = reflected ? 1 - passed : passed, lost = loss(m, front, wo.z);
    const float wide =
        mean_loss > 0 ? share * lost * loss(m, far == 0, wi.z) * std::abs(wi.z) / (PI * mean_loss)
                      : 0;
    return {(facets + wide) * (reflected ? Vec3{1, 1, 1} : m.albedo),
            (1 - lost) * facet_pdf + lost * share * std::abs(wi.z) / PI};
}

// ---- Sampling

MaterialSample sample_smooth(const Material &m, bool front, Vec3 wo, float lobe) {
    const Vec3 mirrored = {-wo.x, -wo.y, wo.z};
    if (m.kind == Material::METALLIC_ROUGHNESS)
        return {mirrored, fresnel_schlick(m.albedo, 1, wo.z), 1};
    if (std::abs(m.ior - 1) < SAME_IOR) return {-wo, m.albedo, 1};
    const float eta = relative_ior(m, front);
    const float fresnel = fresnel_dielectric(wo.z, eta);
    if (lobe < fresnel) return {mirrored, {1, 1, 1}, fresnel};
    Vec3 wi;
    if (!refract(wo, {0, 0, 1}, eta, wi)) return {};
    return {wi, m.albedo, 1 - fresnel};
}

bool sample_rough(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe, Vec3 &wi) {
    const bool metal = m.kind == Material::METALLIC_ROUGHNESS;
    const float wide = metal ? wide_share(Mixture(m), wo.z) : loss(m, front, wo.z);
    if (u.x < wide) {
        wi = square_to_cosine_hemisphere({u.x / wide, u.y});
        if (!metal && lobe < m.energy->passed_loss[front ? 0 : 1]) wi.z = -wi.z;
        return true;
    }
    const Vec3 h = ggx_visible_normal(m.roughness * m.roughness, wo,
                                      square_to_disc({(u.x - wide) / (1 - wide), u.y}));
    const float cosine = dot(wo, h);
    if (!(cosine > 0)) return false;
    const float eta = relative_ior(m, front);
    if (metal || lobe < fresnel_dielectric(cosine, eta)) {
        wi = normalize(2 * cosine * h - wo);
        return wi.z > 0;
    }
    return refract(wo, h, eta, wi) && wi.z < 0;
}

// ---- Tables of the energy that microfacets preserve in single scattering

constexpr int RINGS = 40, SECTORS = 12; // facets integrated per table entry

Vec3 direction_of_entry(size_t entry) {
    const float root = float(entry) / (ENERGY_SIZE - 1), cosine = std::max(root * root, 1e-4f);
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// The share of light that a visible facet scatters from o to `wi`: G2 / G1.
float kept(float alpha, Vec3 o, Vec3 wi) {
    return std::abs(wi.z) * ggx_shadowing(alpha, o, wi) / ggx_masking(alpha, o);
}

// The mean of a function over the normals visible from o. The important facets are at the rim of the
// disc, so the rings are thinner there.
template <typename Function>
Vec2 mean_over_normals(float alpha, Vec3 o, const Function &function) {
    glm::dvec2 sum(0);
    double weights = 0;
    for (int ring = 0; ring < RINGS; ++ring) {
        const float v = (float(ring) + 0.5f) / RINGS;
        const float radius = std::sqrt(1 - v * v * v);
        for (int sector = 0; sector < SECTORS; ++sector) {
            // The two halves of the disc are mirror images; one is enough.
            const float angle = PI * ((float(sector) + 0.5f) / SECTORS - 0.5f);
            const Vec2 disc = {radius * std::cos(angle), radius * std::sin(angle)};
            const double weight = double(v * v);
            sum += weight * glm::dvec2(function(ggx_visible_normal(alpha, o, disc)));
            weights += weight;
        }
    }
    return sum / weights;
}

// The cosine-weighted mean. Between entries the table is linear in the root, as in interpolate().
float hemispherical_mean(const EnergyTable &table) {
    const int steps = 8 * ENERGY_SIZE;
    double sum = 0, weight = 0;
    for (int i = 0; i < steps; ++i) {
        const double root = (i + 0.5) / steps;
        const double w = root * root * root; // cosine times the derivative of the cosine
        sum += w * double(interpolate(table, float(root)));
        weight += w;
    }
    return float(sum / weight);
}

} // namespace

const ConductorTable &conductor_table() {
    static const ConductorTable table = [] {
        ConductorTable t;
        for (size_t r = 0; r < ENERGY_SIZE; ++r) {
            const float roughness = std::max(float(r) / (ENERGY_SIZE - 1), SMOOTH);
            const float alpha = roughness * roughness;
            for (size_t c = 0; c < ENERGY_SIZE; ++c) {
                const Vec3 o = direction_of_entry(c);
                const Vec2 mean = mean_over_normals(alpha, o, [&](Vec3 h) {
                    const Vec3 wi = 2 * dot(o, h) * h - o;
                    const float all = wi.z > 0 ? kept(alpha, o, wi) : 0;
                    return Vec2(all, schlick_edge(dot(o, h)) * all);
                });
                t.energy[r][c] = mean.x;
                t.edge[r][c] = mean.y;
            }
            t.mean_loss[r] = 1 - hemispherical_mean(t.energy[r]);
            t.mean_edge[r] = hemispherical_mean(t.edge[r]);
        }
        return t;
    }();
    return table;
}

void material_prepare(Material &m) {
    if (m.kind != Material::DIELECTRIC || material_is_smooth(m)) return;
    const auto energy = std::make_shared<DielectricEnergy>();
    DielectricEnergy &e = *energy;
    m.energy = energy;
    const float alpha = m.roughness * m.roughness;
    float passed[2];
    for (int side = 0; side < 2; ++side) {
        const float eta = side == 0 ? m.ior : 1 / m.ior;
        EnergyTable transmitted;
        for (size_t c = 0; c < ENERGY_SIZE; ++c) {
            const Vec3 o = direction_of_entry(c);
            transmitted[c] = 1 - fresnel_dielectric(o.z, eta);
            const Vec2 mean = mean_over_normals(alpha, o, [&](Vec3 h) {
                const float fresnel = fresnel_dielectric(std::max(0.0f, dot(o, h)), eta);
                const Vec3 mirrored = 2 * dot(o, h) * h - o;
                Vec3 refracted;
                float sum = mirrored.z > 0 ? fresnel * kept(alpha, o, mirrored) : 0;
                if (refract(o, h, eta, refracted) && refracted.z < 0)
                    sum += (1 - fresnel) * kept(alpha, o, refracted);
                return Vec2(sum, 0);
            });
            e.kept[side][c] = mean.x;
        }
        e.mean_loss[side] = 1 - hemispherical_mean(e.kept[side]);
        passed[side] = hemispherical_mean(transmitted);
    }
    const float larger = std::max(e.mean_loss[0], e.mean_loss[1]);
    if (std::min(e.mean_loss[0], e.mean_loss[1]) < LEAST_LOSS) {
        for (int side = 0; side < 2; ++side) {
            e.kept[side].fill(1);
            e.mean_loss[side] = e.passed_loss[side] = 0;
        }
        return;
    }
    // Reciprocity fixes the ratio of the two shares.
    passed[1] = passed[0] / (m.ior * m.ior);
    e.passed_loss[0] = passed[0] * e.mean_loss[1] / larger;
    e.passed_loss[1] = passed[1] * e.mean_loss[0] / larger;
}

MaterialValue specular_value(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (material_is_smooth(m) || wi.z == 0) return {{0, 0, 0}, 0};
    if (m.kind == Material::PHASE) {
        const float pdf = phase_pdf(m.anisotropy, wi);
        return {pdf * m.albedo, pdf};
    }
    if (m.kind == Material::DIELECTRIC) return dielectric_value(m, front, wo, wi);
    if (!(wi.z > 0)) return {{0, 0, 0}, 0};
    return mixture_value(m, wo, wi);
}

MaterialSample specular_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe) {
    if (material_is_smooth(m)) return sample_smooth(m, front, wo, u.x);
    if (m.kind == Material::PHASE) {
        const Vec3 wi = phase_sample(m.anisotropy, u);
        return {wi, m.albedo, phase_pdf(m.anisotropy, wi)};
    }
    Vec3 wi;
    if (!sample_rough(m, front, wo, u, lobe, wi)) return {};
    const auto [eval, pdf] = specular_value(m, front, wo, wi);
    if (!(pdf > 0) || !std::isfinite(pdf)) return {};
    return {wi, (1 / pdf) * eval, pdf};
}
