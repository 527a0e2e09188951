// SPDX-License-Identifier: Apache-2.0
// Tests the medium: tracking against integrals of the density, and images of fog that are known
// without rendering. Seeds are fixed.
#include "medium.h"

#include "scenes.h"

namespace {

// A linear density, which interpolation reproduces exactly, except in half a cell at each side.
Medium ramp_medium() {
    return medium_create({-1, -1, -1}, {3, 1, 1}, {40, 20, 12}, {1, 1, 1}, 0,
                         [](Vec3 p) { return 0.3f + 0.2f * p.x + 0.1f * p.y; });
}

// The integral of the density along a ray, by the midpoint rule.
double optical_depth(const Medium &m, const Ray &ray, double end) {
    const int steps = 20000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const Vec3 p = ray.origin + float(end * (i + 0.5) / steps) * ray.direction;
        const bool inside = p.x > m.low.x && p.x < m.high.x && p.y > m.low.y && p.y < m.high.y &&
                            p.z > m.low.z && p.z < m.high.z;
        if (inside) sum += medium_density(m, p) * end / steps;
    }
    return sum;
}

const Ray RAYS[] = {
    {{-2, 0, 0}, {1, 0, 0}},                    // along an axis, from outside
    {{4, 0.3f, -0.2f}, {-1, 0, 0}},             // in the opposite direction
    {{0.1f, 0.2f, 0.3f}, {0, -1, 0}},           // from inside
    {{-2, -1.1f, 0.4f}, {0.8f, 0.48f, -0.36f}}, // diagonal
    {{2.9f, 0.9f, 0.9f}, {-0.6f, -0.64f, -0.48f}},
};

void test_transmittance_and_free_flight() {
    const Medium medium = ramp_medium();
    for (const char *name : {"white", "blue"}) {
        const SamplerPointer sampler = sampler_create(name);
        for (const Ray &ray : RAYS)
            for (const float end : {1.5f, 2.6f, 50.0f}) {
                Mean passed, flown;
                for (int i = 0; i < 40000; ++i) {
                    const auto walk = [&](uint32_t k) {
                        return with_path(*sampler, i % 200, i / 200, 0, [k](const auto &path) {
                            return path.ray(1).draw_loop(k);
                        });
                    };
                    bn::LoopSampler numbers = walk(0);
                    const float share = medium_transmittance(medium, ray, end, numbers);
                    CHECK(share >= 0 && share <= 1, "transmittance %g", share);
                    passed.add(share);
                    numbers = walk(1);
                    const float distance = medium_free_flight(medium, ray, end, numbers);
                    CHECK(distance >= 0 && (distance <= end || std::isinf(distance)),
                          "free flight of %g, ray of %g", distance, end);
                    flown.add(distance <= end ? 0 : 1);
                }
                const double expected = std::exp(-optical_depth(medium, ray, end));
                check_mean(passed, expected, "transmittance");
                check_mean(flown, expected, "free flight");
            }
    }
}

// A ray that misses the box or ends before it does not scatter and draws no numbers.
void test_rays_that_miss_the_box() {
    const Medium medium = ramp_medium();
    const bn::Sampler sampler;
    bn::LoopSampler numbers = bn::PathSampler(sampler, 1, 2, 3).ray(0).draw_loop(0),
                    fresh = numbers;
    for (const auto &[ray, end] : {std::pair{Ray{{-2, 1.5f, 0}, {1, 0, 0}}, 100.0f},
                                   {Ray{{-2, 0, 0}, {-1, 0, 0}}, 100.0f},
                                   {Ray{{-2, 0, 0}, {0, 1, 0}}, 100.0f},
                                   {Ray{{5, 5, 5}, {0.6f, 0, 0.8f}}, 100.0f},
                                   {RAYS[0], 0.9f}}) {
        CHECK(std::isinf(medium_free_flight(medium, ray, end, numbers)), "the ray scattered");
        CHECK(medium_transmittance(medium, ray, end, numbers) == 1, "the ray lost light");
    }
    CHECK(numbers.next_1d() == fresh.next_1d(), "numbers were drawn");
}

