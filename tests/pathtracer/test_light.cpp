// SPDX-License-Identifier: Apache-2.0
// Choosing lights, points on them and directions to the environment: what is sampled follows the
// pdf that is stated, and the estimates it gives are the integrals they should be. Seeds are fixed.
#include "light.h"

#include "distribution.h"
#include "scenes.h"

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
            CHECK(std::abs(stated - weights[i] / total) < static_cast<double>(n + 1) * DRAW_STEP,
                  "index %zu: %g", i, stated);
        }
    }
}

// Directions go to texels as often as the pdf says, which adds up to 1, and bring the texel's light.
void check_environment(const Environment &e, const char *name) {
    constexpr int COUNT = 400000;
    const auto w = static_cast<size_t>(e.width), h = static_cast<size_t>(e.height);
    std::vector<double> expected, counted(w * h);
    double total = 0;
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) {
            const float cosine = (e.row_cosines[y] + e.row_cosines[y + 1]) / 2;
            const float longitude =
                2 * PI * (0.5f - (static_cast<float>(x) + 0.5f) / static_cast<float>(w));
            const float sine = std::sqrt(1 - cosine * cosine);
            const Vec3 d = {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
            CHECK(length(environment_radiance(e, d) - e.texels[y * w + x]) == 0, "%s: %zu, %zu",
                  name, x, y);
            const double share = 2 * double{PI} / e.width * environment_pdf(e, d) *
                                 (e.row_cosines[y] - e.row_cosines[y + 1]);
            expected.push_back(COUNT * share);
            total += share;
        }
    CHECK(std::abs(total - 1) < 1e-4, "%s: the pdf adds up to %g", name, total);
    Random random{17};
    int differing = 0;
    for (int i = 0; i < COUNT; ++i) {
        const Vec2 u = {random(), random()};
        const auto [d, pdf] = environment_sample(e, u);
        CHECK(pdf > 0 && std::isfinite(pdf) && std::abs(length(d) - 1) < 1e-4f, "%s: %g", name,
              pdf);
        differing += std::abs(environment_pdf(e, d) - pdf) > 1e-5f * pdf ? 1 : 0;
        const float column = (0.5f - std::atan2(d.x, d.z) / (2 * PI)) * static_cast<float>(w);
        size_t row = 0;
        while (row + 1 < h && d.y < e.row_cosines[row + 1]) ++row;
        ++counted[row * w + std::min(static_cast<size_t>(column), w - 1)];
    }
    CHECK(unevenness(counted, expected) < 4.5, "%s: %g", name, unevenness(counted, expected));
    // A few lie so near to a texel's edge that rounding puts them across it.
    CHECK(differing < 1200, "%s: %d have another pdf afterwards", name, differing);
}

void test_environments() {
    uint64_t seed = 1;
    for (const auto &[width, height] : {std::pair{16, 8}, {7, 5}, {9, 1}}) {
        Random random{seed++};
        std::vector<Vec3> texels;
        for (int i = 0; i < width * height; ++i) {
            const float v = random();
            texels.push_back({v * v * v, v * random(), 0.2f * random()});
        }
        texels[5] = {3, 2, 1};
        check_environment(environment_create(width, height, texels), "random texels");
    }
    // There is nothing to choose in an even one, nor in a dark one.
    for (const float light : {0.0f, 1.0f}) {
        const Environment even = *even_environment(light);
        CHECK(even.irradiance == 0 && environment_pdf(even, {0, 0, 1}) == 0, "%g", even.irradiance);
    }
    // Negative light, left by filters of pictures, is none.
    const Environment e = environment_create(2, 1, {{-1, 2, -3}, {1, 1, 1}});
    CHECK(e.texels[0].x == 0 && e.texels[0].y == 2, "%g", e.texels[0].x);
}

// The solid angle of an area light, by its samples and by directions that meet it.
void test_area_lights() {
    for (const bool triangle : {false, true}) {
        Scene scene;
        add_light(scene, add_diffuse(scene, {0, 0, 0}), {1, 1, 1}, {-1, 2, -0.5f},
                  {0.8f, 2.4f, -0.7f}, {0.9f, 1.8f, 0.9f}); // counter-clockwise from below
        Light &light = scene.lights[0];
        if (triangle) light.kind = Light::TRIANGLE, light.area /= 2;
        const Vec3 point = {0.1f, 0, 0.2f};
        Random random{5};
        Mean by_light, met;
        for (int i = 0; i < 200000; ++i) {
            const LightSample s = light_sample(light, point, {random(), random()});
            CHECK(s.pdf > 0, "light %d", triangle);
            by_light.add(1 / s.pdf);
            const float distance = length(s.point - point);
            for (const float pdf : {light_pdf(light, distance, -dot(light.normal, s.direction)),
                                    light_pdf_towards(light, point, s.direction)})
                CHECK(std::abs(pdf / s.pdf - 1) < 1e-3f || pdf == 0, "%g and %g", pdf, s.pdf);
            const Vec3 anywhere = phase_sample(0, {random(), random()});
            const bool hit = light_pdf_towards(light, point, anywhere) > 0;
            met.add(hit ? 4 * double{PI} : 0);
        }
        CHECK(std::abs(by_light.mean() - met.mean()) <
                  5 * std::hypot(met.error(), by_light.error()),
              "triangle %d: %g by samples, %g by rays", triangle, by_light.mean(), met.mean());
        // Not from behind, not from the edge.
        CHECK(light_sample(light, {0, 9, 0}, {0.5f, 0.5f}).pdf == 0, "it shines backwards");
        const Vec3 in_plane = light.corner + 7.0f * light.edge_u;
        const LightSample edge = light_sample(light, in_plane, {0.5f, 0.5f});
        CHECK(edge.pdf >= 0 && !std::isnan(edge.pdf), "pdf %g", edge.pdf);
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
    add_light(scene, black, {2, 2, 2}, {7, 1, 0}, {8, 1, 0}, {8, 1, 1});
    scene.lights.back().both_sides = true;
    scene_finish(scene);
    CHECK(scene.lights.size() == 3, "%zu lights", scene.lights.size());
    const float expected[] = {0.125f, 0.375f, 0.5f};
    for (size_t i = 0; i < 3; ++i)
        CHECK(std::abs(scene.lights[i].probability - expected[i]) < 1e-5f, "%g",
              scene.lights[i].probability);
    CHECK(scene.triangles.size() == 8, "%zu triangles", scene.triangles.size());
    const int32_t lights[] = {0, 0, -1, -1, 1, 1, 2, 2};
    for (size_t i = 0; i < 8; ++i)
        CHECK(scene.surfaces[i].light == lights[i], "surface %zu: %d", i, scene.surfaces[i].light);
}

} // namespace

int main() {
    test_distribution_is_exact();
    test_environments();
    test_area_lights();
    test_lights_by_power();
    return 0;
}
