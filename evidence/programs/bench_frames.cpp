// SPDX-License-Identifier: Apache-2.0
// Frames of one sample per pixel from a moving camera, as a real-time renderer has them, for docs/realtime.md. Surfaces count as
// diffuse; a shadow ray leaves the first one, and another the one that is met by one bounce.
//
//     bench_frames SCENE WIDTH HEIGHT PHASE SEED DRAWS PART GIVEN SAMPLES FIRST STEP
//
// The camera pans for PHASE frames, orbits for PHASE frames, and then stands still for PHASE frames. Frames FIRST, FIRST + STEP ...
// go to standard output, float32[frames][HEIGHT][WIDTH][13]: radiance (NaN where PART leaves a pixel out), albedo, normal, the
// surface's place on the screen of the frame before (x, y), its distance, and its distance then. Pixels that see nothing have
// distance 0. All rays of a frame go through the same place of their pixels, another in each frame, as with temporal
// anti-aliasing. A pixel is the mean of SAMPLES.
//
// DRAWS: white, sobol, blue, or a file of slices: uint32 depth, height, width, float32[depth][height][width][2].
// PART:  full, checkerboard, columns, half or quarter; of each n = 1, 2, 2, 4 or 16 pixels one is drawn in a frame, in turn.
// GIVEN: what the sampler gets in frame t: screen: x, y and index t / n. frame: x, y and index t. small: x, y of the smaller
//        picture, index t / n and key t % n. key: x, y, index 0 and key t.
#include <bn/bn.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "files.h"
#include "intersect.h"
#include "light.h"
#include "scene.h"

namespace {

// ---- The numbers of a sample

struct Slices {
    uint32_t size[3]; // depth, height, width
    std::vector<Vec2> pairs;
};

Slices slices_read(const char *path) {
    Slices s = {};
    FILE *file = std::fopen(path, "rb");
    bool good = file != nullptr && std::fread(s.size, sizeof s.size, 1, file) == 1;
    for (const uint32_t side : s.size) good = good && side >= 1 && side <= 4096;
    if (good) {
        s.pairs.resize(size_t{s.size[0]} * s.size[1] * s.size[2]);
        good = std::fread(s.pairs.data(), sizeof(Vec2), s.pairs.size(), file) == s.pairs.size();
    }
    if (file != nullptr) std::fclose(file);
    if (!good) throw Error(std::string(path) + " is not a file of slices");
    return s;
}

enum Decision : uint32_t { PLACE, LIGHT, BOUNCE, BOUNCE_LIGHT };

struct Numbers {
    const bn::Sampler *sampler;
    const Slices *slices; // null: the sampler draws
    uint32_t x, y, index, key;

    Vec2 operator()(Decision decision) const {
        if (slices == nullptr) {
            const bn::PathSampler path(*sampler, static_cast<int32_t>(x), static_cast<int32_t>(y),
                                       index, key);
            const bn::RaySampler ray = path.ray(decision / 2);
            const auto u = decision % 2 == 0 ? ray.draw_direction() : ray.draw_end_light();
            return {u[0], u[1]};
        }
        // Every decision, and every part of the screen, looks at a place of its own.
        const uint32_t moved = bn_domain_child(bn_domain_child(sampler->seed()[0], key), decision);
        const auto &[depth, height, width] = slices->size;
        return slices
            ->pairs[(size_t{index % depth} * height + (y + (moved >> 16)) % height) * width +
                    (x + (moved & 0xffff)) % width];
    }
};

// ---- Light

struct Tracer {
    Scene scene;
    GeometryPointer geometry;

    // The light of one lamp on a diffuse surface of albedo 1.
    Vec3 direct(Vec3 point, Vec3 normal, Vec2 u) const {
        const LightChoice c = light_choose(scene.light_tree, {point, normal, true}, u.x);
        if (c.light < 0) return {0, 0, 0};
        const Light &light = scene.lights[static_cast<size_t>(c.light)];
        const LightSample s = light_sample(light, point, u);
        const float cosine = s.pdf > 0 ? dot(normal, s.direction) : 0;
        if (!(cosine > 0) || occluded(*geometry, point, offset_point(s.point, light.normal, 0), 0))
            return {0, 0, 0};
        return (cosine / (PI * s.pdf * c.probability)) * s.radiance;
    }

    struct Surface {
        Vec3 point, start, normal, albedo, emission;
        float distance; // 0: none
    };

