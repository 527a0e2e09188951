// SPDX-License-Identifier: Apache-2.0
// A unidirectional path tracer (Kajiya, "The Rendering Equation", 1986) with next event estimation. The
// power heuristic combines light sampling and BSDF sampling (Veach and Guibas, "Optimally Combining
// Sampling Techniques for Monte Carlo Rendering", 1995). Paths end by Russian roulette or after
// max_depth bounces. The pixel filter is a box, because splatting would correlate neighbours and
// destroy the blue noise.
#include "integrator.h"

#include <array>
#include <limits>
#include <optional>

namespace {

// The first bounces decide most of a pixel: Russian roulette there would add more noise than it saves time.
constexpr uint32_t FIRST_ROULETTE_BOUNCE = 3;

struct Path {
    PathCounters *counters;
    // The first pair chose the ray, the second chooses a light where the ray ends.
    std::array<float, 4> u;
    Ray ray;
    Vec3 throughput = {1, 1, 1};
    Vec3 radiance = {0, 0, 0};
    // The density per steradian with which the ray was chosen, and the number of light samples that
    // compete with it: none after the camera or a mirror.
    float scatter_pdf = 1, light_samples = 0;
    Receiver from = {}; // where the ray was scattered: what the light samples were chosen for
    bool seen_by_camera = true; // directly, or through mirrors and smooth glass
};

bool has_lens(const Scene &scene) {
    return scene.camera.lens_radius > 0;
}

// Whether the first light is not ray 0's: a lens has taken its pair, or it is split.
bool first_light_apart(const Scene &scene) {
    return has_lens(scene) || scene.light_samples > 1;
}

// The numbers of a ray. The second pair is drawn only if it serves a light or the lens.
template <typename RayNumbers>
inline std::array<float, 4> draw(const Integrator &integrator, uint32_t ray,
                                 const RayNumbers &numbers) {
    const Scene &scene = *integrator.scene;
    const bool light = !scene.lights.empty() && ray < integrator.max_depth;
    if (ray > 0 ? light : has_lens(scene) || (light && !first_light_apart(scene)))
        return numbers.draw();
    const auto [u, v] = numbers.draw_direction();
    return {u, v, 0, 0};
}

template <typename PathNumbers, typename RayNumbers>
Path camera_path(const Integrator &integrator, int x, int y, const PathNumbers &path_numbers,
                 const RayNumbers &numbers, PathCounters &counters) {
    const std::array<float, 4> u = draw(integrator, 0, numbers);
    const Vec2 pixel = {float(x) + u[0], float(y) + u[1]};
    Path path{&counters, u, camera_ray(integrator.scene->camera, pixel, pair23(u))};
    // It could take the second pair of ray 0, as a lens does, but then the first light would lose it.
    if (!integrator.scene->motions.empty()) path.ray.time = path_numbers.time_wavelength()[0];
    return path;
}

// ---- Light that a ray hits

// The density with which the path's light samples would have chosen its ray's direction.
float light_samples_pdf(const Scene &scene, const Path &path, int32_t light, float light_pdf) {
    if (!(path.light_samples > 0) || light < 0) return 0;
    return path.light_samples * light_pdf *
           light_probability(scene.light_tree, path.from, uint32_t(light));
}

// Adds light that the ray hits, weighted against light samples.
void add_found_light(Path &path, float other_pdf, Vec3 emitted) {
    path.radiance += power_heuristic(path.scatter_pdf, other_pdf) * (path.throughput * emitted);
}

inline void add_environment(const Scene &scene, Path &path) {
    if (!scene.environment) return;
    const Environment &environment = *scene.environment;
    const Vec3 direction = path.ray.direction;
    const float pdf = light_samples_pdf(scene, path, scene.environment_light,
                                        environment_pdf(environment, direction));
    add_found_light(path, pdf, environment_radiance(environment, direction));
}

inline void add_emission(const Scene &scene, Path &path, const Hit &hit) {
    const int32_t number = scene.surfaces[hit.point.triangle].light;
    if (number < 0) return;
    const Light &light = scene.lights[number];
    const float cosine = -dot(hit.normal, path.ray.direction);
    if (!(cosine > 0) && !light.both_sides) return;
    const float pdf =
        light_samples_pdf(scene, path, number, light_pdf(light, hit.distance, cosine));
    const Vec3 emitted = light.mapped ? emission_at(scene, hit.point) : light.radiance;
    add_found_light(path, pdf, emitted);
}

// ---- The surface that a ray hits, or the particle

struct Vertex {
    Vec3 point;
    float distance;  // from the ray's origin
    bool front;      // whether the ray came from the triangle's front
    Vec3 normal;     // geometric, on the side the ray came from
    glm::mat3 frame; // around the shading normal
    Vec3 shading_normal;
    Vec3 wo; // back along the ray, in the frame

