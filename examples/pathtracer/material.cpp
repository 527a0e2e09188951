// SPDX-License-Identifier: Apache-2.0
// Lambert, GGX conductors, GGX dielectrics, and the metallic-roughness material of glTF.
//
// Light that microfacets scatter more than once is missing from their formulas. It comes back as a
// wide lobe of its own (Kulla and Conty, "Revisiting Physically Based Shading at Imageworks",
// 2017): what is lost in direction o times what is lost in direction i, which is reciprocal and
// adds up to what is lost. How much that is stands in tables, integrated at start-up: for
// conductors over cosine and roughness with a white Fresnel term, for each rough dielectric over
// cosine. A rough material is sampled as the mixture of both lobes, the wide one with the
// probability of the loss.
//
// Fresnel of conductors: Schlick's, with a tint near the edge (Kutz et al., "Novel aspects of the
// Adobe Standard Material", 2021).
//
// Metallic-roughness is a mixture of metal and of a coat over a diffuse ground, one GGX lobe for
// both as Schlick's formula is linear in its reflectance. The ground gets what the coat leaves in
// the direction of the light, on average, and gives back what the coat leaves in the direction of
// the eye (Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model",
// 2001), so that white stays white whatever the mixture.
#include "material.h"

#include <array>

#include "microfacet.h"

namespace {

constexpr int SIZE = DielectricEnergy::SIZE;
constexpr int RINGS = 40, SECTORS = 12; // facets per entry of a table
constexpr float LEAST_LOSS = 1e-3f;     // on average over the hemisphere

float alpha_of(const Material &m) {
    return m.roughness * m.roughness;
}

// Where between the entries of a table a value lies: entries are close where cosines are small.
float interpolate(const float *table, float position) {
    const float at = std::min(std::max(position, 0.0f), 1.0f) * (SIZE - 1);
    const int below = std::min(static_cast<int>(at), SIZE - 2);
    const float t = at - static_cast<float>(below);
    return (1 - t) * table[below] + t * table[below + 1];
}

float cosine_of_entry(int entry) {
    const float root = static_cast<float>(entry) / (SIZE - 1);
    return std::max(root * root, 1e-4f);
}

// The mean of a function of visible normals, seen from o in the xz-plane. The facets that matter
// here are steep and rare, at the rim of the disc: so the disc is cut into rings that get ever
// thinner.
template <typename Function>
float mean_over_normals(float alpha, Vec3 o, const Function &function) {
    double sum = 0, weights = 0;
    for (int ring = 0; ring < RINGS; ++ring) {
        const float v = (static_cast<float>(ring) + 0.5f) / RINGS;
        const float radius = std::sqrt(1 - v * v * v);
        for (int sector = 0; sector < SECTORS; ++sector) {
            // One half of the disc mirrors the other.
            const float angle = PI * ((static_cast<float>(sector) + 0.5f) / SECTORS - 0.5f);
            const Vec2 disc = {radius * std::cos(angle), radius * std::sin(angle)};
            const double weight = static_cast<double>(v * v);
            sum += weight * static_cast<double>(function(ggx_visible_normal(alpha, o, disc)));
            weights += weight;
        }
    }
    return static_cast<float>(sum / weights);
}

// Twice the integral of a table over cosine times the cosine: the mean over the hemisphere. Between
// entries the table is linear in the root of the cosine, as interpolate() reads it.
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

Vec3 direction_of_cosine(float cosine) {
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// What a visible normal keeps of the light that it sends from o to `in`.
float kept(float alpha, Vec3 o, Vec3 in) {
    return std::abs(in.z) * ggx_shadowing(alpha, o, in) / ggx_masking(alpha, o);
}

// ---- Conductors

struct ConductorTable {
    std::array<std::array<float, SIZE>, SIZE> energy; // [roughness][root of cosine]
    std::array<float, SIZE> mean_loss;                // [roughness]
    // The part of `energy` that Schlick's formula gives to any reflectance, and its mean.
    std::array<std::array<float, SIZE>, SIZE> edge;
    std::array<float, SIZE> mean_edge;
};

// What Schlick's formula adds to a reflectance of 0 at that cosine.
float schlick_edge(float cosine) {
    const float c = 1 - std::min(std::max(cosine, 0.0f), 1.0f);
    return c * c * c * c * c;
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
                    const Vec3 in = 2 * dot(o, h) * h - o;
                    return in.z > 0 ? kept(alpha, o, in) : 0.0f;
                });
                edge[static_cast<size_t>(c)] = mean_over_normals(alpha, o, [&](Vec3 h) {
                    const Vec3 in = 2 * dot(o, h) * h - o;
                    return in.z > 0 ? schlick_edge(dot(o, h)) * kept(alpha, o, in) : 0.0f;
                });
            }
            t.mean_loss[static_cast<size_t>(r)] = 1 - hemispherical_mean(row.data());
            t.mean_edge[static_cast<size_t>(r)] = hemispherical_mean(edge.data());
        }
        return t;
    }();
    return table;
}

