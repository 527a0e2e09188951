// SPDX-License-Identifier: Apache-2.0
// A room whose lamps are inside is black from outside. A few views are tried as small pictures, by
// the integrator itself: the one that shows most lit surface, farthest away, is taken.
#include "interior.h"

#include "integrator.h"
#include "scene_camera.h"
#include "scene_file.h"

namespace {

constexpr int SIZE = 32; // pixels of a trial, each side
constexpr uint32_t SAMPLES = 4, DEPTH = 4;

struct Trial {
    double lit;  // the share of the pixels that are not black
    double view; // the sum of their depths
};

// What the scene's camera sees.
Trial trial(Scene &scene, const Geometry &geometry, const Sampler &sampler) {
    camera_fit(scene.camera, SIZE, SIZE);
    const Integrator integrator = integrator_create(scene, geometry, &sampler, DEPTH);
    PathCounters counters;
    Trial result{};
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            bool lit = false;
            float depth = 0;
            for (uint32_t index = 0; index < SAMPLES; ++index) {
                const PathSample sample = trace_path(integrator, x, y, index, counters);
                lit = lit || max_component(sample.radiance) > 0;
                depth += sample.depth / SAMPLES;
            }
            if (!lit) continue;
            result.lit += 1.0 / (SIZE * SIZE);
            result.view += static_cast<double>(depth);
        }
    return result;
}

// From near each of the four corners to the opposite one, and from the middle to two sides.
std::vector<CameraChoice> inside_views(const Scene &scene) {
    const auto [low, high] = scene_bounds(scene);
    const Vec3 middle = 0.5f * (low + high), half = 0.5f * (high - low);
    std::vector<CameraChoice> views;
    const auto point = [&](Vec3 at) {
        const Vec3 v = middle + half * at;
        return Point3d{scene.origin.x + static_cast<double>(v.x),
                       scene.origin.y + static_cast<double>(v.y),
                       scene.origin.z + static_cast<double>(v.z)};
    };
    const auto add = [&](Vec3 from, Vec3 to) {
        if (!(max_magnitude(half * (to - from)) > 0)) return;
        CameraChoice view;
        view.eye = point(from);
        view.target = point(to);
        view.fov = 60;
        views.push_back(view);
    };
    for (const float x : {-0.7f, 0.7f})
        for (const float z : {-0.7f, 0.7f}) add({x, 0.2f, z}, {-x, -0.2f, -z});
    add({0, 0.1f, 0}, {0.9f, 0, 0});
    add({0, 0.1f, 0}, {0, 0, -0.9f});
    return views;
}

} // namespace

void frame_from_inside_if_black(Scene &scene, const std::string &name) {
    constexpr double BLACK = 0.02, SHOWN = 0.25;
    if (!is_scene_file(name) || !scene.cameras.empty() || scene.environment_light >= 0) return;
    const GeometryPointer geometry = geometry_build(scene);
    const SamplerPointer sampler = sampler_create({});
    const Camera outside = scene.camera;
    CameraChoice chosen; // as text: a resumed picture, which has the text alone, sees the same
    if (trial(scene, *geometry, *sampler).lit <= BLACK) {
        double best = 0;
        for (const CameraChoice &view : inside_views(scene)) {
            scene_choose_camera(scene, view);
            const std::string text = camera_text(scene, scene.camera);
            const Trial seen = trial(scene, *geometry, *sampler);
            if (seen.lit < SHOWN || seen.view <= best) continue;
            best = seen.view;
            chosen.listed = text;
        }
    }
    scene.camera = outside;
    if (chosen.listed.empty()) return;
    scene_choose_camera(scene, chosen);
    scene_camera_moved(scene);
    scene.notes.push_back(name + ": has no camera and is black from outside, so the view is from "
                                 "inside; --eye and --target choose another");
}
