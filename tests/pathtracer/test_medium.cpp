// SPDX-License-Identifier: Apache-2.0
// The medium: walks against integrals in closed form, the phase function, and pictures of fog that
// can be known without rendering.
//
// Seeds are fixed. Bounds are five standard deviations wide: chance passes one of them less than
// once in a million.
#include <cmath>
#include <vector>

#include "check.h"
#include "integrator.h"
#include "medium.h"
#include "scene_builder.h"
#include "scenes.h"

namespace {

constexpr int PIXELS = 16; // of pictures, each side

// The mean of many values, and its standard deviation.
struct Mean {
    double sum = 0, squares = 0;
    int count = 0;
    void add(double value) {
        sum += value;
        squares += value * value;
        ++count;
    }
    double mean() const { return sum / count; }
    double error() const {
        return std::sqrt(std::max(squares / count - mean() * mean(), 0.0) / count);
    }
};

void check_mean(const Mean &found, double expected, const char *what) {
    CHECK(std::abs(found.mean() - expected) <= 5 * found.error() + 1e-5 * expected,
          "%s: %g +- %g, should be %g", what, found.mean(), found.error(), expected);
}

float ramp(Vec3 p) {
    return 0.3f + 0.2f * p.x + 0.1f * p.y;
}

// A density that rises linearly is interpolated exactly, but for half a cell at each side.
Medium ramp_medium() {
    return medium_create({-1, -1, -1}, {3, 1, 1}, {40, 20, 12}, {1, 1, 1}, 0, ramp);
}

// The integral of the density along a ray, by the midpoint rule.
double optical_depth(const Medium &m, const Ray &ray, double end) {
    const int steps = 20000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const auto t = static_cast<float>(end * (i + 0.5) / steps);
        const Vec3 p = ray.origin + t * ray.direction;
        const bool inside = p.x > m.low.x && p.x < m.high.x && p.y > m.low.y && p.y < m.high.y &&
                            p.z > m.low.z && p.z < m.high.z;
        if (inside) sum += static_cast<double>(medium_density(m, p)) * end / steps;
    }
    return sum;
}

const Ray RAYS[] = {
    {{-2, 0, 0}, {1, 0, 0}},                    // along an axis, from outside
    {{4, 0.3f, -0.2f}, {-1, 0, 0}},             // back
    {{0.1f, 0.2f, 0.3f}, {0, -1, 0}},           // from inside
    {{-2, -1.1f, 0.4f}, {0.8f, 0.48f, -0.36f}}, // across
    {{2.9f, 0.9f, 0.9f}, {-0.6f, -0.64f, -0.48f}},
};

void test_walks_against_integrals(const char *sampler_name) {
    const Medium medium = ramp_medium();
    const SamplerPointer sampler = sampler_named(sampler_name);
    for (const Ray &ray : RAYS)
        for (const float end : {1.5f, 2.6f, 50.0f}) {
            const double expected = std::exp(-optical_depth(medium, ray, static_cast<double>(end)));
            Mean passed, flown;
            for (uint32_t i = 0; i < 40000; ++i) {
                const auto walk = [&](uint32_t k) {
                    return with_path(*sampler, static_cast<int32_t>(i % 200),
                                     static_cast<int32_t>(i / 200), 0,
                                     [k](const auto &path) { return path.ray(1).rng(k); });
                };
                bn::Rng numbers = walk(0);
                const float share = medium_transmittance(medium, ray, end, numbers);
                CHECK(share >= 0 && share <= 1, "a share of %g", static_cast<double>(share));
                passed.add(static_cast<double>(share));
                numbers = walk(1);
                const float distance = medium_free_flight(medium, ray, end, numbers);
                CHECK(distance >= 0 && (distance <= end || std::isinf(distance)), "flew %g of %g",
                      static_cast<double>(distance), static_cast<double>(end));
                flown.add(distance <= end ? 0 : 1);
            }
            check_mean(passed, expected, "transmittance");
            check_mean(flown, expected, "free flight");
        }
}

// A ray that misses the box, or ends before it, meets nothing and draws nothing.
void test_rays_that_miss() {
    const Medium medium = ramp_medium();
    const bn::Sampler sampler;
    const Ray misses[] = {{{-2, 1.5f, 0}, {1, 0, 0}},
                          {{-2, 0, 0}, {-1, 0, 0}},
                          {{-2, 0, 0}, {0, 1, 0}},
                          {{5, 5, 5}, {0.6f, 0, 0.8f}}};
    bn::Rng numbers = bn::Path(sampler, 1, 2, 3).ray(0).rng(0), fresh = numbers;
    for (const Ray &ray : misses) {
        CHECK(std::isinf(medium_free_flight(medium, ray, 100, numbers)), "met something");
        CHECK(medium_transmittance(medium, ray, 100, numbers) == 1, "lost light");
    }
    CHECK(medium_transmittance(medium, RAYS[0], 0.9f, numbers) == 1, "too early");
    CHECK(numbers.next_1d() == fresh.next_1d(), "numbers were drawn");
}

