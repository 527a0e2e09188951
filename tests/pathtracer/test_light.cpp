// SPDX-License-Identifier: Apache-2.0
// Tests how lights, points on lights and directions to the environment are sampled: samples follow the
// stated pdf, and estimates converge to the correct integrals. Seeds are fixed.
#include "light.h"

#include "scenes.h"

namespace {

// Probabilities are multiples of the draws' step, so a loop over all draws proves that they are exact.
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
            const Choice c = distribution_choose(limits.data(), n, float(i) * DRAW_STEP);
            ++counted[c.index];
            CHECK(c.rest > 0 && c.rest < 1, "rest %g of index %zu", c.rest, c.index);
        }
        double total = 0;
        for (const double w : weights) total += w;
        for (size_t i = 0; i < n; ++i) {
            const float stated = limits[i + 1] - limits[i];
            CHECK(float(counted[i]) * DRAW_STEP == stated, "%u, not %g", counted[i], stated);
            CHECK((counted[i] > 0) == (weights[i] > 0), "index %zu: %u", i, counted[i]);
            CHECK(std::abs(stated - weights[i] / total) < double(n + 1) * DRAW_STEP,
                  "index %zu: %g", i, stated);
        }
    }
}

// Checks that the pdf integrates to 1, that directions follow it, and that they return their texels.
void check_environment(const Environment &e, const char *name) {
    constexpr int COUNT = 400000;
    const auto w = size_t(e.width), h = size_t(e.height);
    std::vector<double> expected, counted(w * h);
    double total = 0;
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) {
            const float cosine = (e.row_cosines[y] + e.row_cosines[y + 1]) / 2;
            const float longitude = 2 * PI * (0.5f - (float(x) + 0.5f) / float(w));
            const float sine = std::sqrt(1 - cosine * cosine);
            const Vec3 d = {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
            CHECK(length(environment_radiance(e, d) - e.texels[y * w + x]) == 0, "%s: %zu, %zu",
                  name, x, y);
            const double share = 2 * double{PI} / e.width * environment_pdf(e, d) *
                                 (e.row_cosines[y] - e.row_cosines[y + 1]);
            expected.push_back(COUNT * share);
            total += share;
        }
    CHECK(std::abs(total - 1) < 1e-4, "%s: the pdf integrates to %g", name, total);
    Random random{17};
    int differing = 0;
    for (int i = 0; i < COUNT; ++i) {
        const Vec2 u = {random(), random()};
        const auto [d, pdf] = environment_sample(e, u);
        CHECK(pdf > 0 && std::isfinite(pdf) && std::abs(length(d) - 1) < 1e-4f, "%s: %g", name,
              pdf);
        differing += std::abs(environment_pdf(e, d) - pdf) > 1e-5f * pdf ? 1 : 0;
        const float column = (0.5f - std::atan2(d.x, d.z) / (2 * PI)) * float(w);
        size_t row = 0;
        while (row + 1 < h && d.y < e.row_cosines[row + 1]) ++row;
        ++counted[row * w + std::min(size_t(column), w - 1)];
    }
    CHECK(unevenness(counted, expected) < 4.5, "%s: %g", name, unevenness(counted, expected));
    // A few directions lie so close to a texel's edge that rounding moves them across it.
    CHECK(differing < 1200, "%s: %d directions have a different pdf", name, differing);
}

void test_environment_sampling() {
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
    // Uniform and black environments are not sampled.
    for (const float light : {0.0f, 1.0f}) {
        const Environment even = *even_environment(light);
        CHECK(even.irradiance == 0 && environment_pdf(even, {0, 0, 1}) == 0, "%g", even.irradiance);
    }
}

