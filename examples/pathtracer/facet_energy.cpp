// SPDX-License-Identifier: Apache-2.0
// How much light microfacets keep in single scattering.
#include "facet_energy.h"

namespace facet_energy {

float hemispherical_mean(const float *table) {
    const int steps = 8 * SIZE;
    double sum = 0, weight = 0;
    for (int i = 0; i < steps; ++i) {
        const double root = (i + 0.5) / steps;
        const double w = root * root * root; // cosine times the derivative of the cosine
        sum += w * static_cast<double>(interpolate(table, static_cast<float>(root)));
        weight += w;
    }
    return static_cast<float>(sum / weight);
}

const ConductorTable &conductor_table() {
    static const ConductorTable table = [] {
        ConductorTable t;
        for (int r = 0; r < SIZE; ++r) {
            auto &row = t.energy[static_cast<size_t>(r)];
            auto &edge = t.edge[static_cast<size_t>(r)];
            const float roughness = std::max(static_cast<float>(r) / (SIZE - 1), SMOOTH);
            const float alpha = roughness * roughness;
            for (int c = 0; c < SIZE; ++c) {
                const Vec3 o = direction_of_cosine(cosine_of_entry(c));
                row[static_cast<size_t>(c)] = mean_over_normals(alpha, o, [&](Vec3 h) {
                    const Vec3 wi = 2 * dot(o, h) * h - o;
                    return wi.z > 0 ? kept(alpha, o, wi) : 0.0f;
                });
                edge[static_cast<size_t>(c)] = mean_over_normals(alpha, o, [&](Vec3 h) {
                    const Vec3 wi = 2 * dot(o, h) * h - o;
                    return wi.z > 0 ? schlick_edge(dot(o, h)) * kept(alpha, o, wi) : 0.0f;
                });
            }
            t.mean_loss[static_cast<size_t>(r)] = 1 - hemispherical_mean(row.data());
            t.mean_edge[static_cast<size_t>(r)] = hemispherical_mean(edge.data());
        }
        return t;
    }();
    return table;
}

} // namespace facet_energy
