// SPDX-License-Identifier: Apache-2.0
// Things that move while the shutter is open: what each pixel sees, and that a path has one time.
//
// Seeds are fixed. Bounds are at least five standard deviations wide: chance passes one of them
// less than once in a million.
#include <cmath>
#include <vector>

#include "check.h"
#include "integrator.h"
#include "scene_builder.h"
#include "scenes.h"

namespace {

constexpr int PIXELS = 32; // of a picture, across; one row is enough

// Mean radiance of each pixel of the middle row.
std::vector<double> row_of(Scene &scene, uint32_t spp, uint32_t max_depth, const char *name) {
    camera_fit(scene.camera, PIXELS, PIXELS);
    const GeometryPointer geometry = geometry_build(scene);
    const SamplerPointer sampler = sampler_named(name);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), max_depth};
    PathCounters counters;
    std::vector<double> row;
    for (int x = 0; x < PIXELS; ++x) {
        double sum = 0;
        for (uint32_t index = 0; index < spp; ++index)
            sum += static_cast<double>(
                trace_path(integrator, x, PIXELS / 2, index, counters).radiance.x);
        row.push_back(sum / spp);
    }
    return row;
}

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
    const double low = -0.5, high = 0.3, by = 0.7;
    Scene scene;
    scene.camera = camera_look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.25f);
    if (lens > 0) camera_set_lens(scene.camera, lens, {0, 0, 0}); // the square is in focus
    scene.light_samples = light_samples;
    scene.environment = even_environment();
    add_quad(scene, add_diffuse(scene, {0, 0, 0}), {-0.5f, -2, 0}, {0.3f, -2, 0}, {0.3f, 2, 0},
             {-0.5f, 2, 0});
    add_motion(scene, 0, [](Vec3 p) { return p + Vec3{0.7f, 0, 0}; });
    scene_finish(scene);
    const uint32_t spp = 4096;
    const std::vector<double> row = row_of(scene, spp, 2, sampler);
    int partial = 0;
    for (int x = 0; x < PIXELS; ++x) {
        // At the square's distance the picture is two wide.
        const double covered =
            coverage(2.0 * x / PIXELS - 1, 2.0 * (x + 1) / PIXELS - 1, low, high, by);
        const double deviation = std::sqrt(covered * (1 - covered) / spp);
        const double seen = 1 - row[static_cast<size_t>(x)];
        CHECK(std::abs(seen - covered) <= 5 * deviation + 1e-4, "%s, pixel %d: %g, should be %g",
              sampler, x, seen, covered);
        partial += covered > 0.01 && covered < 0.99;
    }
    CHECK(partial > 15, "%d pixels", partial);
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
        for (const double v : row_of(scene, 512, 4, sampler))
            CHECK(!(v > 0), "%s: %g of light in full shadow", sampler, v);
    // Without the upper plate there is light to be seen.
    scene.triangles.resize(scene.triangles.size() - 2);
    scene.surfaces.resize(scene.surfaces.size() - 2);
    double sum = 0;
    for (const double v : row_of(scene, 512, 4, "blue")) sum += v;
    CHECK(sum > 0, "the lower plate is dark by itself");
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
