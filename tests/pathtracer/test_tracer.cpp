// SPDX-License-Identifier: Apache-2.0
// Whole pictures, small ones, of scenes that break tracers: scaled, far from the origin, with faces
// that are degenerate, double or needles, with lights that are tiny or edge-on, without any, from
// inside of glass. What can be known without rendering is compared with that.
//
// Pictures are made with fixed seeds. Bounds are at least five standard deviations of the estimate
// wide, which chance passes less than once in a million had the seeds been drawn anew.
#include <algorithm>
#include <vector>

#include "check.h"
#include "integrator.h"
#include "intersect.h"
#include "render.h"
#include "scene_builder.h"
#include "scenes.h"

namespace {

constexpr int SIZE = 24;

struct Settings {
    uint32_t spp = 16;
    uint32_t max_depth = 8;
    uint64_t seed = 0;
    const char *sampler = "sobol";
};

struct Picture {
    std::vector<float> rgb;
    double mean;
    double cut_off;
    uint64_t rays;
};

// Renders a finished scene; no picture may hold what is not a number or negative.
Picture picture(Scene &scene, const Settings &settings) {
    camera_fit(scene.camera, SIZE, SIZE);
    const SamplerPointer sampler = sampler_named(settings.sampler, settings.seed);
    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), settings.max_depth};
    RenderTotals totals;
    Film film = film_create(SIZE, SIZE, {0, 0, SIZE, SIZE});
    const std::sig_atomic_t never = 0;
    render_frame(
        integrator, {settings.spp}, film, totals, [](double, const RenderTotals &) {}, never);
    const Image image = film_image(film);
    CHECK(totals.counters.lost == 0, "%g samples were no numbers",
          static_cast<double>(totals.counters.lost));
    double sum = 0;
    for (const float v : image.rgb) {
        CHECK(std::isfinite(v) && v >= 0, "a pixel is %g", static_cast<double>(v));
        sum += static_cast<double>(v);
    }
    return {image.rgb, sum / static_cast<double>(image.rgb.size()),
            totals.counters.cut_off / (static_cast<double>(SIZE) * SIZE * settings.spp),
            totals.counters.rays};
}

void check_near(double value, double expected, double relative, const char *what) {
    CHECK(std::abs(value - expected) <= relative * std::abs(expected), "%s: %g, should be %g", what,
          value, expected);
}

// A floor of 8 x 8 under a camera that looks down on its middle.
Scene floor_scene(Vec3 albedo) {
    Scene scene;
    scene.camera = camera_look_at({0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.2f);
    const uint32_t floor = add_diffuse(scene, albedo);
    add_quad(scene, floor, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}, {-4, 0, -4});
    return scene;
}

// Broken faces change nothing: they are dropped, or too thin to be seen.
void test_broken_faces() {
    Scene clean = scene_entries()[0].build(); // cornell
    Scene broken = clean;
    const auto vertex = [&](Vec3 v) {
        broken.vertices.push_back(v);
        return static_cast<uint32_t>(broken.vertices.size() - 1);
    };
    const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
        broken.triangles.push_back({{a, b, c}});
        broken.surfaces.push_back({0, -1});
    };
    const uint32_t a = vertex({278, 200, 100}), b = vertex({300, 250, 120});
    const uint32_t middle = vertex({289, 225, 110}), again = vertex({278, 200, 100});
    triangle(a, a, a);
    triangle(a, b, b);
    triangle(a, again, b);
    triangle(a, b, middle);
    // Needles: across the picture, a hundred-thousandth of it wide, and thinner yet.
    triangle(vertex({0, 100, 10}), vertex({550, 100, 10}), vertex({550, 100.005f, 10}));
    triangle(vertex({0, 200, 10}), vertex({550, 200, 10}), vertex({550, 200.00002f, 10}));
    // Every face once more, and once more turned around.
    const size_t count = clean.triangles.size();
    for (size_t i = 0; i < count; ++i) {
        const Triangle t = clean.triangles[i];
        const Surface surface = clean.surfaces[i];
        if (surface.light >= 0) continue; // what lies in a lamp, before or behind it, is undecided
        broken.triangles.push_back(t);
        broken.surfaces.push_back(surface);
        broken.triangles.push_back({{t.vertices[0], t.vertices[2], t.vertices[1]}});
        broken.surfaces.push_back(surface);
    }
    // Normals of length zero, for all vertices, stand for the triangle's own.
    broken.normals.assign(broken.vertices.size(), {0, 0, 0});

    scene_finish(clean);
    scene_finish(broken);
    CHECK(broken.dropped_triangles >= 3, "%u dropped", broken.dropped_triangles);
    const Picture expected = picture(clean, {}), seen = picture(broken, {});
    check_near(seen.mean, expected.mean, 0.005, "broken faces");
}

