// SPDX-License-Identifier: Apache-2.0
// Metallic-roughness blends metal with a coated diffuse base. Schlick's formula is linear in its
// reflectance, so one GGX lobe serves both. The base receives what the coat lets through from the
// light and returns what the coat lets through towards the eye, normalised by the mean (Kelemen and
// Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model", 2001), so white stays
// white for any blend.

#include "distribution.h"
#include "microfacet.h"

namespace {

// The directional albedo of single scattering at a roughness and cosine: `bound` scales with the
// reflectance, `edge` is what Schlick's formula adds to any reflectance.
struct FacetAlbedo {
    float bound, edge;
    float at(float reflectance) const { return reflectance * bound + edge; }
};

// A metallic-roughness material, prepared for one point.
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
    const auto multiple = [&](Vec3 reflectance) {
        if (m.single_scatter || mean_loss < LEAST_LOSS) return Vec3(0);
        const Vec3 mean = reflectance + (1.0f - reflectance) / 21.0f;
        return mean * mean * (1 - mean_loss) / (1.0f - mean * mean_loss);
    };
    x.coat_multiple = multiple(Vec3(x.coat)).x;
    x.mean_loss = mean_loss;
    x.mean_left = std::max(
        1 - x.coat * (1 - mean_loss - mean_edge) - mean_edge - x.coat_multiple * mean_loss, 1e-4f);
    x.reflectance = m.metallic * m.albedo + (1 - m.metallic) * Vec3(x.coat);
    x.ground = ((1 - m.metallic) / x.mean_left) * m.albedo;
    x.multiple = (1 / std::max(mean_loss, LEAST_LOSS)) *
                 (m.metallic * multiple(m.albedo) + (1 - m.metallic) * x.coat_multiple);
    return x;
}

// What the coat leaves to the base, and what facets lose, at one cosine.
struct Left {
    float by_coat, by_facets;
};

Left left_at(const Mixture &x, FacetAlbedo f) {
    const float lost = std::max(0.0f, 1 - f.bound - f.edge);
    return {std::max(0.0f, 1 - f.at(x.coat) - x.coat_multiple * lost), lost};
}

// The probability of sampling the facet lobe: its share of the light returned at the cosine of
// `wo`. The rest is sampled by cosine.
float facet_share(const Mixture &x, Vec3 wo, Left &left) {
    const FacetAlbedo f = facet_albedo(x, wo.z);
    left = left_at(x, f);
    const float facets = luminance(x.reflectance) * f.bound + f.edge;
    const float rest = luminance(x.ground) * left.by_coat * x.mean_left +
                       luminance(x.multiple) * left.by_facets * x.mean_loss;
    return rest > 0 ? std::clamp(facets / (facets + rest), 0.1f, 0.99f) : 1;
}

float mixture_facet_pdf(const Mixture &x, Vec3 wo, Vec3 h) {
    return 0.25f * ggx_masking(x.alpha, wo) * ggx_density(x.alpha, h);
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
            share * mixture_facet_pdf(x, wo, h) + (1 - share) * flat};
}

} // namespace

MaterialValue mixture_value(const Material &m, Vec3 wo, Vec3 wi) {
    return value_of(mixture(m), wo, wi);
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
    if (!(wi.z > 0)) return {{0, 0, 1}, {0, 0, 0}, 0, false};
    const MaterialValue value = value_of(x, wo, wi);
    if (!(value.pdf > 0) || !std::isfinite(value.pdf)) return {{0, 0, 1}, {0, 0, 0}, 0, false};
    return {wi, (1 / value.pdf) * value.eval, value.pdf, false};
}
