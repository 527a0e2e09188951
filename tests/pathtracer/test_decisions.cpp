// SPDX-License-Identifier: Apache-2.0
// Tests which number drives which decision of a path: no two decisions share a number, and each number
// is the one that sampler.h lists. With a sampler of known numbers, one number is changed, and results
// that do not depend on it must not change. Another test detects the bias that shared numbers cause.
#include <map>

#include "scenes.h"

namespace {

// A plug-in that returns independent numbers for each pixel, index, decision and dimension. `changed` replaces some of
// them in every pixel; `drawn` counts the draws of each decision.
struct KnownNumbers {
    std::map<std::pair<uint32_t, uint32_t>, float> changed; // by decision and dimension
    std::map<uint32_t, int> drawn;

    static void draw(const void *state, uint64_t, int32_t x, int32_t y, uint32_t index,
                     uint32_t decision, uint32_t dimensions, float *u) {
        auto *const own = const_cast<KnownNumbers *>(static_cast<const KnownNumbers *>(state));
        ++own->drawn[decision];
        for (uint32_t d = 0; d < dimensions; ++d) {
            uint64_t number = 0;
            for (const uint32_t part :
                 {static_cast<uint32_t>(x), static_cast<uint32_t>(y), index, decision, d})
                number = number * 1000003 + part;
            const auto found = own->changed.find({decision, d});
            u[d] = found != own->changed.end() ? found->second : Random{number}();
        }
    }
    Sampler sampler() {
        return {{}, Plugin{"known", 0, draw, nullptr, {this, [](void *) {}}, {}}};
    }
};

// The camera looks down at a floor, on which it is focused. A lamp hangs to one side. With `motion`,
// the floor sinks.
Scene floor_below_lamp(bool lens, bool motion) {
    Scene scene = floor_scene();
    if (lens) camera_set_lens(scene.camera, 0.2f, {0, 0, 0});
    if (motion) add_motion(scene, 0, [](Vec3 v) { return v - Vec3{0, 1, 0}; });
    add_panel(scene, add_diffuse(scene, {0, 0, 0}), {5, 5, 5}, {3, 2, 0}, {0, 0, 0}, 2, 2);
    scene_finish(scene);
    camera_fit(scene.camera, SIDE, SIDE);
    return scene;
}

// The largest relative changes in depth and radiance when one number is changed.
struct Change {
    float depth = 0, radiance = 0;
};

Change change_by(const Scene &scene, const Geometry &geometry, bool of_camera, uint32_t dimension) {
    KnownNumbers numbers;
    const Sampler sampler = numbers.sampler();
    const Integrator integrator{&scene, &geometry, &sampler, 1};
    const uint32_t decision = of_camera ? PluginPath::CAMERA : PluginPath::ray_decision(0);
    Change most;
    PathCounters counters;
    for (int pixel = 0; pixel < 64; ++pixel) {
        const int x = 8 + pixel % 8, y = 8 + pixel / 8;
        PathSample seen[2];
        for (int i = 0; i < 2; ++i) {
            numbers.changed = {{{decision, dimension}, i == 0 ? 0.1f : 0.8f}};
            seen[i] = trace_path(integrator, x, y, 0, counters);
        }
        const float depth = std::abs(seen[1].depth / seen[0].depth - 1);
        const float a = seen[0].radiance.x, b = seen[1].radiance.x;
        most.depth = std::max(most.depth, depth);
        most.radiance = std::max(most.radiance, std::abs(a - b) / std::max(a, b));
    }
    return most;
}

// A path draws each domain at most once, except for the camera's domain, which supplies the time and
// all samples of the first light.
void test_no_domain_is_drawn_twice() {
    for (const SceneEntry &entry : scene_entries()) {
        Scene scene = entry.build();
        scene_finish(scene);
        camera_fit(scene.camera, SIDE, SIDE);
        const GeometryPointer geometry = geometry_build(scene);
        KnownNumbers numbers;
        const Sampler sampler = numbers.sampler();
        const Integrator integrator{&scene, geometry.get(), &sampler, 20};
        const int of_camera = static_cast<int>(scene.light_samples) + !scene.motions.empty();
        PathCounters counters;
        size_t most = 0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            numbers.drawn.clear();
            trace_path(integrator, i % SIDE, i / SIDE, 3, counters);
            for (const auto &[decision, count] : numbers.drawn)
                CHECK(count <= (decision == PluginPath::CAMERA ? of_camera : 1),
                      "%s: domain %u is drawn %d times", entry.name, decision, count);
            most = std::max(most, numbers.drawn.size());
        }
        CHECK(most > 5, "%s: no path draws more than %zu domains", entry.name, most);
    }
}