// No density is outside the range of its block: that would be light from nothing.
void test_ranges() {
    const Scene fog = scene_entries()[7].build();
    CHECK(fog.medium != nullptr, "%s has no medium", scene_entries()[7].name);
    const Medium &m = *fog.medium;
    Random random{3};
    double loose = 0, mean = 0;
    for (int i = 0; i < 400000; ++i) {
        const float u[3] = {random(), random(), random()};
        const Vec3 size = m.high - m.low;
        const Vec3 p = m.low + Vec3{u[0] * size.x, u[1] * size.y, u[2] * size.z};
        size_t index = 0;
        for (int axis = 2; axis >= 0; --axis) {
            const int cell = static_cast<int>(u[axis] * static_cast<float>(m.size[axis]));
            index = index * static_cast<size_t>(m.blocks[axis]) +
                    static_cast<size_t>(cell / Medium::BLOCK);
        }
        const Medium::Range range = m.ranges[index];
        const float density = medium_density(m, p), rounding = 1e-5f * range.most;
        CHECK(density >= range.least - rounding && density <= range.most + rounding,
              "%g, not from %g to %g", static_cast<double>(density),
              static_cast<double>(range.least), static_cast<double>(range.most));
        loose += static_cast<double>(range.most - range.least) / 400000;
        mean += static_cast<double>(density) / 400000;
    }
    CHECK(loose < 2 * mean, "the ranges are as wide as %g, the mean is %g", loose, mean);
}

// The phase function is a density, samples follow it, and its mean cosine is the anisotropy.
void test_phase() {
    Random random{11};
    for (const float g : {-0.7f, 0.0f, 0.0005f, 0.3f, 0.9f}) {
        Material m;
        m.kind = Material::PHASE;
        m.albedo = {0.9f, 0.8f, 0.7f};
        m.anisotropy = g;
        constexpr int BINS = 16, SAMPLES = 64000;
        double total = 0, expected[BINS] = {};
        const int steps = 64000;
        for (int i = 0; i < steps; ++i) {
            const double cosine = 2 * (i + 0.5) / steps - 1;
            const double share =
                4 * static_cast<double>(PI) / steps *
                static_cast<double>(phase_pdf(g, {0, 0, static_cast<float>(cosine)}));
            expected[i * BINS / steps] += share;
            total += share;
        }
        CHECK(std::abs(total - 1) < 1e-3, "anisotropy %g: %g in all", static_cast<double>(g),
              total);
        int found[BINS] = {};
        double mean = 0, sideways = 0;
        for (int i = 0; i < SAMPLES; ++i) {
            const MaterialSample s =
                material_sample(m, true, {0, 0, 1}, {random(), random()}, random());
            CHECK(std::abs(length(s.wi) - 1) < 1e-4f, "length %g",
                  static_cast<double>(length(s.wi)));
            CHECK(
                std::abs(s.pdf / material_value(m, true, {0, 0, 1}, s.wi).pdf - 1) < 1e-4f &&
                    std::abs(s.weight.y * s.pdf / material_value(m, true, {0, 0, 1}, s.wi).eval.y -
                             1) < 1e-3f,
                "anisotropy %g: weights do not agree", static_cast<double>(g));
            ++found[std::min(static_cast<int>(0.5f * (s.wi.z + 1) * BINS), BINS - 1)];
            mean -= static_cast<double>(s.wi.z) / SAMPLES; // wo is +z, light goes on along -z
            sideways += static_cast<double>(s.wi.x + s.wi.y) / SAMPLES;
        }
        double chi_square = 0;
        int degrees = -1;
        for (int bin = 0; bin < BINS; ++bin) {
            const double e = expected[bin] / total * SAMPLES;
            if (e < 5) continue;
            chi_square += (found[bin] - e) * (found[bin] - e) / e;
            ++degrees;
        }
        CHECK(chi_square_deviations(chi_square, degrees) < 4.8,
              "anisotropy %g: chi-square %g of %d", static_cast<double>(g), chi_square, degrees);
        CHECK(std::abs(mean - static_cast<double>(g)) < 5.0 / std::sqrt(SAMPLES) &&
                  std::abs(sideways) < 7.0 / std::sqrt(SAMPLES),
              "anisotropy %g: mean cosine %g, sideways %g", static_cast<double>(g), mean, sideways);
    }
}

// ---- Pictures

Scene fog_alone(Medium medium, float sky) {
    Scene scene;
    scene.camera = camera_look_at({1, 0, 6}, {1, 0, 0}, {0, 1, 0}, 0.05f);
    scene.medium = std::make_shared<Medium>(std::move(medium));
    if (sky > 0) scene.environment = even_environment(sky);
    return scene;
}

struct Pixels {
    Mean mean;
    std::vector<Vec3> radiance;
    std::vector<PathSample> samples;
};