void test_normals_that_are_none() {
    const float not_a_number = NAN;
    const Vec3 normals[] = {{0, 0, 0}, {not_a_number, 0, 0}, {1e-30f, 1e-30f, 0}, {0, -1, 0}};
    for (const Vec3 normal : normals) {
        Scene scene = floor_scene({0.5f, 0.5f, 0.5f});
        scene.normals.assign(4, normal);
        scene.environment = even_environment();
        scene_finish(scene);
        const Picture seen = picture(scene, {});
        CHECK(seen.mean > 0.1 && seen.mean < 0.6, "normal %g %g %g: %g", normal.x, normal.y,
              normal.z, seen.mean);
    }
    Scene scene = floor_scene({0.5f, 0.5f, 0.5f});
    scene.vertices[2].y = not_a_number;
    bool thrown = false;
    try {
        scene_finish(scene);
    } catch (const std::exception &) {
        thrown = true;
    }
    CHECK(thrown, "a vertex that is not a number was taken");
}

// Irradiance of a point from a parallelogram of radiance 1, by Lambert's formula.
double irradiance_from(const Light &light, Vec3 point, Vec3 normal) {
    const Vec3 a = light.corner - point;
    const Vec3 corners[4] = {a, a + light.edge_u, a + light.edge_u + light.edge_v,
                             a + light.edge_v};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const Vec3 p = normalize(corners[i]), q = normalize(corners[(i + 1) % 4]);
        const Vec3 axis = cross(p, q);
        const double sine = static_cast<double>(length(axis));
        sum += std::atan2(sine, static_cast<double>(dot(p, q))) / sine *
               static_cast<double>(dot(axis, normal));
    }
    return std::abs(sum) / 2;
}

// A lamp that shines to both sides lights a floor below it as Lambert says, whichever side that
// sees, small and large: light samples decide the one, scattered rays the other.
void test_lights_of_two_sides() {
    for (const bool turned : {false, true})
        for (const float side : {0.5f, 3.0f}) {
            Scene scene = floor_scene({0.8f, 0.8f, 0.8f});
            const float h = side / 2, x = turned ? -h : h;
            add_light(scene, add_diffuse(scene, {0, 0, 0}), {5, 5, 5}, {-x, 1, -h}, {x, 1, -h},
                      {x, 1, h});
            scene.lights[0].both_sides = true;
            scene.camera = camera_look_at({0, 0.9f, 2.5f}, {0.1f, 0, 0.2f}, {0, 1, 0}, 0.002f);
            scene_finish(scene);
            const double expected = 0.8 / static_cast<double>(PI) * 5 *
                                    irradiance_from(scene.lights[0], {0.1f, 0, 0.2f}, {0, 1, 0});
            double sum = 0, squares = 0;
            constexpr int SEEDS = 8;
            for (int seed = 0; seed < SEEDS; ++seed) {
                const double mean =
                    picture(scene, {64, 1, static_cast<uint64_t>(seed), "sobol"}).mean;
                sum += mean;
                squares += mean * mean;
            }
            const double mean = sum / SEEDS;
            const double deviation = std::sqrt((squares / SEEDS - mean * mean) / (SEEDS - 1));
            CHECK(6 * deviation < 0.001 * expected, "too noisy: %g of %g", deviation, expected);
            check_near(mean, expected, 0.001, turned ? "a lamp's back" : "a lamp's front");
        }
}

