// SPDX-License-Identifier: Apache-2.0
// Ways to draw the light samples of a first surface, on the path tracer's scene `penumbra`: errors that docs/paths.md
// shows. Where the number of light samples varies, it is two to six. Either bright points take more (`points`), so that it
// is the same nearly all over a pixel, or a print of fine waves makes the throughput vary within a pixel, and paths of more
// throughput take more (`print`).
//
//     bench_splits points|print WAY SEED COUNT X Y WIDTH HEIGHT
//
// writes the radiance in a crop of a picture of 1280x960 pixels, from the lamps alone, without colours, to
// standard output: float32[n][HEIGHT][WIDTH], the means over 1, 4, 16 ... COUNT camera rays, COUNT a power of four.
#include <bn/bn.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "../pathtracer/check.h"
#include "distribution.h"
#include "error.h"
#include "intersect.h"
#include "light.h"
#include "scene.h"
#include "scene_camera.h"

namespace {

enum Way { FIXED, FROM, DOMAINS, GENERATOR, WHITE, WAYS };
const char *const way_names[WAYS] = {"fixed", "from", "domains", "generator", "white"};

constexpr int PICTURE_WIDTH = 1280, PICTURE_HEIGHT = 960;
constexpr unsigned FIXED_COUNT = 4;

struct SurfacePoint {
    Vec3 start, normal;
    bool lit; // not a lamp, and not missed

    // 1/2 to 3/2, by a print whose waves are about two pixels long.
    float print() const {
        return 1 + 0.25f * (std::sin(600 * start.x) + std::sin(500 * start.y + 550 * start.z));
    }
};

class Bench {
  public:
    Bench() : scene_(scene_build("penumbra", SceneOptions{})), geometry_(geometry_build(scene_)) {
        camera_fit(scene_.camera, PICTURE_WIDTH, PICTURE_HEIGHT);
        geometry_thread_begin();
    }

    SurfacePoint first_surface(float x, float y) const {
        const Ray ray = camera_ray(scene_.camera, {x, y}, {0.5f, 0.5f});
        Hit hit;
        if (!intersect(*geometry_, ray, true, hit) || scene_.surfaces[hit.triangle].light >= 0)
            return {{}, {}, false};
        const Vec3 normal = dot(hit.normal, ray.direction) < 0 ? hit.normal : -hit.normal;
        return {offset_point(ray.origin + hit.distance * ray.direction, normal, hit.distance),
                normal, true};
    }

    // The light that one number and one more choose: a lamp by its power, and a point on it.
    float light(const SurfacePoint &p, Vec2 u, bool shadows = true) const {
        const Choice c = distribution_choose(scene_.light_limits.data(), scene_.lights.size(), u.x);
        const LightSample s = light_sample(scene_.lights[c.index], p.start, {c.rest, u.y});
        const float cosine = s.pdf > 0 ? dot(p.normal, s.direction) : 0;
        if (!(cosine > 0)) return 0;
        if (shadows && occluded(*geometry_, p.start,
                                offset_point(s.point, scene_.lights[c.index].normal, 0), 0))
            return 0;
        return luminance(s.radiance) * cosine / (PI * s.pdf * c.probability);
    }

    // 0 to 1: the light that would reach the point from the middle of either lamp.
    float brightness(const SurfacePoint &p) const {
        float bright = 0;
        for (const float lamp : {0.25f, 0.75f}) bright += light(p, {lamp, 0.5f}, false);
        return std::clamp((bright - DIM) / (BRIGHT - DIM), 0.0f, 1.0f);
    }