// The solid angle of a triangle seen from the origin (Van Oosterom and Strackee, "The Solid Angle of a
// Plane Triangle", 1983).
double solid_angle(Point3d a, Point3d b, Point3d c) {
    const double la = length(a), lb = length(b), lc = length(c);
    return 2 * std::atan2(std::abs(dot(a, cross(b, c))),
                          la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

// The mean of 1 / pdf is an area light's solid angle.
void test_area_light_sampling() {
    for (const bool triangle : {false, true}) {
        Scene scene;
        add_light(scene, add_diffuse(scene, {0, 0, 0}), {1, 1, 1}, {-1, 2, -0.5f},
                  {0.8f, 2.4f, -0.7f}, {0.9f, 1.8f, 0.9f}); // counter-clockwise from below
        Light &light = scene.lights[0];
        if (triangle) light.kind = Light::TRIANGLE, light.area /= 2;
        const Vec3 point = {0.1f, 0, 0.2f};
        Random random{5};
        Mean seen;
        for (int i = 0; i < 200000; ++i) {
            const LightSample s = light_sample(light, point, {random(), random()});
            CHECK(s.pdf > 0, "light %d", triangle);
            seen.add(1 / s.pdf);
            const float distance = length(s.point - point);
            const float pdf = light_pdf(light, distance, -dot(light.normal, s.direction));
            CHECK(std::abs(pdf / s.pdf - 1) < 1e-3f, "%g and %g", pdf, s.pdf);
        }
        const Point3d a = light.corner - point, b = a + Point3d(light.edge_u),
                      c = a + Point3d(light.edge_v);
        check_mean(seen, solid_angle(a, b, c) + (triangle ? 0 : solid_angle(b, b + c - a, c)),
                   "solid angle");
        // The light does not shine backwards, and the pdf is not NaN in the light's plane.
        CHECK(light_sample(light, {0, 9, 0}, {0.5f, 0.5f}).pdf == 0, "it shines backwards");
        const Vec3 in_plane = light.corner + 7.0f * light.edge_u;
        const LightSample edge = light_sample(light, in_plane, {0.5f, 0.5f});
        CHECK(edge.pdf >= 0 && !std::isnan(edge.pdf), "pdf %g", edge.pdf);
    }
    for (const float side : {2e-13f, 1e10f}) {
        const float area =
            area_light(Light::PARALLELOGRAM, {}, {side, 0, 0}, {0, 0, side}, Vec3(1)).area;
        CHECK(std::abs(area / (side * side) - 1) < 1e-6f, "area %g of side %g", area, side);
    }
}

// Lights without power or area are dropped, and surfaces refer to the remaining lights.
void test_lights_without_power_or_area_are_dropped() {
    Scene scene;
    const uint32_t black = add_diffuse(scene, {0, 0, 0});
    add_light(scene, black, {1, 1, 1}, {0, 1, 0}, {1, 1, 0}, {1, 1, 1});
    add_light(scene, black, {0, 0, 0}, {2, 1, 0}, {3, 1, 0}, {3, 1, 1});
    add_light(scene, black, {3, 3, 3}, {4, 1, 0}, {5, 1, 0}, {5, 1, 1});
    add_light(scene, black, {9, 9, 9}, {6, 1, 0}, {6, 1, 0}, {6, 1, 1}); // no area
    scene_finish(scene);
    CHECK(scene.lights.size() == 2 && scene.triangles.size() == 6, "%zu lights",
          scene.lights.size());
    const int32_t lights[] = {0, 0, -1, -1, 1, 1};
    for (size_t i = 0; i < 6; ++i)
        CHECK(scene.triangles[i].light == lights[i], "triangle %zu: %d", i,
              scene.triangles[i].light);
}

std::vector<Light> random_lights(int count, Random &random) {
    const auto vector = [&] { return Vec3{random(), random(), random()} - 0.5f; };
    std::vector<Light> lights;
    for (int i = 0; i < count; ++i) {
        Light light = area_light(i % 2 ? Light::TRIANGLE : Light::PARALLELOGRAM, 8.0f * vector(),
                                 vector(), vector(), Vec3(0.1f + random()));
        light.both_sides = i % 5 == 0;
        if (i % 7 == 3)
            light.kind = i % 3 ? Light::POINT : i % 2 ? Light::SPOT : Light::DIRECTIONAL;
        if (light.kind >= Light::POINT) light.edge_u = light.edge_v = Vec3(0);
        light.cosine_inner = 0.9f;
        light.cosine_outer = 0.6f;
        lights.push_back(light);
    }
    return lights;
}

// Lights are chosen with the stated probability, which is the same when a ray hits the light. Lights
// that are never chosen contribute nothing. The remainder of the random number is uniform. The number
// of lights ranges from one light to a tree of many levels.
void test_light_choice_follows_the_stated_probabilities() {
    Random random{3};
    for (const int count : {1, 2, 8, 9, 60, 1500}) {
        const std::vector<Light> lights = random_lights(count, random);
        const LightTree tree = light_tree(lights);
        for (int n = 0; n < 12; ++n) {
            const Vec3 normal = phase_sample(0, {random(), random()});
            const Receiver to = {8.0f * (Vec3{random(), random(), random()} - 0.5f), normal,
                                 n % 3 > 0};
            std::vector<double> expected, counted(lights.size() + 1);
            double total = 0;
            for (uint32_t i = 0; i < lights.size(); ++i) {
                const float probability = light_probability(tree, to, i);
                CHECK(probability >= 0 && probability <= 1, "%g", probability);
                total += probability;
                expected.push_back(20000 * double{probability});
                for (int k = 0; k < 8 && probability == 0; ++k) {
                    const LightSample s = light_sample(lights[i], to.point, {random(), random()});
                    CHECK(!(s.pdf > 0) || (to.one_side && dot(s.direction, normal) <= 1e-5f),
                          "light %u of %d contributes but is never chosen", i, count);
                }
            }
            CHECK(total < 1.001, "%d lights: %g", count, total);
            // A node may promise light that no child delivers. Then no light is chosen.
            expected.push_back(20000 * std::max(1 - total, 0.0));
            Mean left;
            for (int k = 0; k < 20000; ++k) {
                float u = (float(k) + random()) / 20000;
                const LightChoice choice = light_choose(tree, to, u);
                if (choice.light < 0) {
                    ++counted.back();
                    continue;
                }
                const auto chosen = uint32_t(choice.light);
                const float again = light_probability(tree, to, chosen);
                CHECK(std::abs(again - choice.probability) <= 1e-5f * again, "%g and %g", again,
                      choice.probability);
                CHECK(u >= 0 && u < 1, "the remainder is %g", u);
                ++counted[chosen];
                left.add(u);
            }
            // Stratified draws make the counts more even than independent draws would.
            CHECK(unevenness(counted, expected) < 4.5, "%d lights: %g", count,
                  unevenness(counted, expected));
            if (left.count < 2) continue;
            check_mean(left, 0.5, "remainder");
        }
    }
}

// Lights of every type that send the same light to a point straight below have the same probability,
// even if one has 1e8 times the power of another and is 1e4 times as far away.
void test_equally_bright_lights_have_the_same_probability() {
    const Receiver floor = {{0, 0, 0}, {0, 1, 0}, true};
    const float side = 1e-3f;
    Light panel = area_light(Light::PARALLELOGRAM, {0, 2, 0}, {side, 0, 0}, {0, 0, side},
                             Vec3(4 / (side * side)));
    panel.normal = {0, -1, 0};
    Light triangle = panel, point = panel, spot = panel, sun = panel;
    triangle.kind = Light::TRIANGLE;
    triangle.area = 0.5f * panel.area;
    triangle.radiance = 2.0f * panel.radiance;
    point.kind = Light::POINT;
    spot.kind = Light::SPOT;
    sun.kind = Light::DIRECTIONAL;
    spot.cosine_outer = 0.9f;
    point.edge_u = point.edge_v = spot.edge_u = spot.edge_v = {0, 0, 0};
    spot.radiance = Vec3(4);
    point.corner = {0, 2e4f, 0};
    point.radiance = Vec3(4e8f);
    sun.radiance = Vec3(1);
    const LightTree tree = light_tree({panel, triangle, point, spot, sun});
    for (uint32_t i = 0; i < 5; ++i)
        CHECK(std::abs(light_probability(tree, floor, i) - 0.2f) < 0.002f, "light %u: %g", i,
              light_probability(tree, floor, i));
}

// The power heuristic's exponent is 2.
void test_power_heuristic() {
    CHECK(power_heuristic(1, 0) == 1 && std::abs(power_heuristic(2, 1) - 0.8f) < 1e-6f &&
              std::abs(power_heuristic(1, 3) - 0.1f) < 1e-6f,
          "%g", power_heuristic(2, 1));
}

} // namespace

int main() {
    test_distribution_is_exact();
    test_environment_sampling();
    test_area_light_sampling();
    test_lights_without_power_or_area_are_dropped();
    test_equally_bright_lights_have_the_same_probability();
    test_power_heuristic();
    test_light_choice_follows_the_stated_probabilities();
    return 0;
}
