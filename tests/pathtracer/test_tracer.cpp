// SPDX-License-Identifier: Apache-2.0
// Renders small images of difficult scenes: degenerate, duplicate and needle-shaped faces, two-sided
// lights, no lights, and moving objects. Expected values are known without rendering where possible.
//
// Seeds are fixed. Tolerances are at least five standard deviations of the estimate, which chance would
// exceed less than once in a million with fresh seeds.
#include "scenes.h"

namespace {

void check_near(const Render &seen, double expected, double relative, const char *what) {
    CHECK(std::abs(seen.mean.mean() - expected) <= relative * expected, "%s: %g, should be %g",
          what, seen.mean.mean(), expected);
}

// Degenerate and duplicate faces change nothing: they are dropped, or too thin to be visible.
void test_degenerate_and_duplicate_faces() {
    Scene clean = scene_build("cornell", {});
    // Unlike diffuse surfaces, metal is wrong without valid normals.
    clean.materials[0] = {Material::METALLIC_ROUGHNESS, Vec3(0.7f), Vec3(1), 0.5f};
    Scene broken = clean;
    const auto triangle = [&](Vec3 a, Vec3 b, Vec3 c) {
        const auto first = uint32_t(broken.vertices.size());
        broken.vertices.insert(broken.vertices.end(), {a, b, c});
        broken.triangles.push_back({{first, first + 1, first + 2}, 0});
    };
    const Vec3 a = {278, 200, 100}, b = {300, 250, 120};
    triangle(a, a, a);
    triangle(a, b, b);
    triangle(a, b, 0.5f * (a + b));
    // Needles across the image, one a hundred-thousandth as wide as long, one even thinner.
    triangle({0, 100, 10}, {550, 100, 10}, {550, 100.005f, 10});
    triangle({0, 200, 10}, {550, 200, 10}, {550, 200.00002f, 10});
    // Duplicates of every face, one of them reversed. Lamps have none, because it is undefined which
    // of two coincident faces is in front.
    for (size_t i = 0; i < clean.triangles.size(); ++i) {
        Triangle again = clean.triangles[i];
        if (again.light >= 0) continue;
        broken.triangles.push_back(again);
        std::swap(again.vertices[0], again.vertices[1]);
        broken.triangles.push_back(again);
    }
    // Where vertex normals have length zero, the triangle's normal is used.
    broken.normals.assign(broken.vertices.size(), {0, 0, 0});
    const size_t count = broken.triangles.size();
    scene_finish(broken);
    CHECK(broken.triangles.size() <= count - 2, "%zu of %zu left", broken.triangles.size(), count);
    check_near(render(broken, {}), render(clean, {}).mean.mean(), 0.005, "broken faces");
}

void test_empty_and_unlit_scenes() {
    for (const bool floor : {false, true})
        for (const float sky : {-1.0f, 0.0f, 1.0f}) { // below 0: no sky
            Scene scene = floor ? floor_scene({1, 1, 1}) : Scene{};
            scene.camera = camera_look_at({0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.2f);
            if (sky >= 0) scene.environment = even_environment(sky);
            scene_finish(scene);
            check_near(render(scene, {}), std::max(sky, 0.0f), 1e-5, "empty scene or white floor");
        }
}

// In a room whose walls and ceiling emit light from one side or both, a floor receives uniform light.
// Scattered rays and light samples find it about equally well, so wrong MIS weights are detected for
// any number of light samples. The same holds under a sky. Half of it is black, because a uniform sky
// is found by scattered rays only.
void test_mis_weights() {
    const auto check = [](Scene &scene, double expected, const char *what) {
        scene_finish(scene);
        CHECK(!scene.lights.empty(), "%s: no light to sample", what);
        for (const uint32_t count : {1u, 2u, 8u}) {
            scene.light_samples = count;
            check_near(render(scene, {16, 1, "sobol", count}), expected, 0.01, what);
        }
    };
    for (const bool metal : {false, true})
        for (const bool turned : {false, true}) {
            Scene room;
            room.camera = camera_look_at({0, 0.9f, 0}, {0, 0, 0}, {0, 0, -1}, 0.3f);
            const uint32_t floor = metal ? add_conductor(room, {1, 1, 1}, 0.5f)
                                         : add_diffuse(room, {0.5f, 0.5f, 0.5f});
            const Vec3 low[4] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}, up = {0, 1, 0};
            add_quad(room, floor, low[3], low[2], low[1], low[0]);
            const uint32_t black = add_diffuse(room, {0, 0, 0});
            // One light, or nine lights, which form a tree of multiple levels.
            const auto shine = [&](Vec3 a, Vec3 b, Vec3 c) {
                const int parts = metal ? 1 : 3;
                const Vec3 u = (b - a) / float(parts), v = (c - b) / float(parts);
                for (int i = 0; i < parts * parts; ++i) {
                    const Vec3 corner = a + float(i % parts) * u + float(i / parts) * v;
                    const Vec3 ends[] = {corner, corner + u, corner + u + v};
                    add_light(room, black, {1, 1, 1}, ends[turned ? 2 : 0], ends[1],
                              ends[turned ? 0 : 2]);
                    room.lights.back().both_sides = turned;
                }
            };
            for (int i = 0; i < 4; ++i) shine(low[i], low[(i + 1) % 4], low[(i + 1) % 4] + up);
            shine(low[0] + up, low[1] + up, low[2] + up);
            check(room, metal ? 1 : 0.5, metal ? "metal in a glowing room" : "a glowing room");
        }
    Scene outside = floor_scene();
    std::vector<Vec3> texels(16 * 8, {0, 0, 0});
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 16 < 8) texels[i] = {2, 2, 2};
    outside.environment = std::make_shared<Environment>(environment_create(16, 8, texels));
    check(outside, 0.5, "half a sky");
}