    Surface meet(const Ray &ray, bool seen_by_camera) const {
        Hit hit;
        if (!intersect(*geometry, ray, seen_by_camera, hit)) return {};
        const ::Surface &surface = scene.surfaces[hit.triangle];
        const bool front = dot(hit.normal, ray.direction) < 0;
        const Vec3 normal = front ? hit.normal : -hit.normal;
        const Vec3 point = ray.origin + hit.distance * ray.direction;
        const bool shines = surface.light >= 0 && front;
        return {point,
                offset_point(point, normal, hit.distance),
                normal,
                scene.materials[surface.material].albedo,
                shines ? scene.lights[static_cast<size_t>(surface.light)].radiance : Vec3{0, 0, 0},
                hit.distance};
    }

    Vec3 radiance(const Surface &first, const Numbers &numbers) const {
        if (!(first.distance > 0)) return {0, 0, 0};
        Vec3 light = direct(first.start, first.normal, numbers(LIGHT));
        const Vec3 away = frame_around(first.normal) * square_to_cosine_hemisphere(numbers(BOUNCE));
        const Surface next = meet({first.start, normalize(away)}, false);
        if (next.distance > 0)
            light += next.albedo * direct(next.start, next.normal, numbers(BOUNCE_LIGHT));
        return first.emission + first.albedo * light;
    }
};

// ---- Cameras and parts of the screen

Camera camera_at(const Camera &start, long frame, long phase, int width, int height) {
    // A degree in three frames; together about a quarter of the picture.
    const float per_frame = PI / 180 / 3;
    const long panned = std::min(frame, phase), orbited = std::clamp(frame - phase, 0L, phase);
    const auto turned = [](Vec3 v, float angle) {
        const float s = std::sin(angle), c = std::cos(angle);
        return Vec3{c * v.x + s * v.z, v.y, c * v.z - s * v.x};
    };
    const Vec3 view = start.target - start.position;
    const Vec3 target = start.position + turned(view, per_frame * static_cast<float>(panned));
    const Vec3 arm = start.position - target;
    Camera camera = camera_look_at(target + turned(arm, -per_frame * static_cast<float>(orbited)),
                                   target, {0, 1, 0}, start.tan_half_height);
    camera_fit(camera, width, height);
    return camera;
}

Vec2 on_screen(const Camera &camera, Vec3 point, float &distance) {
    const Vec3 to = point - camera.position;
    const float along = dot(to, camera.forward) * camera.pixel_size;
    distance = length(to);
    return {camera.half_width + dot(to, camera.right) / along,
            camera.half_height - dot(to, camera.up) / along};
}

float radical_inverse(uint32_t i, uint32_t base) {
    float value = 0, digit = 1;
    for (; i > 0; i /= base)
        value += static_cast<float>(i % base) * (digit /= static_cast<float>(base));
    return value;
}

enum Part { FULL, CHECKERBOARD, COLUMNS, HALF, QUARTER, PARTS };
const char *const part_names[PARTS] = {"full", "checkerboard", "columns", "half", "quarter"};
constexpr uint32_t part_frames[PARTS] = {1, 2, 2, 4, 16};

// The frame, of each part_frames, that draws this pixel.
uint32_t turn_of(Part part, uint32_t x, uint32_t y) {
    static const uint32_t corner[4] = {0, 2, 3, 1}; // opposite corners first
    if (part == CHECKERBOARD) return (x + y) % 2;
    if (part == COLUMNS) return x % 2;
    const uint32_t fine = corner[2 * (y % 2) + x % 2], coarse = corner[2 * (y / 2 % 2) + x / 2 % 2];
    return part == HALF ? fine : part == QUARTER ? 4 * coarse + fine : 0;
}

enum Given { SCREEN, FRAME, SMALL, KEY, PIXEL, GIVENS };
const char *const given_names[GIVENS] = {"screen", "frame", "small", "key", "pixel"};

Numbers numbers_of(Part part, Given given, uint32_t x, uint32_t y, uint32_t t) {
    const uint32_t n = part_frames[part];
    if (given == KEY) return {nullptr, nullptr, x, y, 0, t};
    if (given == FRAME) return {nullptr, nullptr, x, y, t, 0};
    if (given != SMALL) return {nullptr, nullptr, x, y, t / n, 0};
    const uint32_t side = part == QUARTER ? 4 : part == FULL ? 1 : 2;
    return {nullptr, nullptr, x / side, n == side ? y : y / side, t / n, t % n};
}

int index_of(const char *name, const char *const *names, int count) {
    const auto same = [&](const char *n) { return std::strcmp(n, name) == 0; };
    return static_cast<int>(std::find_if(names, names + count, same) - names);
}

} // namespace

