// SPDX-License-Identifier: Apache-2.0
// Helpers that build scenes and render images for the tests.
#pragma once

#include <memory>
#include <vector>

#include "check.h"
#include "integrator.h"
#include "scene.h"

// A uniform sky.
inline std::shared_ptr<const Environment> even_environment(float radiance = 1) {
    return std::make_shared<const Environment>(
        environment_create(8, 4, std::vector<Vec3>(32, {radiance, radiance, radiance})));
}

constexpr int SIDE = 24; // an image's width and height

struct View {
    uint32_t spp = 16, max_depth = 8;
    const char *sampler = "sobol";
    uint64_t seed = 0;
};

struct Render {
    std::vector<PathSample> samples; // pixel by pixel
    Mean mean;                       // of the red channel
    PathCounters counters;
};

// Renders a finished scene, and checks that every sample is finite and not negative.
inline Render render(Scene &scene, const View &view) {
    camera_fit(scene.camera, SIDE, SIDE);
    const GeometryPointer geometry = geometry_build(scene);
    const SamplerPointer sampler = sampler_create(view.sampler, view.seed);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), view.max_depth};
    Render result;
    for (int i = 0; i < SIDE * SIDE; ++i)
        for (uint32_t index = 0; index < view.spp; ++index) {
            const PathSample s = trace_path(integrator, i % SIDE, i / SIDE, index, result.counters);
            const Vec3 v = s.radiance;
            CHECK(is_finite(v) && std::min({v.x, v.y, v.z}) >= 0, "a sample is %g", v.x);
            result.samples.push_back(s);
            result.mean.add(v.x);
        }
    return result;
}

// A camera looking down at the centre of an 8 x 8 floor.
inline Scene floor_scene(Vec3 albedo = {0.5f, 0.5f, 0.5f}) {
    Scene scene;
    scene.camera = camera_look_at({0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.2f);
    add_quad(scene, add_diffuse(scene, albedo), {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4});
    return scene;
}
