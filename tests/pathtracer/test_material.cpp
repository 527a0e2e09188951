// SPDX-License-Identifier: Apache-2.0
// Tests materials: sample, pdf and eval agree, energy is conserved within the rounding of the tables,
// and nothing is NaN at the ends of parameter ranges.
//
// Seeds are fixed. With fresh seeds, the false-alarm rate would be about 3e-6 for each chi-square test
// and 1e-4 for all of them.
#include "material.h"

#include "check.h"
#include "microfacet.h"

namespace {

Material prepared(Material::Kind kind, Vec3 albedo, float roughness, float ior = 1.5f,
                  float metallic = 0) {
    Material m;
    m.kind = kind;
    m.albedo = albedo;
    m.roughness = roughness;
    m.ior = ior;
    m.metallic = metallic;
    material_prepare(m);
    return m;
}

Material dielectric(float ior, float roughness, Vec3 passed = {1, 1, 1}) {
    return prepared(Material::DIELECTRIC, passed, roughness, ior);
}

Material diffuse(Vec3 albedo) {
    return prepared(Material::DIFFUSE, albedo, 0);
}

Material metallic(float metallic, Vec3 base, float roughness, float ior = 1.5f) {
    return prepared(Material::METALLIC_ROUGHNESS, base, roughness, ior, metallic);
}

Vec3 direction(float cosine, float longitude) {
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return {sine * std::cos(longitude), sine * std::sin(longitude), cosine};
}

Material particle(float anisotropy) {
    Material m = prepared(Material::PHASE, {0.3f, 0.5f, 0.9f}, 0);
    m.anisotropy = anisotropy;
    return m;
}

struct Case {
    const char *name;
    Material material;
    bool front;
    float cosine; // of the outgoing direction
};

std::vector<Case> rough_cases() {
    std::vector<Case> cases;
    for (const float cosine : {1.0f, 0.7f, 0.1f}) {
        cases.push_back({"diffuse", diffuse({0.3f, 0.5f, 0.9f}), true, cosine});
        for (const float roughness : {0.4f, 0.8f}) {
            for (const float share : {0.0f, 0.6f, 1.0f})
                cases.push_back({"metallic-roughness",
                                 metallic(share, {0.9f, 0.5f, 0.2f}, roughness), true, cosine});
            for (const bool front : {true, false})
                cases.push_back(
                    {"dielectric", dielectric(1.5f, roughness, {1, 0.8f, 0.5f}), front, cosine});
        }
        cases.push_back({"low-index dielectric", dielectric(0.7f, 0.4f), true, cosine});
    }
    for (const float g : {-0.7f, 0.0f, 0.0005f, 0.3f, 0.9f})
        cases.push_back({"particle", particle(g), true, 1});
    return cases;
}

// The sphere's cells: rows divide the angle to the normal, columns the longitude.
constexpr int ROWS = 32, COLUMNS = 24;

int cell_of(Vec3 wi) {
    const float angle = std::atan2(std::sqrt(wi.x * wi.x + wi.y * wi.y), wi.z) / PI;
    const float turn = std::atan2(wi.y, wi.x) / (2 * PI) + 0.5f;
    return std::min(int(angle * ROWS), ROWS - 1) * COLUMNS +
           std::min(int(turn * COLUMNS), COLUMNS - 1);
}

// The integral of the pdf over each cell, by the midpoint rule on a fine grid.
std::vector<double> cell_probabilities(const Case &c, Vec3 wo) {
    const int fine_rows = 12, fine_columns = 8;
    const double pi = double(PI);
    std::vector<double> result(ROWS * COLUMNS);
    for (int y = 0; y < ROWS * fine_rows; ++y) {
        const double angle = pi * (y + 0.5) / (ROWS * fine_rows);
        const double solid_angle =
            std::sin(angle) * pi / (ROWS * fine_rows) * 2 * pi / (COLUMNS * fine_columns);
        for (int x = 0; x < COLUMNS * fine_columns; ++x) {
            const double longitude = 2 * pi * ((x + 0.5) / (COLUMNS * fine_columns) - 0.5);
            const Vec3 wi = {float(std::sin(angle) * std::cos(longitude)),
                             float(std::sin(angle) * std::sin(longitude)), float(std::cos(angle))};
            result[size_t(y / fine_rows * COLUMNS + x / fine_columns)] +=
                solid_angle * material_value(c.material, c.front, wo, wi).pdf;
        }
    }
    return result;
}

// Evaluating a sampled direction gives the weight and pdf of the sample.
void check_weight(const Case &c, Vec3 wo, const MaterialSample &s) {
    CHECK(std::abs(length(s.wi) - 1) < 1e-5f, "%s: length %g", c.name, length(s.wi));
    const auto [value, pdf] = material_value(c.material, c.front, wo, s.wi);
    CHECK(std::abs(pdf - s.pdf) <= 1e-4f * s.pdf, "%s: %g and %g", c.name, pdf, s.pdf);
    const float error = max_magnitude(value - s.pdf * s.weight);
    CHECK(error <= 1e-4f * s.pdf, "%s: off by %g of %g", c.name, error, s.pdf);
    CHECK(max_component(s.weight) < 30, "%s: weight %g", c.name, max_component(s.weight));
}

void test_samples_follow_the_pdf() {
    uint64_t seed = 1;
    for (const Case &c : rough_cases()) {
        const Vec3 wo = direction(c.cosine, 0.4f);
        std::vector<double> expected = cell_probabilities(c, wo);
        std::vector<double> counted(expected.size());
        const int count = 40000;
        int found = 0;
        Random random{seed++};
        Mean ahead; // light travels along -z
        for (int i = 0; i < count; ++i) {
            const Vec2 u = {random(), random()};
            const MaterialSample s = material_sample(c.material, c.front, wo, u, random());
            if (!(s.pdf > 0)) continue;
            ++found;
            ++counted[size_t(cell_of(s.wi))];
            if (i < 2000) check_weight(c, wo, s);
            ahead.add(-s.wi.z);
        }
        if (c.material.kind == Material::PHASE)
            check_mean(ahead, c.material.anisotropy, "mean cosine");
        double total = 0;
        for (double &e : expected) {
            total += e;
            e *= count;
        }
        const double deviations = unevenness(counted, expected);
        CHECK(deviations < 4.5, "%s, roughness %g, front %d, cosine %g: off by %g", c.name,
              c.material.roughness, c.front, c.cosine, deviations);
        // If a facet sends a direction below the surface, no sample is returned, and the pdf omits the
        // direction too. So the pdf integrates to the fraction of samples that are returned.
        const double share = double(found) / count;
        CHECK(std::abs(total - share) < 5 * std::sqrt(share * (1 - share) / count) + 2e-3,
              "%s, roughness %g, front %d, cosine %g: the pdf integrates to %g, not %g", c.name,
              c.material.roughness, c.front, c.cosine, total, share);
    }
}

// f(o, i) = f(i, o). For transmission, f is divided by the squared index of refraction on the side of
// `wi`, because paths carry radiance over that square.
void test_reciprocity() {
    Random random{11};
    for (const Case &c : rough_cases())
        for (int i = 0; i < 4000 && c.material.kind != Material::PHASE; ++i) {
            const Vec3 wo = direction(0.02f + 0.98f * random(), 6.2f * random());
            Vec3 wi = direction(0.02f + 0.98f * random(), 6.2f * random());
            const bool passes = c.material.kind == Material::DIELECTRIC && random() < 0.5f;
            // Seen from the other side, z is negated, and the path comes from `wi`.
            const auto turned = [&](Vec3 v) { return Vec3{v.x, v.y, passes ? -v.z : v.z}; };
            wi = turned(wi);
            const float eta = !passes ? 1 : c.front ? c.material.ior : 1 / c.material.ior;
            const Vec3 there = (1 / (eta * eta * std::abs(wi.z))) *
                               material_value(c.material, c.front, wo, wi).eval;
            const Vec3 back =
                (1 / std::abs(wo.z)) *
                material_value(c.material, c.front != passes, turned(wi), turned(wo)).eval;
            const float error = max_magnitude(there - back);
            CHECK(error <= 2e-3f * max_component(there) + 1e-5f,
                  "%s, roughness %g, front %d, passes %d: %g and %g", c.name, c.material.roughness,
                  c.front, passes, max_component(there), max_component(back));
        }
}

// The fraction of uniform incident light that is scattered towards `wo`.
Vec3 albedo(const Material &m, bool front, Vec3 wo, uint64_t seed, int side) {
    Random random{seed};
    const float n = float(side);
    Point3d sum(0);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const Vec2 u = {(float(x) + random()) / n, (float(y) + random()) / n};
            // A lattice in three dimensions: the lobe is as stratified as the direction.
            const float lobe = float(std::fmod((y * side + x) * 0.6180339887, 1));
            const MaterialSample s = material_sample(m, front, wo, u, lobe);
            if (!(s.pdf > 0)) continue;
            sum += Point3d(s.weight);
        }
    return Vec3(sum) / (n * n);
}