// The parts of split samples are consecutive samples of one sequence, unless the plug-in splits in its own way.
void test_split_samples_are_one_sequence() {
    KnownNumbers numbers;
    const Sampler sampler = numbers.sampler();
    for (uint32_t i = 0; i < 12; ++i) {
        const PluginPath split(*sampler.plugin, -5, 9, i / 3), whole(*sampler.plugin, -5, 9, i);
        CHECK(split.first_light(3, i % 3) == whole.first_light(1, 0), "part %u", i);
    }
}

// A plane whose depth differs at every point.
constexpr float SLOPE_X = 0.4f, SLOPE_Y = -0.7f;

Scene slanted_plane(bool out_of_focus) {
    Scene scene;
    scene.camera = camera_look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.3f);
    if (out_of_focus) camera_set_lens(scene.camera, 0.2f, {0, 0, -1});
    const auto at = [&](float x, float y) { return Vec3{x, y, -5 + SLOPE_X * x + SLOPE_Y * y}; };
    add_quad(scene, add_diffuse(scene, {1, 1, 1}), at(-4, -4), at(4, -4), at(4, 4), at(-4, 4));
    scene_finish(scene);
    camera_fit(scene.camera, SIDE, SIDE);
    return scene;
}

// Tests which of ray 0's four numbers, and of the camera domain's four, change depth and radiance:
// + must, - must not, . may. Only time changes a floor's depth; pixel position and lens change a
// slanted plane's. Radiance shows the point on the lamp, because the lens does not move a point in
// focus. A moving floor is out of focus, so time and lens may also change its radiance.
void test_lens_light_and_time_use_separate_numbers() {
    const struct {
        const char *name;
        Scene scene;
        const char *depth, *radiance;
    } rows[] = {
        {"a floor", floor_below_lamp(false, false), "--------", "..++----"},
        {"a floor through a lens", floor_below_lamp(true, false), "--------", "..--++--"},
        {"a moving floor", floor_below_lamp(false, true), "------+-", "..++--.-"},
        {"a moving floor through a lens", floor_below_lamp(true, true), "------+-", "....++.-"},
        {"a slanted plane", slanted_plane(false), "++------", "........"},
        {"a slanted plane out of focus", slanted_plane(true), "++++----", "........"},
    };
    for (const auto &[name, scene, depth, radiance] : rows) {
        const GeometryPointer geometry = geometry_build(scene);
        for (uint32_t n = 0; n < 8; ++n) {
            const Change seen = change_by(scene, *geometry, n >= 4, n % 4);
            const auto check = [&, n](char follows, float by, const char *what) {
                CHECK(follows == '.' || (follows == '+' ? by > 3e-3f : by < 1e-3f),
                      "%s: number %u of the %s changes %s by %g", name, n % 4,
                      n < 4 ? "ray" : "camera", what, by);
            };
            check(depth[n], seen.depth, "depth");
            check(radiance[n], seen.radiance, "radiance");
        }
    }
}

// The first two numbers of ray 0 are the pixel position, also of draws from another pixel.
void test_pixel_position() {
    constexpr int DX = 3, DY = -2;
    const Scene scene = slanted_plane(false);
    const GeometryPointer geometry = geometry_build(scene);
    for (const SamplerEntry &entry : sampler_entries()) {
        const SamplerPointer sampler = sampler_create(entry.name, 7);
        const Integrator integrator{&scene, geometry.get(), sampler.get(), 0, DX, DY};
        PathCounters counters;
        for (int i = 0; i < 500; ++i) {
            const int x = i % SIDE, y = i / SIDE;
            const auto index = static_cast<uint32_t>(i % 5);
            const auto [u, v] = with_path(*sampler, x - DX, y - DY, index, [](const auto &path) {
                return path.ray(0).draw_direction();
            });
            const float along_x = (static_cast<float>(x) + u) / SIDE * 2 - 1;
            const float along_y = 1 - (static_cast<float>(y) + v) / SIDE * 2;
            const float expected = 5 / (1 + 0.3f * (SLOPE_X * along_x + SLOPE_Y * along_y));
            const float depth = trace_path(integrator, x, y, index, counters).depth;
            CHECK(std::abs(depth - expected) < 1e-4f, "%s, pixel %d,%d: depth %g, should be %g",
                  entry.name, x, y, depth, expected);
        }
    }
}