  private:
    static constexpr float DIM = 0.6f, BRIGHT = 2.6f; // most of the picture lies between
    Scene scene_;
    GeometryPointer geometry_;
};

Vec2 pair(std::array<float, 2> u) {
    return {u[0], u[1]};
}

// The mean over the light samples of one camera ray; `taken` counts those of the pixel.
float sample(const Bench &bench, bool printed, Way way, const bn::Sampler &sampler, int x, int y,
             uint32_t index, Random &random, uint32_t &taken) {
    const bn::Path path(sampler, x, y, index);
    bn::Ray ray = path.ray(0);
    const Vec2 where = way == WHITE ? Vec2{random(), random()} : pair(ray.draw_where());
    const SurfacePoint p =
        bench.first_surface(static_cast<float>(x) + where.x, static_cast<float>(y) + where.y);
    if (!p.lit) return 0;
    const float throughput = printed ? p.print() : 1;
    const float share = printed ? throughput - 0.5f : bench.brightness(p);
    const unsigned count =
        way == FIXED || way == WHITE ? FIXED_COUNT : 2 + static_cast<unsigned>(4.99f * share);
    const bn::Split split = way == FIXED ? ray.next_split(count) : ray.next_split_from(taken);
    float sum = 0;
    for (unsigned k = 0; k < count; ++k) {
        Vec2 u;
        if (way == FIXED || way == FROM)
            u = pair(split[k].ray(0).draw_where());
        else if (way == DOMAINS)
            u = pair(ray.keyed(k).draw_where());
        else
            u = {random(), random()};
        sum += bench.light(p, u);
    }
    taken += count;
    return throughput * sum / static_cast<float>(count);
}

// A number from the command line, or -1.
long number_of(const char *text, long most) {
    char *end = nullptr;
    const long n = std::strtol(text, &end, 10);
    return *text != 0 && *end == 0 && n >= 0 && n <= most ? n : -1;
}

} // namespace

int main(int argc, char **argv) try {
    long numbers[6] = {};
    const char *const *name =
        argc == 9 ? std::find_if(way_names, way_names + WAYS,
                                 [&](const char *n) { return std::strcmp(n, argv[2]) == 0; })
                  : way_names + WAYS;
    const bool printed = argc == 9 && std::strcmp(argv[1], "print") == 0;
    bool good = name != way_names + WAYS && (printed || std::strcmp(argv[1], "points") == 0);
    for (int i = 0; good && i < 6; ++i) {
        numbers[i] = number_of(argv[3 + i], 1 << 20);
        good = numbers[i] >= 0;
    }
    const auto [seed, spp, x0, y0, width, height] = numbers;
    if (!good || spp < 1 || width < 1 || height < 1 || x0 + width > PICTURE_WIDTH ||
        y0 + height > PICTURE_HEIGHT) {
        std::fprintf(stderr, "usage: bench_splits points|print fixed|from|domains|generator|white "
                             "SEED COUNT X Y WIDTH HEIGHT\n");
        return 2;
    }
    const auto way = static_cast<Way>(name - way_names);
    const Bench bench;
    const bn::Sampler sampler(static_cast<uint64_t>(seed));
    const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
    std::vector<float> means;
    std::vector<double> sums(pixels);
    std::vector<uint32_t> taken(pixels);
    std::vector<Random> random(pixels);
    for (size_t i = 0; i < pixels; ++i)
        random[i] = {static_cast<uint64_t>(seed) << 40 ^ static_cast<uint64_t>(i) << 8};
    for (long index = 0, shown = 1; index < spp; ++index) {
        for (size_t i = 0; i < pixels; ++i) {
            const int x = static_cast<int>(x0 + static_cast<long>(i) % width),
                      y = static_cast<int>(y0 + static_cast<long>(i) / width);
            sums[i] +=
                static_cast<double>(sample(bench, printed, way, sampler, x, y,
                                           static_cast<uint32_t>(index), random[i], taken[i]));
        }
        if (index + 1 == shown) {
            for (const double sum : sums)
                means.push_back(static_cast<float>(sum / static_cast<double>(shown)));
            shown *= 4;
        }
    }
    double branches = 0;
    for (const uint32_t n : taken) branches += n;
    std::fprintf(stderr, "%.3f light samples for each camera ray\n",
                 branches / static_cast<double>(pixels) / static_cast<double>(spp));
    return std::fwrite(means.data(), sizeof(float), means.size(), stdout) == means.size() &&
                   std::fflush(stdout) == 0
               ? 0
               : 1;
} catch (const Error &error) {
    std::fprintf(stderr, "bench_splits: %s\n", error.what());
    return 1;
}