// White things of every material under an even sky cannot be told from it.
void test_white_furnace() {
    Scene scene;
    scene.camera = camera_look_at({0, 0.5f, 4}, {0, 0, 0}, {0, 1, 0}, 0.5f);
    const Vec3 white = {1, 1, 1};
    const uint32_t materials[] = {
        add_diffuse(scene, white),         add_conductor(scene, white, 0),
        add_conductor(scene, white, 0.4f), add_conductor(scene, white, 1),
        add_dielectric(scene, 1.5f, 0),    add_dielectric(scene, 1.5f, 0.4f),
        add_dielectric(scene, 1.5f, 1),    add_dielectric(scene, 1, 0.5f),
        add_dielectric(scene, 1.33f, 0.1f)};
    for (int i = 0; i < 9; ++i)
        add_sphere(scene, materials[i],
                   {static_cast<float>(i % 3 - 1) * 1.1f, static_cast<float>(i / 3 - 1) * 1.1f, 0},
                   0.5f);
    scene.environment = even_environment();
    scene_finish(scene);
    const Picture seen = picture(scene, {64, 200, 0, "sobol"});
    check_near(seen.mean, 1, 0.005, "white spheres under a white sky");
    for (size_t i = 0; i < seen.rgb.size(); ++i)
        CHECK(std::abs(seen.rgb[i] - 1) < 0.6f, "pixel %zu: %g", i / 3, seen.rgb[i]);
}

// What is carried is radiance over the squared index of refraction: inside glass all is as bright.
void test_camera_inside_glass() {
    for (const float roughness : {0.0f, 0.5f}) {
        Scene scene;
        scene.camera = camera_look_at({0.2f, 0.1f, 0.3f}, {1, 0, 0}, {0, 1, 0}, 0.5f);
        add_sphere(scene, add_dielectric(scene, 1.5f, roughness), {0, 0, 0}, 1);
        scene.environment = even_environment();
        scene_finish(scene);
        check_near(picture(scene, {64, 400, 0, "sobol"}).mean, 1, 0.01, "inside glass");
    }
}