// White materials return all light, within the rounding of the tables. Single scattering alone would
// lose up to two thirds of it. Nearly smooth materials lose less than a thousandth on average, but may
// lose more at grazing angles.
void test_white_furnace() {
    for (int r = 0; r <= 10; ++r) {
        const float roughness = float(r) / 10;
        std::vector<std::pair<Material, bool>> all; // with the visible side
        for (const float ior : {1.33f, 1.5f, 2.4f, 0.8f})
            for (const bool front : {true, false})
                all.push_back({dielectric(ior, roughness), front});
        for (const float share : {0.0f, 0.5f, 1.0f})
            for (const float ior : {1.5f, 1.0f, 2.4f})
                all.push_back({metallic(share, {1, 1, 1}, roughness, ior), true});
        for (const auto &[m, front] : all) {
            const bool glass = m.kind == Material::DIELECTRIC;
            const bool smooth = roughness < (glass ? 0.35f : 0.2f);
            const float least = !smooth ? 0.988f : glass ? 0.9f : 0.93f;
            for (const float cosine : {1.0f, 0.8f, 0.5f, 0.2f, 0.05f}) {
                const float white = albedo(m, front, direction(cosine, 1), 3, 50).y;
                CHECK(white < 1.015f && white > least,
                      "kind %u, roughness %g, metallic %g, ior %g, front %d, cosine %g: %g", m.kind,
                      m.roughness, m.metallic, m.ior, front, cosine, white);
            }
        }
    }
    const Vec3 wall = albedo(diffuse({0.2f, 0.5f, 1}), true, direction(0.3f, 0), 1, 100);
    CHECK(std::abs(wall.x - 0.2f) < 1e-5f && std::abs(wall.z - 1) < 1e-5f, "%g %g", wall.x, wall.z);
}

