// SPDX-License-Identifier: Apache-2.0
// The tables of how much light microfacets keep in single scattering.
#include "microfacet.h"

namespace {

constexpr int RINGS = 40, SECTORS = 12; // facets integrated per table entry

float cosine_of_entry(size_t entry) {
    const float root = static_cast<float>(entry) / (ENERGY_SIZE - 1);
    return std::max(root * root, 1e-4f);
}

Vec3 direction_of_cosine(float cosine) {
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// The share of light kept by a facet drawn from the visible normals that scatters from o to `wi`:
// G2 / G1.
float kept(float alpha, Vec3 o, Vec3 wi) {
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
float hemispherical_mean(const EnergyTable &table) {
    const int steps = 8 * ENERGY_SIZE;
    double sum = 0, weight = 0;
    for (int i = 0; i < steps; ++i) {
        const double root = (i + 0.5) / steps;
        const double w = root * root * root; // cosine times the derivative of the cosine
        sum += w * static_cast<double>(interpolate(table, static_cast<float>(root)));
        weight += w;
    }
    return static_cast<float>(sum / weight);
}

} // namespace

const ConductorTable &conductor_table() {
    static const ConductorTable table = [] {
        ConductorTable t;
        for (size_t r = 0; r < ENERGY_SIZE; ++r) {
            const float roughness = std::max(static_cast<float>(r) / (ENERGY_SIZE - 1), SMOOTH);
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
    if (m.single_scatter || std::min(e.mean_loss[0], e.mean_loss[1]) < LEAST_LOSS) {
        for (int side = 0; side < 2; ++side) {
            e.kept[side].fill(1);
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