// Between two roughnesses of the table.
struct ConductorEnergy {
    const float *low, *high;
    float t;
    float mean_loss;
};

ConductorEnergy conductor_energy(float roughness) {
    const ConductorTable &table = conductor_table();
    const float at = std::min(roughness, 1.0f) * (SIZE - 1);
    const auto below = static_cast<size_t>(std::min(static_cast<int>(at), SIZE - 2));
    const float t = at - static_cast<float>(below);
    return {table.energy[below].data(), table.energy[below + 1].data(), t,
            (1 - t) * table.mean_loss[below] + t * table.mean_loss[below + 1]};
}

float loss(const ConductorEnergy &e, float cosine) {
    if (e.mean_loss < LEAST_LOSS) return 0;
    const float root = std::sqrt(std::abs(cosine));
    return std::max(0.0f,
                    1 - (1 - e.t) * interpolate(e.low, root) - e.t * interpolate(e.high, root));
}

Vec3 fresnel_conductor(const Material &m, float cosine) {
    // The tint is 1 - `edge` of what Schlick's formula says at the cosine of 82 degrees, 1/7.
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

// The Fresnel term of light scattered more than once: reflected by all facets on average, and lost
// again by a part of it each time.
Vec3 fresnel_multiple(const Material &m, float mean_loss) {
    const float grazing = std::pow(6.0f / 7, 5.0f), scale = 7 / std::pow(6.0f / 7, 6.0f);
    const auto one = [&](float f0, float edge) {
        const float tint = (f0 + (1 - f0) * grazing) * (1 - edge) * scale;
        const float mean = std::max(f0 + (1 - f0) / 21 - tint / 126, 0.0f);
        return mean * mean * (1 - mean_loss) / (1 - mean * mean_loss);
    };
    return {one(m.albedo.x, m.edge.x), one(m.albedo.y, m.edge.y), one(m.albedo.z, m.edge.z)};
}

Vec3 conductor_eval(const Material &m, Vec3 out, Vec3 in) {
    const float alpha = alpha_of(m);
    const Vec3 h = normalize_or(out + in, {0, 0, 1});
    const float facets = 0.25f * ggx_density(alpha, h) * ggx_shadowing(alpha, out, in) * in.z;
    const ConductorEnergy e = conductor_energy(m.roughness);
    const float wide =
        e.mean_loss >= LEAST_LOSS ? loss(e, out.z) * loss(e, in.z) * in.z / (PI * e.mean_loss) : 0;
    return facets * fresnel_conductor(m, dot(out, h)) + wide * fresnel_multiple(m, e.mean_loss);
}

float conductor_pdf(const Material &m, Vec3 out, Vec3 in) {
    const float alpha = alpha_of(m);
    const Vec3 h = normalize_or(out + in, {0, 0, 1});
    const float wide = loss(conductor_energy(m.roughness), out.z);
    return (1 - wide) * 0.25f * ggx_masking(alpha, out) * ggx_density(alpha, h) + wide * in.z / PI;
}

// ---- Metallic-roughness

float lerp(float t, float a, float b) {
    return (1 - t) * a + t * b;
}

// How much light the single scattering of facets returns at a roughness and a cosine: `bound` of
// what the reflectance says, and `edge` of all that is left to 1.
struct FacetAlbedo {
    float bound, edge;
    float at(float reflectance) const { return reflectance * bound + edge; }
};

// A metallic-roughness material, prepared for one place.
struct Mixture {
    Vec3 reflectance; // seen straight
    Vec3 ground;      // of the diffuse part, over what the coat takes of it on average
    Vec3 multiple;    // of what facets scatter more than once, over the mean loss
    float coat;       // reflectance of the coat alone
    float coat_multiple;
    float mean_left, mean_loss; // what the coat leaves to the ground, and facets lose, on average
    float alpha;
    float t; // between the rows of the tables
    size_t row;
};

FacetAlbedo facet_albedo(const Mixture &x, float cosine) {
    const ConductorTable &table = conductor_table();
    const float root = std::sqrt(std::abs(cosine));
    const float energy = lerp(x.t, interpolate(table.energy[x.row].data(), root),
                              interpolate(table.energy[x.row + 1].data(), root));
    const float edge = lerp(x.t, interpolate(table.edge[x.row].data(), root),
                            interpolate(table.edge[x.row + 1].data(), root));
    return {energy - edge, edge};
}

Mixture mixture(const Material &m) {
    Mixture x;
    const ConductorTable &table = conductor_table();
    const float roughness = std::min(std::max(m.roughness, SMOOTH), 1.0f);
    x.alpha = roughness * roughness;
    const float at = roughness * (SIZE - 1);
    x.row = static_cast<size_t>(std::min(static_cast<int>(at), SIZE - 2));
    x.t = at - static_cast<float>(x.row);
    const float mean_loss = lerp(x.t, table.mean_loss[x.row], table.mean_loss[x.row + 1]);
    const float mean_edge = lerp(x.t, table.mean_edge[x.row], table.mean_edge[x.row + 1]);
    const float root = (m.ior - 1) / (m.ior + 1);
    x.coat = root * root;
    const auto multiple = [&](float reflectance) {
        if (mean_loss < LEAST_LOSS) return 0.0f;
        const float mean = reflectance + (1 - reflectance) / 21;
        return mean * mean * (1 - mean_loss) / (1 - mean * mean_loss);
    };
    x.coat_multiple = multiple(x.coat);
    x.mean_loss = mean_loss;
    x.mean_left = std::max(
        1 - x.coat * (1 - mean_loss - mean_edge) - mean_edge - x.coat_multiple * mean_loss, 1e-4f);
    x.reflectance = m.metallic * m.albedo + (1 - m.metallic) * Vec3{x.coat, x.coat, x.coat};
    x.ground = ((1 - m.metallic) / x.mean_left) * m.albedo;
    const Vec3 metal = {multiple(m.albedo.x), multiple(m.albedo.y), multiple(m.albedo.z)};
    const float coat = (1 - m.metallic) * x.coat_multiple;
    x.multiple =
        (1 / std::max(mean_loss, LEAST_LOSS)) * (m.metallic * metal + Vec3{coat, coat, coat});
    return x;
}

// What the coat leaves to the ground, and what facets lose, at a cosine.
struct Left {
    float by_coat, by_facets;
};

Left left_at(const Mixture &x, FacetAlbedo f) {
    const float lost = std::max(0.0f, 1 - f.bound - f.edge);
    return {std::max(0.0f, 1 - f.at(x.coat) - x.coat_multiple * lost), lost};
}

// The share of directions that are sampled by facets: by what they return at the cosine of `out`,
// as the rest is sampled by its cosine.
float facet_share(const Mixture &x, Vec3 out, Left &left) {
    const FacetAlbedo f = facet_albedo(x, out.z);
    left = left_at(x, f);
    const float facets = luminance(x.reflectance) * f.bound + f.edge;
    const float rest = luminance(x.ground) * left.by_coat * x.mean_left +
                       luminance(x.multiple) * left.by_facets * x.mean_loss;
    return rest > 0 ? std::clamp(facets / (facets + rest), 0.1f, 0.99f) : 1;
}

float mixture_facet_pdf(const Mixture &x, Vec3 out, Vec3 h) {
    return 0.25f * ggx_masking(x.alpha, out) * ggx_density(x.alpha, h);
}

struct MixtureValue {
    Vec3 eval;
    float pdf;
};

MixtureValue mixture_value(const Mixture &x, Vec3 out, Vec3 in) {
    const Vec3 h = normalize_or(out + in, {0, 0, 1});
    Left near;
    const float share = facet_share(x, out, near);
    const Left far = left_at(x, facet_albedo(x, in.z));
    const float facets = 0.25f * ggx_density(x.alpha, h) * ggx_shadowing(x.alpha, out, in) * in.z;
    const float edge = schlick_edge(dot(out, h));
    const float flat = in.z / PI;
    return {(facets * (1 - edge)) * x.reflectance +
                Vec3{facets * edge, facets * edge, facets * edge} +
                (flat * near.by_coat * far.by_coat) * x.ground +
                (flat * near.by_facets * far.by_facets) * x.multiple,
            share * mixture_facet_pdf(x, out, h) + (1 - share) * flat};
}

MaterialSample nothing() {
    return {{0, 0, 1}, {0, 0, 0}, 0, false};
}

MaterialSample mixture_sample(const Material &m, Vec3 out, Vec2 u, float lobe) {
    const Mixture x = mixture(m);
    Left left;
    Vec3 in;
    if (lobe < facet_share(x, out, left)) {
        const Vec3 h = ggx_visible_normal(x.alpha, out, square_to_disc(u));
        in = normalize(2 * dot(out, h) * h - out);
    } else {
        in = square_to_cosine_hemisphere(u);
    }
    if (!(in.z > 0)) return nothing();
    const MixtureValue value = mixture_value(x, out, in);
    if (!(value.pdf > 0) || !std::isfinite(value.pdf)) return nothing();
    return {in, (1 / value.pdf) * value.eval, value.pdf, false};
}

// ---- Dielectrics

float relative_ior(const Material &m, bool front) {
    return front ? m.ior : 1 / m.ior;
}

float loss(const Material &m, bool front, float cosine) {
    return std::max(0.0f,
                    1 - interpolate(m.energy->kept[front ? 0 : 1], std::sqrt(std::abs(cosine))));
}

// The facet that sends light from `in` to `out`. False when none does.
bool dielectric_facet(Vec3 out, Vec3 in, float eta, Vec3 &h) {
    h = normalize_or(in.z > 0 ? out + in : out + eta * in, {0, 0, 1});
    if (h.z < 0) h = -h;
    return dot(out, h) > 0 && (dot(in, h) > 0) == (in.z > 0);
}

// The derivative of a facet's normal by the direction it sends light to or from.
float dielectric_jacobian(Vec3 out, Vec3 in, Vec3 h, float eta) {
    const float to_out = dot(out, h), to_in = dot(in, h);
    if (in.z > 0) return 1 / (4 * to_out);
    const float sum = to_out + eta * to_in;
    return eta * eta * std::abs(to_in) / (sum * sum);
}

Vec3 dielectric_eval(const Material &m, bool front, Vec3 out, Vec3 in) {
    const bool reflected = in.z > 0;
    const float eta = relative_ior(m, front), alpha = alpha_of(m);
    float facets = 0;
    Vec3 h;
    if (dielectric_facet(out, in, eta, h)) {
        const float fresnel = fresnel_dielectric(dot(out, h), eta);
        facets = (reflected ? fresnel : 1 - fresnel) * ggx_density(alpha, h) *
                 ggx_shadowing(alpha, out, in) * std::abs(in.z) * dot(out, h) *
                 dielectric_jacobian(out, in, h, eta);
    }
    const int near = front ? 0 : 1, far = reflected ? near : 1 - near;
    const float passed = m.energy->passed_loss[near], mean_loss = m.energy->mean_loss[far];
    const float share = reflected ? 1 - passed : passed;
    const float wide = mean_loss > 0 ? share * loss(m, front, out.z) * loss(m, far == 0, in.z) *
                                           std::abs(in.z) / (PI * mean_loss)
                                     : 0;
    return (facets + wide) * (reflected ? Vec3{1, 1, 1} : m.albedo);
}

float dielectric_pdf(const Material &m, bool front, Vec3 out, Vec3 in) {
    const bool reflected = in.z > 0;
    const float eta = relative_ior(m, front), alpha = alpha_of(m);
    const float wide = loss(m, front, out.z);
    const float passed = m.energy->passed_loss[front ? 0 : 1];
    float facets = 0;
    Vec3 h;
    if (dielectric_facet(out, in, eta, h)) {
        const float fresnel = fresnel_dielectric(dot(out, h), eta);
        facets = (reflected ? fresnel : 1 - fresnel) * ggx_visible_density(alpha, out, h) *
                 dielectric_jacobian(out, in, h, eta);
    }
    return (1 - wide) * facets + wide * (reflected ? 1 - passed : passed) * std::abs(in.z) / PI;
}

// ---- Sampling

MaterialSample sample_smooth(const Material &m, bool front, Vec3 out, float lobe) {
    const Vec3 mirrored = {-out.x, -out.y, out.z};
    if (m.kind == Material::CONDUCTOR) return {mirrored, fresnel_conductor(m, out.z), 1, true};
    if (std::abs(m.ior - 1) < SAME_IOR) return {-out, m.albedo, 1, true};
    const float eta = relative_ior(m, front);
    const float fresnel = fresnel_dielectric(out.z, eta);
    if (lobe < fresnel) return {mirrored, {1, 1, 1}, fresnel, true};
    Vec3 in;
    if (!refract(out, {0, 0, 1}, eta, in)) return nothing();
    return {in, m.albedo, 1 - fresnel, true};
}

// A direction of a rough material's mixture.
bool sample_rough(const Material &m, bool front, Vec3 out, Vec2 u, float lobe, Vec3 &in) {
    const bool metal = m.kind == Material::CONDUCTOR;
    const float wide = metal ? loss(conductor_energy(m.roughness), out.z) : loss(m, front, out.z);
    if (u.x < wide) {
        in = square_to_cosine_hemisphere({u.x / wide, u.y});
        if (!metal && lobe < m.energy->passed_loss[front ? 0 : 1]) in.z = -in.z;
        return true;
    }
    const Vec3 h =
        ggx_visible_normal(alpha_of(m), out, square_to_disc({(u.x - wide) / (1 - wide), u.y}));
    const float cosine = dot(out, h);
    if (!(cosine > 0)) return false;
    const float eta = relative_ior(m, front);
    if (metal || lobe < fresnel_dielectric(cosine, eta)) {
        in = normalize(2 * cosine * h - out);
        return in.z > 0;
    }
    return refract(out, h, eta, in) && in.z < 0;
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
    if (std::min(e.mean_loss[0], e.mean_loss[1]) < LEAST_LOSS) {
        for (int side = 0; side < 2; ++side) {
            std::fill(e.kept[side], e.kept[side] + SIZE, 1.0f);
            e.mean_loss[side] = e.passed_loss[side] = 0;
        }
        return;
    }
    // The shares that reciprocity asks for: they are to each other as the losses of the far sides
    // times what a smooth interface lets through, whose ratio is the squared index of refraction.
    passed[1] = passed[0] / (m.ior * m.ior);
    e.passed_loss[0] = passed[0] * e.mean_loss[1] / larger;
    e.passed_loss[1] = passed[1] * e.mean_loss[0] / larger;
}

Vec3 specular_eval(const Material &m, bool front, Vec3 out, Vec3 in) {
    if (material_is_smooth(m) || in.z == 0) return {0, 0, 0};
    if (m.kind == Material::DIELECTRIC) return dielectric_eval(m, front, out, in);
    if (m.kind == Material::METALLIC_ROUGHNESS)
        return in.z > 0 ? mixture_value(mixture(m), out, in).eval : Vec3{0, 0, 0};
    return in.z > 0 ? conductor_eval(m, out, in) : Vec3{0, 0, 0};
}

float specular_pdf(const Material &m, bool front, Vec3 out, Vec3 in) {
    if (material_is_smooth(m) || in.z == 0) return 0;
    if (m.kind == Material::DIELECTRIC) return dielectric_pdf(m, front, out, in);
    if (m.kind == Material::METALLIC_ROUGHNESS)
        return in.z > 0 ? mixture_value(mixture(m), out, in).pdf : 0;
    return in.z > 0 ? conductor_pdf(m, out, in) : 0;
}

MaterialSample specular_sample(const Material &m, bool front, Vec3 out, Vec2 u, float lobe) {
    if (material_is_smooth(m)) return sample_smooth(m, front, out, lobe);
    if (m.kind == Material::METALLIC_ROUGHNESS) return mixture_sample(m, out, u, lobe);
    Vec3 in;
    if (!sample_rough(m, front, out, u, lobe, in)) return nothing();
    const float pdf = specular_pdf(m, front, out, in);
    if (!(pdf > 0) || !std::isfinite(pdf)) return nothing();
    return {in, (1 / pdf) * specular_eval(m, front, out, in), pdf, false};
}
