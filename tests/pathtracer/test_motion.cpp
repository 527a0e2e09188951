// SPDX-License-Identifier: Apache-2.0
// Things that move while the shutter is open: what each pixel sees, and that a path has one time.
//
// Seeds are fixed. Bounds are at least five standard deviations wide: chance passes one of them
// less than once in a million.
#include "scenes.h"

namespace {

// How much of a pixel from `a` to `b`, over the time that the shutter is open, is covered by an
// interval from `low` to `high` that moves by `by`.
double coverage(double a, double b, double low, double high, double by) {
    const int steps = 2000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double moved = by * (i + 0.5) / steps;
        sum += std::max(std::min(b, high + moved) - std::max(a, low + moved), 0.0);
    }
    return sum / steps / (b - a);
}

// A square that moves before an even sky: black, so each pixel is what the square leaves.
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
    const Picture seen = picture(scene, {spp, 2, sampler});
    int partial = 0;
    for (int x = 0; x < SIDE; ++x) {
        // At the square's distance the picture is two wide; all rows are alike.
        const double covered =
            coverage(2.0 * x / SIDE - 1, 2.0 * (x + 1) / SIDE - 1, -0.5, 0.3, 0.7);
        Mean sky;
        for (size_t i = 0; i < seen.samples.size(); ++i)
            if (static_cast<int>(i / spp % SIDE) == x) sky.add(seen.samples[i].radiance.x);
        const double deviation = std::sqrt(covered * (1 - covered) / sky.count);
        CHECK(std::abs(1 - sky.mean() - covered) <= 5 * deviation + 1e-4,
              "%s, column %d: %g, should be %g", sampler, x, 1 - sky.mean(), covered);
        partial += covered > 0.01 && covered < 0.99;
    }
    CHECK(partial > 11, "%d columns", partial);
}

// A plate that moves along below another stays in its shadow at all times, whatever the bounce.
void test_a_path_has_one_time() {
    Scene scene;
    scene.camera = camera_look_at({0, 0.6f, 5}, {0, 0, 0}, {0, 1, 0}, 0.02f);
    const uint32_t white = add_diffuse(scene, {1, 1, 1});
    const uint32_t black = add_diffuse(scene, {0, 0, 0});
    add_light_towards(scene, black, {1e5f, 1e5f, 1e5f}, {0, 40, 0}, {0, 0, 0}, 0.1f, 0.1f);
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
        CHECK(picture(scene, {64, 4, sampler}).mean.sum == 0, "%s: light in full shadow", sampler);
    // Without the upper plate there is light to be seen.
    scene.triangles.resize(scene.triangles.size() - 2);
    scene.surfaces.resize(scene.surfaces.size() - 2);
    CHECK(picture(scene, {64, 4, "blue"}).mean.sum > 0, "the lower plate is dark by itself");
}

} // namespace

int main() {
    geometry_thread_begin();
    for (const char *sampler : {"white", "blue", "sobol"}) {
        test_coverage_of_a_moving_square(sampler, 0, 1);
        test_coverage_of_a_moving_square(sampler, 0, 3);
        test_coverage_of_a_moving_square(sampler, 0.1f, 1);
    }
    test_a_path_has_one_time();
    return 0;
}
