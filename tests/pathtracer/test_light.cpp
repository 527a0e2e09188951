// SPDX-License-Identifier: Apache-2.0
// Choosing lights, points on them and directions to the environment: what is sampled follows the
// pdf that is stated, and the estimates it gives are the integrals they should be.
//
// Seeds are fixed; the false-alarm rate of each statistical check is below 1e-5 had they been drawn
// anew.
#include "light.h"

#include <vector>

#include "check.h"
#include "distribution.h"
#include "error.h"
#include "scene_builder.h"

namespace {

// Probabilities are multiples of the step of the draws: going through all draws proves them exact.
void test_distribution_is_exact() {
    const std::vector<std::vector<double>> all = {
        {1},       {1, 1, 1}, {0, 1, 0, 3, 0},         {1e-30, 1, 1e30},
        {5, 0, 0}, {0, 0, 7}, {1e-12, 1e-12, 1, 1e-12}};
    for (const std::vector<double> &weights : all) {
        const size_t n = weights.size();
        std::vector<float> limits(n + 1);
        distribution_build(weights.data(), n, limits.data());
        CHECK(limits[0] == 0 && limits[n] == 1, "%g to %g", limits[0], limits[n]);
        std::vector<uint32_t> counted(n);
        for (uint32_t i = 0; i < 1u << 24; ++i) {
            const Choice c =
                distribution_choose(limits.data(), n, static_cast<float>(i) * DRAW_STEP);
            ++counted[c.index];
            CHECK(c.rest > 0 && c.rest < 1, "rest %g of index %zu", c.rest, c.index);
        }
        double total = 0;
        for (const double w : weights) total += w;
        for (size_t i = 0; i < n; ++i) {
            const float stated = limits[i + 1] - limits[i];
            CHECK(static_cast<float>(counted[i]) * DRAW_STEP == stated, "%u and %g", counted[i],
                  stated);
            CHECK((counted[i] > 0) == (weights[i] > 0), "index %zu: %u", i, counted[i]);
            CHECK(std::abs(static_cast<double>(stated) - weights[i] / total) <
                      static_cast<double>(n + 1) * static_cast<double>(DRAW_STEP),
                  "index %zu: %g", i, stated);
        }
    }
}

Environment random_environment(int width, int height, uint64_t seed) {
    Random random{seed};
    std::vector<Vec3> texels;
    for (int i = 0; i < width * height; ++i) {
        const float v = random();
        texels.push_back({v * v * v, v * random(), 0.2f * random()});
    }
    texels[5] = {30, 20, 10};
    return environment_create(width, height, std::move(texels));
}

Vec3 even_direction(Random &random) {
    const float z = 2 * random() - 1, phi = 2 * PI * random();
    const float sine = std::sqrt(std::max(0.0f, 1 - z * z));
    return {sine * std::cos(phi), z, sine * std::sin(phi)};
}

void check_environment(const Environment &e, const char *name) {
    Random random{17};
    // The light in a half space, by even directions alone and by both ways weighed together.
    const Vec3 normal = normalize({0.3f, 0.8f, -0.5f});
    double mean[2] = {}, square[2] = {};
    const int count = 400000;
    const float even_pdf = 1 / (4 * PI);
    const auto light = [&](Vec3 d) {
        return luminance(environment_radiance(e, d)) * std::max(0.0f, dot(normal, d));
    };
    for (int i = 0; i < count; ++i) {
        const EnvironmentSample s = environment_sample(e, {random(), random()});
        CHECK(s.pdf > 0 && std::isfinite(s.pdf), "%s: pdf %g", name, s.pdf);
        CHECK(std::abs(length(s.direction) - 1) < 1e-4f, "%s: %g", name, length(s.direction));
        const Vec3 d = even_direction(random);
        const float pdf = environment_pdf(e, d);
        const float both = light(s.direction) / (s.pdf + even_pdf) + light(d) / (pdf + even_pdf);
        const float even = light(d) / even_pdf;
        mean[0] += static_cast<double>(both), square[0] += static_cast<double>(both * both);
        mean[1] += static_cast<double>(even), square[1] += static_cast<double>(even * even);
    }
    double variance = 0;
    for (int i = 0; i < 2; ++i) {
        mean[i] /= count;
        variance += (square[i] / count - mean[i] * mean[i]) / count;
    }
    CHECK(std::abs(mean[0] - mean[1]) < 4.5 * std::sqrt(variance) + 1e-3 * mean[0],
          "%s: %g by both, %g evenly, deviation %g", name, mean[0], mean[1], std::sqrt(variance));
    CHECK(square[0] < square[1], "%s: both are worse than even directions", name);

    // The pdf, which is constant in a texel, adds up to 1.
    double pdf_sum = 0;
    for (size_t y = 0; y < static_cast<size_t>(e.height); ++y)
        for (size_t x = 0; x < static_cast<size_t>(e.width); ++x) {
            const float cosine = (e.row_cosines[y] + e.row_cosines[y + 1]) / 2;
            const float longitude =
                2 * PI * ((static_cast<float>(x) + 0.5f) / static_cast<float>(e.width) - 0.5f);
            const float sine = std::sqrt(1 - cosine * cosine);
            const Vec3 d = {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
            pdf_sum +=
                static_cast<double>(environment_pdf(e, d) * 2 * PI / static_cast<float>(e.width) *
                                    (e.row_cosines[y] - e.row_cosines[y + 1]));
        }
    CHECK(std::abs(pdf_sum - 1) < 1e-4, "%s: the pdf adds up to %g", name, pdf_sum);

    // Sampled directions have the pdf that is stated for them afterwards.
    int differing = 0;
    for (int i = 0; i < 20000; ++i) {
        const EnvironmentSample s = environment_sample(e, {random(), random()});
        const float pdf = environment_pdf(e, s.direction);
        differing += std::abs(pdf - s.pdf) > 1e-5f * s.pdf ? 1 : 0;
    }
    // A few lie so near to a texel's edge that rounding puts them across it.
    CHECK(differing < 60, "%s: %d of 20000", name, differing);
}

void test_environments() {
    check_environment(random_environment(16, 8, 1), "random");
    check_environment(random_environment(7, 5, 2), "odd");
    check_environment(random_environment(9, 1, 3), "one row");

    // The pdf adds up to 1.
    const Environment sky = environment_sky(normalize({0.3f, 0.5f, 0.2f}));
    double total = 0;
    for (size_t y = 0; y < 512; ++y)
        for (size_t x = 0; x < 1024; ++x)
            total += static_cast<double>(
                (sky.row_limits[y + 1] - sky.row_limits[y]) *
                (sky.column_limits[y * 1025 + x + 1] - sky.column_limits[y * 1025 + x]));
    CHECK(std::abs(total - 1) < 1e-5, "%g", total);
    // There is nothing to choose in an even one.
    const Environment even = environment_create(64, 32, std::vector<Vec3>(2048, {1, 1, 1}));
    CHECK(even.irradiance == 0, "%g", even.irradiance);
}

void test_bad_environments() {
    for (const float bad : {NAN, INFINITY}) {
        bool thrown = false;
        try {
            environment_create(2, 1, {{1, 1, 1}, {bad, 1, 1}});
        } catch (const Error &) {
            thrown = true;
        }
        CHECK(thrown, "%g was taken", static_cast<double>(bad));
    }
    // Negative light, left by filters of pictures, is none.
    const Environment e = environment_create(2, 1, {{-1, 2, -3}, {1, 1, 1}});
    CHECK(e.texels[0].x == 0 && e.texels[0].y == 2, "%g", e.texels[0].x);
    const Environment dark = environment_create(4, 2, std::vector<Vec3>(8, {0, 0, 0}));
    CHECK(dark.irradiance == 0 && environment_pdf(dark, {0, 0, 1}) == 0, "%g", dark.irradiance);
}

// The solid angle of an area light, by its samples and by rays that meet it.
void test_area_lights() {
    for (const bool triangle : {false, true}) {
        Scene scene;
        const uint32_t black = add_diffuse(scene, {0, 0, 0});
        const Vec3 a = {-1, 2, -0.5f}, b = {0.8f, 2.4f, -0.7f}, c = {0.9f, 1.8f, 0.9f};
        // From below, a, b, c runs counter-clockwise.
        if (triangle)
            add_triangle_light(scene, black, {1, 1, 1}, a, b, c);
        else
            add_light(scene, black, {1, 1, 1}, a, b, c);
        const Light &light = scene.lights[0];
        const Vec3 point = {0.1f, 0, 0.2f};
        Random random{5};
        const int count = 200000;
        double by_light = 0, met = 0;
        for (int i = 0; i < count; ++i) {
            const LightSample s = light_sample(light, point, {random(), random()});
            CHECK(s.pdf > 0, "light %d", triangle);
            by_light += 1 / static_cast<double>(s.pdf) / count;
            const float distance = length(s.point - point);
            const float cosine = -dot(light.normal, s.direction);
            CHECK(std::abs(light_pdf(light, distance, cosine) / s.pdf - 1) < 1e-4f, "%g and %g",
                  light_pdf(light, distance, cosine), s.pdf);
            const Vec3 d = even_direction(random);
            const float facing = -dot(light.normal, d);
            if (!(facing > 0)) continue;
            const float t = dot(light.corner - point, light.normal) / dot(d, light.normal);
            if (!(t > 0)) continue;
            const Vec3 offset = point + t * d - light.corner;
            // Coordinates along the edges.
            const float uu = dot(light.edge_u, light.edge_u), vv = dot(light.edge_v, light.edge_v);
            const float uv = dot(light.edge_u, light.edge_v);
            const float ou = dot(offset, light.edge_u), ov = dot(offset, light.edge_v);
            const float determinant = uu * vv - uv * uv;
            const float u = (ou * vv - ov * uv) / determinant;
            const float v = (ov * uu - ou * uv) / determinant;
            const bool inside = u >= 0 && v >= 0 && (triangle ? u + v <= 1 : u <= 1 && v <= 1);
            met += inside ? 4 * static_cast<double>(PI) / count : 0;
        }
        const double share = met / (4 * static_cast<double>(PI));
        const double deviation =
            4 * static_cast<double>(PI) * std::sqrt(share * (1 - share) / count);
        CHECK(std::abs(by_light - met) < 4.5 * deviation, "triangle %d: %g by samples, %g by rays",
              triangle, by_light, met);
        // Not from behind, not from the edge.
        CHECK(light_sample(light, {0, 9, 0}, {0.5f, 0.5f}).pdf == 0, "it shines backwards");
        const Vec3 in_plane = light.corner + 7 * light.edge_u;
        const LightSample edge = light_sample(light, in_plane, {0.5f, 0.5f});
        CHECK(edge.pdf >= 0 && !std::isnan(edge.pdf), "pdf %g", edge.pdf);
    }
}

// Lights without extent: what they send where, and that all of it is what their power says.
void test_lights_without_extent() {
    Light light{};
    light.kind = Light::POINT;
    light.corner = {1, 2, 3};
    light.radiance = {8, 4, 2};
    const LightSample near = light_sample(light, {1, 2, 1}, {0, 0});
    CHECK(near.pdf == 1 && max_magnitude(near.radiance - Vec3{2, 1, 0.5f}) < 1e-6f, "%g",
          near.radiance.x);
    CHECK(max_magnitude(near.direction - Vec3{0, 0, 1}) < 1e-6f, "%g", near.direction.z);
    CHECK(light_sample(light, light.corner, {0, 0}).pdf == 0, "it lights itself");

    light.kind = Light::DIRECTIONAL;
    light.normal = {0, -1, 0};
    light.distance = 100;
    const LightSample far = light_sample(light, {5, 6, 7}, {0, 0});
    CHECK(far.pdf == 1 && far.direction.y == 1 && far.point.y == 106 && far.radiance.x == 8, "%g",
          far.point.y);

    light.kind = Light::SPOT;
    for (const float outer : {0.3f, 1.0f, 1.57f}) {
        light.cosine_inner = std::cos(0.5f * outer);
        light.cosine_outer = std::cos(outer);
        const int steps = 20000;
        double power = 0;
        for (int i = 0; i < steps; ++i) {
            const float angle = PI * (static_cast<float>(i) + 0.5f) / steps;
            const Vec3 to_point = {std::sin(angle), -std::cos(angle), 0};
            const LightSample s = light_sample(light, light.corner + to_point, {0, 0});
            CHECK((s.pdf > 0) == (angle < outer), "angle %g of %g: pdf %g", angle, outer, s.pdf);
            const double ring = 2 * static_cast<double>(PI * std::sin(angle) * PI / steps);
            if (s.pdf > 0) power += ring * static_cast<double>(luminance(s.radiance));
        }
        const double stated = static_cast<double>(light_power(light, 1));
        CHECK(power > 0.8 * stated && power < 1.2 * stated, "%g, stated %g", power, stated);
    }
}

// Lights are chosen by power, those without any not at all.
void test_lights_by_power() {
    Scene scene;
    const uint32_t black = add_diffuse(scene, {0, 0, 0});
    add_light(scene, black, {1, 1, 1}, {0, 1, 0}, {1, 1, 0}, {1, 1, 1});
    add_light(scene, black, {0, 0, 0}, {2, 1, 0}, {3, 1, 0}, {3, 1, 1});
    add_light(scene, black, {3, 3, 3}, {4, 1, 0}, {5, 1, 0}, {5, 1, 1});
    add_light(scene, black, {9, 9, 9}, {6, 1, 0}, {6, 1, 0}, {6, 1, 1}); // no area
    add_triangle_light(scene, black, {8, 8, 8}, {7, 1, 0}, {8, 1, 0}, {8, 1, 1});
    scene_finish(scene);
    CHECK(scene.lights.size() == 3, "%zu lights", scene.lights.size());
    const float expected[] = {0.125f, 0.375f, 0.5f};
    for (size_t i = 0; i < 3; ++i)
        CHECK(std::abs(scene.lights[i].probability - expected[i]) < 1e-5f, "%g",
              scene.lights[i].probability);
    CHECK(scene.dropped_triangles == 2 && scene.triangles.size() == 7, "%u dropped, %zu left",
          scene.dropped_triangles, scene.triangles.size());
    const int32_t lights[] = {0, 0, -1, -1, 1, 1, 2};
    for (size_t i = 0; i < 7; ++i)
        CHECK(scene.surfaces[i].light == lights[i], "surface %zu: %d", i, scene.surfaces[i].light);
}

} // namespace

int main() {
    test_distribution_is_exact();
    test_environments();
    test_bad_environments();
    test_area_lights();
    test_lights_without_extent();
    test_lights_by_power();
    return 0;
}