    Receiver receiver(const Material &material) const {
        const bool both = material.kind == Material::DIELECTRIC || material.kind == Material::PHASE;
        return {point, shading_normal, !both};
    }
    Vec3 start(Vec3 wi) const { return offset_point(point, wi.z > 0 ? normal : -normal, distance); }
    // Whether `wi` is on one side of the triangle and of the shading normal. No other carries light.
    bool same_side(Vec3 wi, Vec3 direction) const {
        return (wi.z > 0) == (dot(normal, direction) > 0);
    }
};

inline Vertex vertex_at(const Scene &scene, const Ray &ray, const Hit &hit) {
    Vertex v;
    const Vec3 to_origin = -ray.direction;
    const ShadingNormals n = shading_normals(scene, hit.point, hit.normal, to_origin);
    v.front = n.front;
    v.normal = n.geometric;
    v.shading_normal = n.shading;
    v.point = ray.origin + hit.distance * ray.direction;
    v.distance = hit.distance;
    v.frame = frame_around(v.shading_normal);
    v.wo = to_origin * v.frame;
    return v;
}

// The material at a hit, stored in `textured` if it has maps.
inline const Material &material_of_hit(const Scene &scene, const Hit &hit,
                                       std::optional<Material> &textured) {
    const Material &base = material_of(scene, hit.point.triangle);
    if (base.maps < 0) return base;
    textured = material_at(scene, base, hit.point);
    return *textured;
}

// How far the path's ray flies to a particle before `end`, or infinity.
template <typename RayNumbers>
float free_flight(const Medium &medium, const Path &path, const RayNumbers &numbers, float end) {
    bn::LoopSampler walk = numbers.draw_loop(0);
    return medium_free_flight(medium, path.ray, end, walk);
}

// A particle is a vertex whose normal points back along the ray.
inline Vertex vertex_in_medium(const Ray &ray, float distance) {
    Vertex v{};
    v.point = ray.origin + distance * ray.direction;
    v.distance = distance;
    v.front = true;
    v.normal = v.shading_normal = -ray.direction;
    v.frame = frame_around(v.normal);
    v.wo = {0, 0, 1};
    return v;
}

// ---- Next event estimation

// The sampled point, moved off the light to the side that emits towards the surface.
inline Vec3 shadow_ray_end(const Light &light, const LightSample &sample) {
    if (!(light.area > 0)) return sample.point;
    const bool leaves_front = dot(light.normal, sample.direction) < 0;
    return offset_point(sample.point, leaves_front ? light.normal : -light.normal, 0);
}

// Adds the contribution of light sample k of `count`, chosen by u.
template <typename RayNumbers>
void add_light_sample(const Integrator &integrator, Path &path, const Vertex &v,
                      const Material &material, const RayNumbers &numbers, Vec2 u, uint32_t count,
                      uint32_t k) {
    const Scene &scene = *integrator.scene;
    const LightChoice choice = light_choose(scene.light_tree, v.receiver(material), u.x);
    if (choice.light < 0) return;
    const Light &light = scene.lights[choice.light];
    const LightSample sample = light_sample(light, v.point, u);
    if (!(sample.pdf > 0)) return;
    const Vec3 wi = sample.direction * v.frame;
    const auto [scattered, own_pdf] = material_value(material, v.front, v.wo, wi);
    if (!(max_component(scattered) > 0) || !v.same_side(wi, sample.direction)) return;
    ++path.counters->rays;
    const Ray shadow = {v.start(wi), sample.direction, path.ray.time};
    const Vec3 end = shadow_ray_end(light, sample);
    if (occluded(*integrator.geometry, shadow.origin, end, shadow.time)) return;
    float passed = 1;
    if (scene.medium) {
        bn::LoopSampler walk = numbers.draw_loop(k + 1);
        passed = medium_transmittance(*scene.medium, shadow, length(end - shadow.origin), walk);
    }
    const float pdf = float(count) * choice.probability * sample.pdf;
    const float weight = light_has_extent(light) ? power_heuristic(pdf, own_pdf) : 1;
    const Vec3 emitted = light.mapped
                             ? emission_at(scene, {light.triangle, sample.place.x, sample.place.y})
                             : sample.radiance;
    path.radiance += (passed * weight / pdf) * (path.throughput * scattered * emitted);
}

// Returns how many.
template <typename PathNumbers, typename RayNumbers>
uint32_t add_light_samples(const Integrator &integrator, Path &path, const Vertex &v,
                           const Material &material, uint32_t bounce,
                           const PathNumbers &path_numbers, const RayNumbers &numbers) {
    const Scene &scene = *integrator.scene;
    if (material_is_smooth(material) || scene.lights.empty()) return 0;
    const uint32_t count = bounce == 0 ? scene.light_samples : 1;
    for (uint32_t k = 0; k < count; ++k) {
        Vec2 u = pair23(path.u);
        if (bounce == 0 && first_light_apart(scene)) {
            const auto [s, t] = path_numbers.first_light(count, k);
            u = {s, t};
        }
        add_light_sample(integrator, path, v, material, numbers, u, count, k);
    }
    return count;
}

// ---- The next ray

// Continues the path in a direction sampled from the material. Returns false if the path ends.
template <typename RayNumbers>
bool scatter(const Integrator &integrator, Path &path, const Vertex &v, const Material &material,
             uint32_t bounce, RayNumbers &numbers) {
    const bool roulette = bounce >= FIRST_ROULETTE_BOUNCE;
    float lobe = 0, fate = 0;
    if (roulette || material_reads_lobe(material)) {
        lobe = numbers.next_1d();
        fate = numbers.next_1d();
    }
    path.u = draw(integrator, bounce + 1, numbers);
    const MaterialSample sample = material_sample(material, v.front, v.wo, pair01(path.u), lobe);
    if (!(sample.pdf > 0)) return false;
    const Vec3 direction = v.frame * sample.wi;
    if (!v.same_side(sample.wi, direction)) return false;
    path.throughput *= sample.weight;
    if (roulette) {
        // The probability is the share of light that is kept, so survivors keep their throughput.
        const float survival = std::min(max_component(sample.weight), 1.0f);
        if (fate >= survival) return false;
        path.throughput = (1 / survival) * path.throughput;
    }
    path.ray = {v.start(sample.wi), direction, path.ray.time};
    path.scatter_pdf = sample.pdf;
    path.from = v.receiver(material);
    path.seen_by_camera = path.seen_by_camera && material_is_smooth(material);
    return true;
}

template <typename PathNumbers>
PathSample trace(const Integrator &integrator, int x, int y, const PathNumbers &path_numbers,
                 PathCounters &counters) {
    const Scene &scene = *integrator.scene;
    const Camera &camera = scene.camera;
    auto numbers = path_numbers.ray(0);
    Path path = camera_path(integrator, x, y, path_numbers, numbers, counters);
    PathSample result{};
    for (uint32_t bounce = 0;; ++bounce) {
        Hit hit;
        ++counters.rays;
        const bool met = intersect(*integrator.geometry, path.ray, path.seen_by_camera, hit);
        const float infinite = std::numeric_limits<float>::infinity();
        const float flight =
            scene.medium ? free_flight(*scene.medium, path, numbers, met ? hit.distance : infinite)
                         : infinite;
        const bool in_medium = flight < infinite;
        std::optional<Material> textured;
        const Material *material = nullptr;
        Vertex vertex;
        if (met && (bounce == 0 || !in_medium)) {
            material = &material_of_hit(scene, hit, textured);
            vertex = vertex_at(scene, path.ray, hit);
        }
        if (bounce == 0 && met) {
            // What lies behind fog, too: it has no noise, and denoisers want none.
            result.hit = true;
            result.albedo = material_albedo(*material);
            result.normal = vertex.shading_normal;
            result.depth = dot(vertex.point - camera.position, camera.forward);
        }
        if (in_medium) {
            material = &scene.medium->material;
            vertex = vertex_in_medium(path.ray, flight);
        } else if (met) {
            add_emission(scene, path, hit);
        } else {
            add_environment(scene, path);
        }
        if (!(met || in_medium)) break;
        if (bounce == integrator.max_depth) {
            counters.cut_off += double(luminance(path.throughput));
            break;
        }
        if (!(vertex.wo.z > 0)) break;
        const uint32_t count =
            add_light_samples(integrator, path, vertex, *material, bounce, path_numbers, numbers);
        numbers = path_numbers.ray(bounce + 1);
        if (!scatter(integrator, path, vertex, *material, bounce, numbers)) break;
        path.light_samples = float(count); // 0 after a mirror
    }
    result.radiance = path.radiance;
    return result;
}

} // namespace

PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters) {
    ++counters.paths;
    return with_path(*integrator.sampler, x, y, index, [&](const auto &path_numbers) {
        return trace(integrator, x, y, path_numbers, counters);
    });
}