// White walls all around: paths end at the greatest depth, and that all of them did is reported.
void test_closed_white_box() {
    Scene scene;
    scene.camera = camera_look_at({0, 0, 0}, {1, 0.3f, 0.2f}, {0, 1, 0}, 0.5f);
    const uint32_t white = add_diffuse(scene, {1, 1, 1});
    add_box(scene, white, {0, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    Scene lit = scene;
    scene_finish(scene);
    const Picture dark = picture(scene, {4, 50, 0, "white"});
    CHECK(dark.mean == 0, "%g", dark.mean);
    check_near(dark.cut_off, 1, 1e-3, "cut off");
    CHECK(dark.rays == 51u * 4 * SIZE * SIZE, "%llu rays",
          static_cast<unsigned long long>(dark.rays));
    // With a light inside, each further bounce adds the same again.
    add_light(lit, white, {0.1f, 0.1f, 0.1f}, {-0.2f, 0.5f, -0.2f}, {0.2f, 0.5f, -0.2f},
              {0.2f, 0.5f, 0.2f});
    scene_finish(lit);
    const double at_20 = picture(lit, {64, 20, 0, "sobol"}).mean;
    const double at_40 = picture(lit, {64, 40, 0, "sobol"}).mean;
    CHECK(at_40 > 1.8 * at_20 && at_40 < 2.3 * at_20, "%g and %g", at_20, at_40);
}

void test_no_light_and_no_scene() {
    Scene dark = floor_scene({0.5f, 0.5f, 0.5f});
    scene_finish(dark);
    CHECK(picture(dark, {}).mean == 0, "light from nowhere");
    Scene empty;
    empty.camera = camera_look_at({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.5f);
    scene_finish(empty);
    CHECK(picture(empty, {}).mean == 0, "light from nowhere");
    Scene sky;
    sky.camera = camera_look_at({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.5f);
    sky.environment = even_environment();
    scene_finish(sky);
    check_near(picture(sky, {}).mean, 1, 1e-5, "nothing but sky");
    Scene black_sky = floor_scene({0.5f, 0.5f, 0.5f});
    black_sky.environment = even_environment(0);
    scene_finish(black_sky);
    CHECK(picture(black_sky, {}).mean == 0, "light from a black sky");
}

// A floor in a room whose walls and ceiling shine sees the same light everywhere. Scattered rays and
// light samples find it about equally well, so a wrong weight between them shows, for every number
// of light samples. Nor does it matter whether the light is surfaces or a sky: half of one, as an
// even one is left to scattered rays.
void test_weights_of_light_samples() {
    const auto glowing_room = [](Scene &scene) {
        const uint32_t black = add_diffuse(scene, {0, 0, 0});
        const Vec3 one = {1, 1, 1};
        const Vec3 low[4] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
        const Vec3 up = {0, 1, 0};
        for (int i = 0; i < 4; ++i)
            add_light(scene, black, one, low[i], low[(i + 1) % 4], low[(i + 1) % 4] + up);
        add_light(scene, black, one, low[0] + up, low[1] + up, low[2] + up);
    };
    const auto half_sky = [](Scene &scene) {
        std::vector<Vec3> texels(16 * 8, {0, 0, 0});
        for (size_t i = 0; i < texels.size(); ++i)
            if (i % 16 < 8) texels[i] = {2, 2, 2};
        scene.environment = std::make_shared<Environment>(environment_create(16, 8, texels));
    };
    const auto check = [](Scene scene, double expected, const char *what) {
        scene_finish(scene);
        CHECK(!scene.lights.empty(), "%s: no light to sample", what);
        for (const uint32_t count : {0u, 1u, 2u, 8u}) {
            scene.light_samples = count;
            const double mean = picture(scene, {32, 1, count, "sobol"}).mean;
            CHECK(std::abs(mean - expected) < 0.01 * expected,
                  "%s, %u light samples: %g, should be %g", what, count, mean, expected);
        }
    };
    const Camera camera = camera_look_at({0, 0.9f, 0}, {0, 0, 0}, {0, 0, -1}, 0.3f);
    for (const bool metal : {false, true}) {
        Scene room;
        room.camera = camera;
        const uint32_t floor =
            metal ? add_conductor(room, {1, 1, 1}, 0.5f) : add_diffuse(room, {0.5f, 0.5f, 0.5f});
        add_quad(room, floor, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
        glowing_room(room);
        check(room, metal ? 1 : 0.5, metal ? "metal in a glowing room" : "a glowing room");
    }
    Scene outside = floor_scene({0.5f, 0.5f, 0.5f});
    half_sky(outside);
    check(outside, 0.5, "half a sky");
}

// All rays of one point of the picture meet in the plane that is sharp, and leave from all of the lens
// alike: the mean square along an axis of a disc is a quarter of its squared radius.
void test_lens() {
    Camera camera = camera_look_at({1, 2, 3}, {0, 0, -4}, {0, 1, 0}, 0.4f);
    camera_fit(camera, SIZE, SIZE);
    const Vec2 point = {3.3f, 17.9f};
    const Ray straight = camera_ray(camera, point, {0.5f, 0.5f});
    camera_set_lens(camera, 0.2f, {0.5f, 0, -2});
    const float distance = camera.focus_distance;
    CHECK(distance > 4 && distance < 7, "%g", distance);
    const Vec3 sharp =
        straight.origin + (distance / dot(straight.direction, camera.forward)) * straight.direction;
    Random random{1};
    constexpr int COUNT = 10000;
    float farthest = 0, right = 0, up = 0;
    for (int i = 0; i < COUNT; ++i) {
        const Ray ray = camera_ray(camera, point, {random(), random()});
        const Vec3 to_sharp = sharp - ray.origin;
        CHECK(length(cross(to_sharp, ray.direction)) < 1e-5f, "missed by %g",
              length(cross(to_sharp, ray.direction)));
        CHECK(std::abs(dot(ray.origin - camera.position, camera.forward)) < 1e-6f,
              "not on the lens");
        const Vec3 place = (1 / 0.2f) * (ray.origin - camera.position);
        farthest = std::max(farthest, 0.2f * length(place));
        right += dot(place, camera.right) * dot(place, camera.right) / COUNT;
        up += dot(place, camera.up) * dot(place, camera.up) / COUNT;
    }
    // Five deviations of such a mean
    CHECK(std::abs(right - 0.25f) < 0.0125f && std::abs(up - 0.25f) < 0.0125f,
          "mean squares of %g and %g", right, up);
    CHECK(farthest < 0.2001f && farthest > 0.19f, "lens of radius %g", farthest);
}

} // namespace

int main() {
    geometry_thread_begin();
    test_lens();
    test_no_light_and_no_scene();
    test_broken_faces();
    test_normals_that_are_none();
    test_lights_of_two_sides();
    test_closed_white_box();
    test_weights_of_light_samples();
    test_camera_inside_glass();
    test_white_furnace();
    return 0;
}