// Every density is within the range of its block. Otherwise, tracking would create light.
void test_densities_are_within_their_ranges() {
    const Scene fog = scene_build("fog", {});
    const Medium &m = *fog.medium;
    Random random{3};
    Mean loose, mean;
    for (int i = 0; i < 400000; ++i) {
        const float u[3] = {random(), random(), random()};
        const Vec3 p = m.low + Vec3{u[0], u[1], u[2]} * (m.high - m.low);
        size_t index = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const int cell = int(u[axis] * float(m.size[axis]));
            index = index * m.blocks[axis] + cell / Medium::BLOCK;
        }
        const auto [least, most] = m.ranges[index];
        const float density = medium_density(m, p), rounding = 1e-5f * most;
        CHECK(density >= least - rounding && density <= most + rounding, "%g is not in %g to %g",
              density, least, most);
        loose.add(most - least);
        mean.add(density);
    }
    CHECK(loose.sum < 2 * mean.sum, "mean width %g of a range, mean density %g", loose.mean(),
          mean.mean());
}

// ---- Images

Scene fog_alone(Medium medium, float sky) {
    Scene scene;
    scene.camera = camera_look_at({1, 0, 6}, {1, 0, 0}, {0, 1, 0}, 0.05f);
    scene.medium = std::make_shared<Medium>(std::move(medium));
    if (sky > 0) scene.environment = even_environment(sky);
    return scene;
}

// Under a uniform sky, fog that absorbs nothing is invisible, and so is a white ball in it.
void test_furnace() {
    for (const float g : {0.0f, 0.8f, -0.5f})
        for (const bool ball : {false, true}) {
            Medium medium = medium_create({-1, -1, -1}, {3, 1, 1}, {24, 12, 9}, {1, 1, 1}, g,
                                          [](Vec3 p) { return 1.5f + std::sin(3 * p.x + p.y); });
            Scene scene = fog_alone(std::move(medium), 1);
            if (ball) add_sphere(scene, add_diffuse(scene, {1, 1, 1}), {1, 0, 0}, 0.3f);
            scene_finish(scene);
            check_mean(render(scene, {24, 1000, "white"}).mean, 1, ball ? "a ball in fog" : "fog");
        }
}

// Fog below a small lamp, seen across the lamp's beam, has the integral of single scattering.
void test_single_scattering_of_a_lamp() {
    const float density = 0.5f, side = 0.02f, radiance = 1e5f;
    Medium medium = medium_create({-1, -1, -1}, {3, 1, 1}, {8, 8, 8}, {1, 1, 1}, 0,
                                  [=](Vec3) { return density; });
    Scene scene = fog_alone(std::move(medium), 0);
    add_panel(scene, add_diffuse(scene, {0, 0, 0}), {radiance, radiance, radiance}, {1, 4, 0},
              {1, 0, 0}, side, side);
    scene_finish(scene);
    scene.camera = camera_look_at({1, 0, 6}, {1, 0, 0}, {0, 1, 0}, 0.002f);
    double expected = 0;
    const int steps = 4000;
    for (int i = 0; i < steps; ++i) {
        const double z = -1 + 2 * (i + 0.5) / steps, distance = std::sqrt(16 + z * z);
        const double in_fog = distance / 4; // fog fills a quarter of the way to the lamp
        const double lit = double{radiance} * side * side * 4 / distance / (distance * distance);
        expected += std::exp(-density * (1 - z + in_fog)) * density * lit / (4 * PI) * 2 / steps;
    }
    for (const char *sampler : {"white", "blue", "sobol"})
        check_mean(render(scene, {200, 1, sampler}).mean, expected, sampler);
}

// The layers for denoisers ignore fog and show the surfaces behind it.
void test_layers_ignore_fog() {
    Scene scene = scene_build("fog", {});
    const Render foggy = render(scene, {2, 3, "blue"});
    scene.medium = nullptr;
    const Render clear = render(scene, {2, 3, "blue"});
    for (size_t i = 0; i < clear.samples.size(); ++i) {
        const PathSample &a = foggy.samples[i], &b = clear.samples[i];
        CHECK(a.hit == b.hit && a.depth == b.depth && length(a.albedo - b.albedo) == 0 &&
                  length(a.normal - b.normal) == 0,
              "sample %zu differs", i);
    }
}

} // namespace

int main() {
    geometry_thread_begin();
    test_transmittance_and_free_flight();
    test_rays_that_miss_the_box();
    test_densities_are_within_their_ranges();
    test_furnace();
    test_single_scattering_of_a_lamp();
    test_layers_ignore_fog();
    return 0;
}