// Inside rough glass in a uniformly lit room, everything has the room's radiance. Light samples and
// scattered rays find it from the back of the glass surface.
void test_light_samples_from_inside_glass() {
    Scene scene = scene_build("furnace", {});
    scene.materials[0].albedo = Vec3(0);
    const uint32_t glass = add_dielectric(scene, 2.4f, 0.3f);
    add_box(scene, glass, scene.camera.position, {0.2f, 0, 0}, {0, 0.2f, 0}, {0, 0, 0.2f});
    scene_finish(scene);
    check_near(render(scene, {32, 100}), 0.5, 0.01, "from inside glass");
}

// ---- Motion while the shutter is open

// The fraction of a pixel from `a` to `b` covered by an interval from `low` to `high` that moves by
// `by`, averaged over the time the shutter is open.
double coverage(double a, double b, double low, double high, double by) {
    const int steps = 2000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double moved = by * (i + 0.5) / steps;
        sum += std::max(std::min(b, high + moved) - std::max(a, low + moved), 0.0);
    }
    return sum / steps / (b - a);
}

// A black square moves in front of a uniform sky, so each pixel shows how much sky is left uncovered.
void test_coverage_of_a_moving_square(const char *sampler, float lens, uint32_t light_samples) {
    Scene scene;
    scene.camera = camera_look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.25f);
    if (lens > 0) camera_set_lens(scene.camera, lens, {0, 0, 0}); // the square is in focus
    scene.light_samples = light_samples;
    scene.environment = even_environment();
    add_quad(scene, add_diffuse(scene, {0, 0, 0}), {-0.5f, -2, 0}, {0.3f, -2, 0}, {0.3f, 2, 0},
             {-0.5f, 2, 0});
    add_motion(scene, 0, [](Vec3 p) { return p + Vec3{0.7f, 0, 0}; });
    scene_finish(scene);
    const uint32_t spp = 256;
    const Render seen = render(scene, {spp, 2, sampler});
    int partial = 0;
    for (int x = 0; x < SIDE; ++x) {
        // At the square's distance, the image is two units wide. All rows have the same coverage.
        const double covered =
            coverage(2.0 * x / SIDE - 1, 2.0 * (x + 1) / SIDE - 1, -0.5, 0.3, 0.7);
        Mean sky;
        for (size_t i = 0; i < seen.samples.size(); ++i)
            if (int(i / spp % SIDE) == x) sky.add(seen.samples[i].radiance.x);
        const double deviation = std::sqrt(covered * (1 - covered) / sky.count);
        CHECK(std::abs(1 - sky.mean() - covered) <= 5 * deviation + 1e-4,
              "%s, column %d: %g, should be %g", sampler, x, 1 - sky.mean(), covered);
        partial += covered > 0.01 && covered < 0.99;
    }
    CHECK(partial > 11, "%d partially covered columns", partial);
}

// A plate moves along with another one above it and stays in its shadow at all times, at every bounce.
void test_all_bounces_of_a_path_use_the_same_time() {
    Scene scene;
    scene.camera = camera_look_at({0, 0.6f, 5}, {0, 0, 0}, {0, 1, 0}, 0.02f);
    const uint32_t white = add_diffuse(scene, {1, 1, 1});
    const uint32_t black = add_diffuse(scene, {0, 0, 0});
    add_panel(scene, black, {1e5f, 1e5f, 1e5f}, {0, 40, 0}, {0, 0, 0}, 0.1f, 0.1f);
    const size_t first = scene.vertices.size();
    const auto plate = [&](uint32_t material, float y, float half) {
        add_quad(scene, material, {-half - 3, y, half}, {half - 3, y, half}, {half - 3, y, -half},
                 {-half - 3, y, -half});
    };
    plate(white, 0, 0.5f);
    plate(black, 1, 0.9f);
    add_motion(scene, first, [](Vec3 p) { return p + Vec3{6, 0, 0}; });
    scene_finish(scene);
    for (const char *sampler : {"blue", "white"})
        CHECK(render(scene, {64, 4, sampler}).mean.sum == 0, "%s: light in full shadow", sampler);
    // Without the upper plate, light is visible.
    scene.triangles.resize(scene.triangles.size() - 2);
    CHECK(render(scene, {64, 4, "blue"}).mean.sum > 0, "the lower plate is dark by itself");
}

} // namespace

int main() {
    geometry_thread_begin();
    test_empty_and_unlit_scenes();
    test_degenerate_and_duplicate_faces();
    test_mis_weights();
    test_light_samples_from_inside_glass();
    test_coverage_of_a_moving_square("white", 0, 1);
    test_coverage_of_a_moving_square("blue", 0, 3);
    test_coverage_of_a_moving_square("sobol", 0.1f, 1);
    test_all_bounces_of_a_path_use_the_same_time();
    return 0;
}
