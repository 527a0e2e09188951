// SPDX-License-Identifier: Apache-2.0
// GGX conductors, dielectrics, and the metallic-roughness material of glTF.
//
//
// A wide lobe adds back multiple scattering (Kulla and Conty, "Revisiting Physically Based Shading at
// Imageworks", 2017): the energy loss in direction o times the loss in direction i, tabulated at
// start-up. Rough materials are sampled as a mixture of both lobes, with the loss as the probability of
// the wide lobe. Conductors use Schlick's Fresnel term.
#include "material.h"

#include "light.h"
#include "medium.h"
#include "microfacet.h"

namespace {

float alpha_of(const Material &m) {
    return m.roughness * m.roughness;
}

// ---- Conductors

// The energy tables interpolated to a material's roughness.
struct ConductorEnergy : ConductorRow {
    float mean_loss;
    explicit ConductorEnergy(const Material &m)
        : ConductorRow(m.roughness), mean_loss(mean(conductor_table().mean_loss)) {}
};

float loss(const ConductorEnergy &e, float cosine) {
    if (e.mean_loss < LEAST_LOSS) return 0;
    const float root = std::sqrt(std::abs(cosine));
    const EnergyTable *rows = &conductor_table().energy[e.row];
    return std::max(0.0f,
                    1 - (1 - e.t) * interpolate(rows[0], root) - e.t * interpolate(rows[1], root));
}

Vec3 fresnel_conductor(const Material &m, float cosine) {
    const float c = std::min(std::max(cosine, 0.0f), 1.0f);
    const float s = (1 - c) * (1 - c), fifth = s * s * (1 - c);
    return clamp(m.albedo + (1.0f - m.albedo) * fifth, 0.0f, 1.0f);
}

// The colour of multiply scattered light: a geometric series in which every facet reflects the mean
// Fresnel term and a share mean_loss of that hits another facet.
Vec3 multiple_colour(Vec3 albedo, float mean_loss) {
    if (mean_loss < LEAST_LOSS) return Vec3(0);
    const Vec3 mean = albedo + (1.0f - albedo) / 21.0f;
    return mean * mean * (1 - mean_loss) / (1.0f - mean * mean_loss);
}

MaterialValue conductor_value(const Material &m, Vec3 wo, Vec3 wi) {
    const float alpha = alpha_of(m);
    const Vec3 h = normalize_or(wo + wi, {0, 0, 1});
    const float density = ggx_density(alpha, h);
    const float facets = 0.25f * density * ggx_shadowing(alpha, wo, wi) * wi.z;
    const ConductorEnergy e(m);
    const float lost = loss(e, wo.z);
    const float wide =
        e.mean_loss >= LEAST_LOSS ? lost * loss(e, wi.z) * wi.z / (PI * e.mean_loss) : 0;
    return {facets * fresnel_conductor(m, dot(wo, h)) +
                wide * multiple_colour(m.albedo, e.mean_loss),
            (1 - lost) * 0.25f * ggx_masking(alpha, wo) * density + lost * wi.z / PI};
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

MaterialValue dielectric_value(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    const bool reflected = wi.z > 0;
    const float eta = relative_ior(m, front), alpha = alpha_of(m);
    float facets = 0, facet_pdf = 0;
    Vec3 h;
    if (dielectric_facet(wo, wi, eta, h)) {
        const float fresnel = fresnel_dielectric(dot(wo, h), eta);
        const float chosen = reflected ? fresnel : 1 - fresnel;
        const float jacobian = dielectric_jacobian(wo, wi, h, eta);
        facets = chosen * ggx_density(alpha, h) * ggx_shadowing(alpha, wo, wi) * std::abs(wi.z) *
                 dot(wo, h) * jacobian;
        facet_pdf = chosen * ggx_visible_density(alpha, wo, h) * jacobian;
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

// ---- Metallic-roughness blends metal with a coated diffuse base. Schlick's formula is linear in its
// reflectance, so one GGX lobe serves both. The base receives what the coat lets through from the
// light and returns what the coat lets through towards the eye, normalised by the mean (Kelemen and
// Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model", 2001), so white stays
// white for any blend.

// The directional albedo of single scattering at a roughness and cosine: `bound` scales with the
// reflectance, `edge` is what Schlick's formula adds to any reflectance.
struct FacetAlbedo {
    float bound, edge;
    float at(float reflectance) const { return reflectance * bound + edge; }
};

struct Mixture : ConductorRow {
    using ConductorRow::ConductorRow;
    Vec3 reflectance; // at normal incidence
    Vec3 ground;      // albedo of the diffuse base, over mean_left
    Vec3 multiple;    // colour of multiple scattering, over mean_loss
    float coat;       // reflectance of the coat alone
    float coat_multiple;
    float mean_left, mean_loss; // means: what the coat leaves to the base; what facets lose
    float alpha;
};

FacetAlbedo facet_albedo(const Mixture &x, float cosine) {
    const ConductorTable &table = conductor_table();
    const float root = std::sqrt(std::abs(cosine));
    const auto at_root = [&](const std::array<EnergyTable, ENERGY_SIZE> &rows) {
        return glm::mix(interpolate(rows[x.row], root), interpolate(rows[x.row + 1], root), x.t);
    };
    const float energy = at_root(table.energy), edge = at_root(table.edge);
    return {energy - edge, edge};
}

Mixture mixture(const Material &m) {
    const float roughness = std::min(std::max(m.roughness, SMOOTH), 1.0f);
    Mixture x(roughness);
    x.alpha = roughness * roughness;
    const float mean_loss = x.mean(conductor_table().mean_loss);
    const float mean_edge = x.mean(conductor_table().mean_edge);
    const float root = (m.ior - 1) / (m.ior + 1);
    x.coat = root * root;
    x.coat_multiple = multiple_colour(Vec3(x.coat), mean_loss).x;
    x.mean_loss = mean_loss;
    x.mean_left = std::max(
        1 - x.coat * (1 - mean_loss - mean_edge) - mean_edge - x.coat_multiple * mean_loss, 1e-4f);
    x.reflectance = m.metallic * m.albedo + (1 - m.metallic) * x.coat * m.coat_colour;
    x.ground = ((1 - m.metallic) / x.mean_left) * m.albedo;
    x.multiple =
        (1 / std::max(mean_loss, LEAST_LOSS)) *
        (m.metallic * multiple_colour(m.albedo, mean_loss) + (1 - m.metallic) * x.coat_multiple);
    return x;
}

struct Left {
    float by_coat, by_facets;
};

Left left_at(const Mixture &x, FacetAlbedo f) {
    const float lost = std::max(0.0f, 1 - f.bound - f.edge);
    return {std::max(0.0f, 1 - f.at(x.coat) - x.coat_multiple * lost), lost};
}

// The probability of sampling the facet lobe: its share of the light returned. The rest is cosine.
float facet_share(const Mixture &x, Vec3 wo, Left &left) {
    const FacetAlbedo f = facet_albedo(x, wo.z);
    left = left_at(x, f);
    const float facets = luminance(x.reflectance) * f.bound + f.edge;
    const float rest = luminance(x.ground) * left.by_coat * x.mean_left +
                       luminance(x.multiple) * left.by_facets * x.mean_loss;
    return rest > 0 ? std::clamp(facets / (facets + rest), 0.1f, 0.99f) : 1;
}

MaterialValue value_of(const Mixture &x, Vec3 wo, Vec3 wi) {
    const Vec3 h = normalize_or(wo + wi, {0, 0, 1});
    Left near;
    const float share = facet_share(x, wo, near);
    const Left far = left_at(x, facet_albedo(x, wi.z));
    const float facets = 0.25f * ggx_density(x.alpha, h) * ggx_shadowing(x.alpha, wo, wi) * wi.z;
    const float edge = schlick_edge(dot(wo, h));
    const float flat = wi.z / PI;
    return {(facets * (1 - edge)) * x.reflectance + facets * edge +
                (flat * near.by_coat * far.by_coat) * x.ground +
                (flat * near.by_facets * far.by_facets) * x.multiple,
            share * (0.25f * ggx_masking(x.alpha, wo) * ggx_density(x.alpha, h)) +
                (1 - share) * flat};
}

MaterialSample mixture_sample(const Material &m, Vec3 wo, Vec2 u) {
    const Mixture x = mixture(m);
    Left left;
    const float share = facet_share(x, wo, left);
    Vec3 wi;
    // u.x chooses the lobe, then is rescaled to [0, 1).
    if (u.x < share) {
        u.x = std::min(u.x / share, 1 - DRAW_STEP);
        const Vec3 h = ggx_visible_normal(x.alpha, wo, square_to_disc(u));
        wi = normalize(2 * dot(wo, h) * h - wo);
    } else {
        u.x = std::min((u.x - share) / (1 - share), 1 - DRAW_STEP);
        wi = square_to_cosine_hemisphere(u);
    }
    if (!(wi.z > 0)) return {};
    const MaterialValue value = value_of(x, wo, wi);
    if (!(value.pdf > 0) || !std::isfinite(value.pdf)) return {};
    return {wi, (1 / value.pdf) * value.eval, value.pdf, false};
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
    if (!refract(wo, {0, 0, 1}, eta, wi)) return {};
    return {wi, m.albedo, 1 - fresnel, true};
}

bool sample_rough(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe, Vec3 &wi) {
    const bool metal = m.kind == Material::CONDUCTOR;
    const float wide = metal ? loss(ConductorEnergy(m), wo.z) : loss(m, front, wo.z);
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

MaterialValue specular_value(const Material &m, bool front, Vec3 wo, Vec3 wi) {
    if (material_is_smooth(m) || wi.z == 0) return {{0, 0, 0}, 0};
    if (m.kind == Material::PHASE) {
        const float pdf = phase_pdf(m.anisotropy, wi);
        return {pdf * m.albedo, pdf};
    }
    if (m.kind == Material::DIELECTRIC) return dielectric_value(m, front, wo, wi);
    if (!(wi.z > 0)) return {{0, 0, 0}, 0};
    return m.kind == Material::CONDUCTOR ? conductor_value(m, wo, wi)
                                         : value_of(mixture(m), wo, wi);
}

MaterialSample specular_sample(const Material &m, bool front, Vec3 wo, Vec2 u, float lobe) {
    if (material_is_smooth(m)) return sample_smooth(m, front, wo, u.x);
    if (m.kind == Material::METALLIC_ROUGHNESS) return mixture_sample(m, wo, u);
    if (m.kind == Material::PHASE) {
        const Vec3 wi = phase_sample(m.anisotropy, u);
        return {wi, m.albedo, phase_pdf(m.anisotropy, wi), false};
    }
    Vec3 wi;
    if (!sample_rough(m, front, wo, u, lobe, wi)) return {};
    const auto [eval, pdf] = specular_value(m, front, wo, wi);
    if (!(pdf > 0) || !std::isfinite(pdf)) return {};
    return {wi, (1 / pdf) * eval, pdf, false};
}

// ---- The tables of how much light microfacets keep in single scattering

namespace {

constexpr int RINGS = 40, SECTORS = 12; // facets integrated per table entry

float cosine_of_entry(size_t entry) {
    const float root = float(entry) / (ENERGY_SIZE - 1);
    return std::max(root * root, 1e-4f);
}

Vec3 direction_of_cosine(float cosine) {
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// The share of light that a visible facet keeps, which scatters from o to `wi`: G2 / G1.
float kept(float alpha, Vec3 o, Vec3 wi) {
    return std::abs(wi.z) * ggx_shadowing(alpha, o, wi) / ggx_masking(alpha, o);
}

// The mean of a function over the normals visible from o. The facets that matter are at the rim of the
// disc, so its rings get thinner there.
template <typename Function>
float mean_over_normals(float alpha, Vec3 o, const Function &function) {
    double sum = 0, weights = 0;
    for (int ring = 0; ring < RINGS; ++ring) {
        const float v = (float(ring) + 0.5f) / RINGS;
        const float radius = std::sqrt(1 - v * v * v);
        for (int sector = 0; sector < SECTORS; ++sector) {
            // The two halves of the disc are mirror images; one is enough.
            const float angle = PI * ((float(sector) + 0.5f) / SECTORS - 0.5f);
            const Vec2 disc = {radius * std::cos(angle), radius * std::sin(angle)};
            const double weight = double(v * v);
            sum += weight * double(function(ggx_visible_normal(alpha, o, disc)));
            weights += weight;
        }
    }
    return float(sum / weights);
}

// Cosine-weighted. Between entries the table is linear in the root, as in interpolate().
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
                const Vec3 o = direction_of_cosine(cosine_of_entry(c));
                const auto mean = [&](bool edge) {
                    return mean_over_normals(alpha, o, [&](Vec3 h) {
                        const Vec3 wi = 2 * dot(o, h) * h - o;
                        if (!(wi.z > 0)) return 0.0f;
                        return edge ? schlick_edge(dot(o, h)) * kept(alpha, o, wi)
                                    : kept(alpha, o, wi);
                    });
                };
                t.energy[r][c] = mean(false);
                t.edge[r][c] = mean(true);
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