// A coat with the same index of refraction as air shows the base's colour, except for the reflection
// at grazing angles that remains in Schlick's formula.
void test_coat_with_index_of_air_shows_the_base() {
    for (const float roughness : {0.3f, 0.7f, 1.0f}) {
        const Vec3 base = {0.2f, 0.5f, 0.8f};
        const Vec3 seen = albedo(metallic(0, base, roughness, 1), true, {0, 0, 1}, 1, 200);
        CHECK(max_magnitude(seen - base) < 0.03f, "%g %g %g", seen.x, seen.y, seen.z);
    }
}

// Rough metal tints light at every facet it is reflected from. This gives a geometric series in the
// mean of Schlick's formula over the hemisphere.
void test_colour_of_multiple_scattering() {
    double mean = 0, weight = 0, albedo_of_metal = 0.4;
    for (double cosine = 5e-5; cosine < 1; cosine += 1e-4) {
        mean += cosine * (albedo_of_metal + (1 - albedo_of_metal) * std::pow(1 - cosine, 5));
        weight += cosine;
    }
    mean /= weight;
    const ConductorRow row(0.8f);
    const double lost = double{row.mean(conductor_table().mean_loss)};
    const double expected = mean * mean * (1 - lost) / (1 - mean * lost);
    // At normal incidence, where the facets' Fresnel term is the albedo.
    const auto value = [](float albedo) {
        return double{
            material_value(metallic(1, Vec3(albedo), 0.8f), true, {0, 0, 1}, {0, 0, 1}).eval.x};
    };
    const double black = 1.0 / 21, of_black = black * black * (1 - lost) / (1 - black * lost);
    const double wide = value(0) / of_black;
    const double tint = (value(0.4f) - 0.4 * (value(1) - wide)) / wide;
    CHECK(std::abs(tint / expected - 1) < 1e-3, "%g, should be %g", tint, expected);
}

void test_smooth_dielectric() {
    const Material glass = dielectric(1.5f, 0);
    CHECK(std::abs(fresnel_dielectric(1, 1.5f) - 0.04f) < 1e-6f, "%g", fresnel_dielectric(1, 1.5f));
    CHECK(schlick_edge(0.5f) == 1.0f / 32, "Schlick's term: %g", schlick_edge(0.5f));
    Random random{1};
    for (int i = 0; i < 2000; ++i) {
        const bool front = random() < 0.5f;
        const Vec3 wo = direction(1 - random() * 0.99f, 6 * random());
        const MaterialSample s = material_sample(glass, front, wo, {random(), random()}, random());
        CHECK(s.pdf > 0 && s.pdf <= 1 && s.weight.x == 1, "pdf %g, weight %g", s.pdf, s.weight.x);
        CHECK(max_component(material_value(glass, front, wo, s.wi).eval) == 0, "value is not zero");
        if (s.wi.z > 0) continue;
        // Snell's law holds, and both directions and the normal lie in one plane.
        const float eta = front ? 1.5f : 1 / 1.5f;
        CHECK(std::abs(wo.x + eta * s.wi.x) < 1e-5f && std::abs(wo.y + eta * s.wi.y) < 1e-5f,
              "cosine %g", wo.z);
    }
    // From inside, all light is reflected at a grazing angle.
    const MaterialSample inside = material_sample(glass, false, direction(0.3f, 0), {0, 0}, 0.99f);
    CHECK(inside.wi.z > 0 && inside.pdf == 1, "pdf %g", inside.pdf);
}