// Positions are distributed as the Gaussian is, from 1.5 pixels before the pixel's centre to 1.5 after it.
void test_gaussian_filter() {
    const auto share = [](double x) { return std::erf(x / std::sqrt(0.5)); };
    for (int i = 0; i < 1000; ++i) {
        const float u = float(i) / 1000, at = gaussian_position(u);
        const double found = 0.5 + 0.5 * share(at - 0.5) / share(1.5);
        CHECK(at >= -1.00001f && at < 2 && std::abs(found - u) < 1e-5, "position %g for %g", at, u);
    }
}

// ---- Means

// The view from inside nested boxes of tinted rough glass under a uniform sky. Lobes have different
// weights, and all light bounces many times.
Scene boxes_of_glass() {
    Scene scene;
    scene.camera = camera_look_at({0.1f, 0.05f, 0.15f}, {0, 0, -1}, {0, 1, 0}, 0.2f);
    const uint32_t glass = add_dielectric(scene, 1.8f, 0.5f, {0.7f, 0.7f, 0.7f});
    for (const float r : {0.4f, 0.6f, 0.8f, 1.0f})
        add_box(scene, glass, {0, 0, 0}, {r, 0, 0}, {0, r, 0}, {0, 0, r});
    scene.environment = even_environment();
    scene_finish(scene);
    camera_fit(scene.camera, SIDE, SIDE);
    return scene;
}

// The radiance along a ray, without Russian roulette and with independent random numbers.
double walked(const Scene &scene, const Geometry &geometry, Ray ray, Random &random) {
    Vec3 throughput = {1, 1, 1};
    Hit hit;
    while (intersect(geometry, ray, false, hit)) {
        const bool front = dot(hit.normal, ray.direction) < 0;
        const Vec3 normal = front ? hit.normal : -hit.normal;
        const glm::mat3 frame = frame_around(normal);
        const Vec2 u = {random(), random()};
        const MaterialSample sample = material_sample(material_of(scene, hit.point.triangle), front,
                                                      -ray.direction * frame, u, random());
        if (!(sample.pdf > 0)) return 0;
        throughput *= sample.weight;
        const Vec3 point = ray.origin + hit.distance * ray.direction;
        ray = {offset_point(point, sample.wi.z > 0 ? normal : -normal, hit.distance),
               frame * sample.wi};
    }
    return throughput.x;
}

// Russian roulette must not reuse the number that selects the lobe, or any other number on which the
// bounce depends: the survivors would all come from one lobe. Samplers whose samples are not independent
// deviate less than is allowed.
void test_russian_roulette_is_unbiased() {
    constexpr int SPP = 400;
    Scene scene = boxes_of_glass();
    const GeometryPointer geometry = geometry_build(scene);
    Random random{5};
    Mean expected;
    for (int i = 0; i < SPP * SIDE * SIDE; ++i) {
        const Vec2 point = {float(i % SIDE) + random(), float(i / SIDE % SIDE) + random()};
        expected.add(walked(scene, *geometry, camera_ray(scene.camera, point, {0, 0}), random));
    }
    for (const char *name : {"white", "sobol", "blue"}) {
        const Mean seen = render(scene, {SPP, 1000, name}).mean;
        const double deviation = std::hypot(seen.error(), expected.error());
        CHECK(deviation < 0.02 * expected.mean(), "%s: too noisy, %g", name, deviation);
        CHECK(std::abs(seen.mean() - expected.mean()) < 6 * deviation, "%s: %g, should be %g +- %g",
              name, seen.mean(), expected.mean(), deviation);
    }
}

} // namespace

int main() {
    test_pixel_position();
    test_gaussian_filter();
    test_lens_light_and_time_use_separate_numbers();
    test_no_domain_is_drawn_twice();
    test_split_samples_are_one_sequence();
    test_russian_roulette_is_unbiased();
    return 0;
}