int main(int argc, char **argv) try {
    long values[7] = {}; // WIDTH HEIGHT PHASE SEED SAMPLES FIRST STEP
    const int places[7] = {2, 3, 4, 5, 9, 10, 11};
    bool good = argc == 12;
    for (int i = 0; good && i < 7; ++i) {
        values[i] = std::atol(argv[places[i]]);
        good = values[i] >= (i == 3 || i == 5 ? 0 : 1) && values[i] <= 1 << 20;
    }
    const auto part = static_cast<Part>(good ? index_of(argv[7], part_names, PARTS) : PARTS);
    const auto given = static_cast<Given>(good ? index_of(argv[8], given_names, GIVENS) : GIVENS);
    if (part == PARTS || given == GIVENS || values[0] > 8192 || values[1] > 8192) {
        std::fprintf(stderr,
                     "usage: bench_frames SCENE WIDTH HEIGHT PHASE SEED white|sobol|blue|FILE "
                     "full|checkerboard|columns|half|quarter screen|frame|small|key|pixel SAMPLES "
                     "FIRST STEP\n");
        return 2;
    }
    const int width = static_cast<int>(values[0]), height = static_cast<int>(values[1]);
    const long phase = values[2], samples = values[4];
    const char *const kinds[3] = {"blue", "sobol", "white"};
    const int kind = index_of(argv[6], kinds, 3);
    const Slices slices = kind == 3 ? slices_read(argv[6]) : Slices{};
    const bn::Sampler sampler(kind == 3 ? bn::Type::white : static_cast<bn::Type>(kind),
                              static_cast<uint64_t>(values[3]));
    Tracer tracer = {scene_build(argv[1], SceneOptions{}), nullptr};
    tracer.geometry = geometry_build(tracer.scene);
    geometry_thread_begin();

    std::vector<float> picture;
    for (long frame = values[5]; frame < 3 * phase; frame += values[6]) {
        const Camera camera = camera_at(tracer.scene.camera, frame, phase, width, height);
        const Camera before =
            camera_at(tracer.scene.camera, std::max(frame - 1, 0L), phase, width, height);
        const auto t = static_cast<uint32_t>(frame);
        const Vec2 shared = {radical_inverse(t % 16 + 1, 2), radical_inverse(t % 16 + 1, 3)};
        picture.clear();
        for (uint32_t y = 0; y < static_cast<uint32_t>(height); ++y)
            for (uint32_t x = 0; x < static_cast<uint32_t>(width); ++x) {
                Numbers numbers = numbers_of(part, given, x, y, t);
                numbers.sampler = &sampler;
                numbers.slices = kind == 3 ? &slices : nullptr;
                const uint32_t first_index = numbers.index * static_cast<uint32_t>(samples);
                Vec3 sum = {0, 0, 0};
                Tracer::Surface first = {};
                Vec2 place = shared;
                for (long s = 0; s < samples; ++s) {
                    numbers.index = first_index + static_cast<uint32_t>(s);
                    if (given == PIXEL) place = numbers(PLACE);
                    const Vec2 at = {static_cast<float>(x) + place.x,
                                     static_cast<float>(y) + place.y};
                    first = tracer.meet(camera_ray(camera, at, {0, 0}), true);
                    const bool drawn = turn_of(part, x, y) == t % part_frames[part];
                    const float none = std::numeric_limits<float>::quiet_NaN();
                    sum += drawn ? tracer.radiance(first, numbers) : Vec3{none, none, none};
                }
                const Vec3 mean = (1 / static_cast<float>(samples)) * sum;
                float then = 0;
                Vec2 was = {0, 0};
                if (first.distance > 0) was = on_screen(before, first.point, then) - place;
                picture.insert(picture.end(),
                               {mean.x, mean.y, mean.z, first.albedo.x, first.albedo.y,
                                first.albedo.z, first.normal.x, first.normal.y, first.normal.z,
                                was.x, was.y, first.distance, then});
            }
        if (std::fwrite(picture.data(), sizeof(float), picture.size(), stdout) != picture.size())
            return 1;
    }
    return std::fflush(stdout) == 0 ? 0 : 1;
} catch (const Error &error) {
    std::fprintf(stderr, "bench_frames: %s\n", error.what());
    return 1;
}