// At an index of refraction of 1, a surface is invisible, however rough it is.
void test_surfaces_without_refraction_are_invisible() {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        const Material nothing = dielectric(1, roughness);
        for (const bool front : {true, false}) {
            const Vec3 wo = direction(0.4f, 2);
            const MaterialSample s = material_sample(nothing, front, wo, {0.3f, 0.6f}, 0);
            CHECK(s.pdf == 1 && s.weight.x == 1 && max_magnitude(s.wi + wo) == 0, "light is bent");
        }
        // At an index close to 1, light is hardly bent.
        const Material haze = dielectric(1.002f, roughness);
        const Vec3 wo = direction(0.6f, 2);
        const MaterialSample s = material_sample(haze, true, wo, {0.3f, 0.6f}, 0.5f);
        CHECK(s.pdf > 0 && max_magnitude(s.wi + wo) < 0.05f && std::abs(s.weight.x - 1) < 0.05f,
              "roughness %g: off by %g, weight %g", roughness, max_magnitude(s.wi + wo),
              s.weight.x);
    }
}

// Samples at the corners of the unit cube, and values, are finite at the ends of parameter ranges and
// for directions parallel to the surface.
void test_no_nan_at_the_ends_of_ranges() {
    const float cosines[] = {1, 0.5f, 1e-3f, 1e-6f, 1e-12f, 1e-30f};
    const float corners[] = {0, 1e-7f, 0.5f, 1 - 1.0f / (1 << 24)};
    const auto check = [&](const Material &m, bool front, Vec3 wo) {
        for (int i = 0; i < 64; ++i) {
            const MaterialSample s = material_sample(
                m, front, wo, {corners[i % 4], corners[i / 16]}, corners[i / 4 % 4]);
            CHECK(s.pdf >= 0 && std::isfinite(s.pdf) &&
                      (s.pdf == 0 || (is_finite(s.wi) && is_finite(s.weight) && s.weight.x >= 0 &&
                                      s.weight.x < 1000)),
                  "kind %u, ior %g, roughness %g, cosine %g: pdf %g, weight %g", m.kind, m.ior,
                  m.roughness, wo.z, s.pdf, s.weight.x);
        }
        for (const float cosine : cosines)
            for (const float sign : {-1.0f, 1.0f})
                for (const float longitude : {0.7f, 0.7f + PI, 2.0f}) {
                    const Vec3 wi = direction(cosine, longitude) * Vec3{1, 1, sign};
                    const auto [value, pdf] = material_value(m, front, wo, wi);
                    CHECK(is_finite(value) && value.x >= 0 && std::isfinite(pdf) && pdf >= 0,
                          "kind %u, ior %g, roughness %g, cosine %g: pdf %g, value %g", m.kind,
                          m.ior, m.roughness, wo.z, pdf, value.x);
                }
    };
    for (const float roughness : {0.0f, 0.009f, 0.0101f, 0.03f, 0.5f, 1.0f}) {
        std::vector<Material> materials = {diffuse({1, 1, 1}),
                                           metallic(0.5f, {1, 0, 0}, roughness)};
        for (const float ior : {1.0f, 1.5f, 1.0011f, 3.0f, 0.5f})
            materials.push_back(dielectric(ior, roughness));
        for (const float share : {0.0f, 1.0f})
            for (const float base : {0.0f, 1.0f})
                materials.push_back(metallic(share, Vec3(base), roughness));
        materials.push_back(metallic(0, {1, 1, 1}, roughness, 1));
        for (const Material &m : materials)
            for (const bool front : {true, false})
                for (const float cosine : cosines) check(m, front, direction(cosine, 0.7f));
    }
}

} // namespace

int main() {
    test_samples_follow_the_pdf();
    test_reciprocity();
    test_white_furnace();
    test_coat_with_index_of_air_shows_the_base();
    test_colour_of_multiple_scattering();
    test_smooth_dielectric();
    test_surfaces_without_refraction_are_invisible();
    test_no_nan_at_the_ends_of_ranges();
    return 0;
}