Pixels pixels_of(Scene &scene, uint32_t spp, uint32_t max_depth, const char *name = "white") {
    camera_fit(scene.camera, PIXELS, PIXELS);
    const GeometryPointer geometry = geometry_build(scene);
    const SamplerPointer sampler = sampler_named(name);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), max_depth};
    PathCounters counters;
    Pixels result;
    for (int i = 0; i < PIXELS * PIXELS; ++i)
        for (uint32_t index = 0; index < spp; ++index) {
            const PathSample s = trace_path(integrator, i % PIXELS, i / PIXELS, index, counters);
            CHECK(is_finite(s.radiance) && s.radiance.x >= 0, "a sample is %g",
                  static_cast<double>(s.radiance.x));
            result.mean.add(static_cast<double>(s.radiance.x));
            result.radiance.push_back(s.radiance);
            result.samples.push_back(s);
        }
    return result;
}

// Fog that loses nothing under an even sky cannot be told from it; nor can a white ball in it.
void test_furnace() {
    for (const float g : {0.0f, 0.8f, -0.5f})
        for (const bool ball : {false, true}) {
            Medium medium = medium_create({-1, -1, -1}, {3, 1, 1}, {24, 12, 9}, {1, 1, 1}, g,
                                          [](Vec3 p) { return 1.5f + std::sin(3 * p.x + p.y); });
            Scene scene = fog_alone(std::move(medium), 1);
            if (ball) add_sphere(scene, add_diffuse(scene, {1, 1, 1}), {1, 0, 0}, 0.3f);
            scene_finish(scene);
            check_mean(pixels_of(scene, 48, 1000).mean, 1, ball ? "a ball in fog" : "fog");
        }
}

// Light scattered once: the same as at depth 1 where there is no surface, and less than all of it.
void test_single_scatter() {
    Scene scene = fog_alone(ramp_medium(), 1);
    scene_finish(scene);
    const Pixels all = pixels_of(scene, 16, 8), direct = pixels_of(scene, 16, 1);
    scene.single_scatter = true;
    const Pixels once = pixels_of(scene, 16, 8);
    double difference = 0;
    for (size_t i = 0; i < once.radiance.size(); ++i)
        difference += static_cast<double>(length(once.radiance[i] - direct.radiance[i]));
    CHECK(difference == 0, "single scattering is off by %g", difference);
    CHECK(once.mean.mean() < all.mean.mean() - 5 * all.mean.error(), "%g of %g", once.mean.mean(),
          all.mean.mean());
}

// Thin fog before a small lamp, seen across its beam: the integral of single scattering.
void test_beam_of_a_lamp() {
    const float density = 0.02f;
    Medium medium = medium_create({-1, -1, -1}, {3, 1, 1}, {8, 8, 8}, {1, 1, 1}, 0,
                                  [=](Vec3) { return density; });
    Scene scene = fog_alone(std::move(medium), 0);
    const float side = 0.02f, radiance = 1e5f;
    const Vec3 lamp = {1, 4, 0};
    add_light_towards(scene, add_diffuse(scene, {0, 0, 0}), {radiance, radiance, radiance}, lamp,
                      {1, 0, 0}, side, side);
    scene_finish(scene);
    scene.camera = camera_look_at({1, 0, 6}, {1, 0, 0}, {0, 1, 0}, 0.002f);
    double expected = 0;
    const int steps = 4000;
    for (int i = 0; i < steps; ++i) {
        const double z = -1 + 2 * (i + 0.5) / steps, sigma = static_cast<double>(density);
        const double distance = std::sqrt(16 + z * z), cosine = 4 / distance;
        const double in_fog = distance / 4; // the lamp is three above the box, which is one high
        const double lit = static_cast<double>(radiance) * static_cast<double>(side) *
                           static_cast<double>(side) * cosine / (distance * distance);
        expected += std::exp(-sigma * (1 - z + in_fog)) * sigma * lit /
                    (4 * static_cast<double>(PI)) * 2 / steps;
    }
    for (const char *sampler : {"white", "blue", "sobol"})
        check_mean(pixels_of(scene, 400, 1, sampler).mean, expected, sampler);
}

// Layers for denoisers show what is behind fog, as if there were none.
void test_layers() {
    Scene scene = scene_entries()[7].build();
    scene_finish(scene);
    const Pixels foggy = pixels_of(scene, 2, 3, "blue");
    scene.medium = nullptr;
    const Pixels clear = pixels_of(scene, 2, 3, "blue");
    for (size_t i = 0; i < clear.samples.size(); ++i) {
        const PathSample &a = foggy.samples[i], &b = clear.samples[i];
        CHECK(a.hit == b.hit && !(a.depth < b.depth) && !(a.depth > b.depth) &&
                  length(a.albedo - b.albedo) == 0 && length(a.normal - b.normal) == 0,
              "sample %zu differs", i);
    }
}

} // namespace

int main() {
    geometry_thread_begin();
    test_walks_against_integrals("white");
    test_walks_against_integrals("blue");
    test_rays_that_miss();
    test_ranges();
    test_phase();
    test_furnace();
    test_single_scatter();
    test_beam_of_a_lamp();
    test_layers();
    return 0;
}
