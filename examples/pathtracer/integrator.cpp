// SPDX-License-Identifier: Apache-2.0
// A unidirectional path tracer (Kajiya, "The Rendering Equation", 1986) with next event estimation.
// Light is found both by choosing points on lights and by scattered rays that hit one; the power
// heuristic weighs the two (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte
// Carlo Rendering", 1995). Paths end by Russian roulette or after max_depth bounces, whichever is
// first; up to there the estimate is unbiased. Pixels are boxes, each sample counts for its own
// pixel only: splatting would tie neighbours together and spoil the blue noise.
#include "integrator.h"

#include <optional>

#include "distribution.h"

namespace {

// The first bounces decide most of a pixel; roulette there would cost more noise than time.
constexpr uint32_t FIRST_ROULETTE_BOUNCE = 3;

// The weight of a sample of density pdf > 0.
float power_heuristic(float pdf, float other_pdf) {
    const float ratio = other_pdf / pdf;
    return 1 / (1 + ratio * ratio);
}

// Which light, and where on it, from one point of the square: the light is a strip of the square,
// and what lies inside the strip is stretched to a square again. So a sample that is well spread
// over the square is well spread over the lights and over each of them.
const Light &choose_light(const Scene &scene, Vec2 &u) {
    if (scene.lights.size() == 1) return scene.lights[0];
    const Choice choice = distribution_choose(scene.light_limits.data(), scene.lights.size(), u.x);
    u.x = choice.rest;
    return scene.lights[choice.index];
}

} // namespace

Integrator integrator_create(const Scene &scene, const Geometry &geometry, const Sampler *sampler,
                             uint32_t max_depth) {
    const bool lens = scene.camera.lens_radius > 0;
    Integrator result{&scene,
                      &geometry,
                      sampler,
                      max_depth,
                      {},
                      first_light_domain(*sampler),
                      lens || scene.light_samples > 1};
    for (uint32_t ray = 0; ray <= max_depth; ++ray) {
        const bool with_light = !scene.lights.empty() && ray < max_depth;
        const bool both = ray > 0 ? with_light : lens || (with_light && !result.first_light_apart);
        const uint32_t domain = ray_domain(*sampler, ray);
        result.rays.push_back({domain, sampler->choices(domain), both ? 4 : 2});
    }
    return result;
}

PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters) {
    const Scene &scene = *integrator.scene;
    const Camera &camera = scene.camera;

    // ---- The camera ray
    const PixelSample sample = {integrator.sampler, x, y, index};
    const auto counted_draw = [&](uint32_t domain, int dimensions) {
        ++(dimensions == 2 ? counters.draws_2d : counters.draws_4d);
        return draw(sample, domain, dimensions);
    };
    // Of the ray's domain: pair (0,1) sent the ray, pair (2,3) chooses the light where it ends.
    Draw u = counted_draw(integrator.rays[0].ray, integrator.rays[0].dimensions);
    Ray ray = camera_ray(camera, {static_cast<float>(x) + u.u[0], static_cast<float>(y) + u.u[1]},
                         pair23(u));
    PathSample result{};
    Vec3 &radiance = result.radiance;
    Vec3 throughput = {1, 1, 1};
    // How the ray was found: with what density per steradian, against how many light samples. None
    // for rays that no light sample could have found, which are the camera's and those of mirrors.
    float scatter_pdf = 1, light_samples = 0;
    bool seen = true; // by the camera, straight or through mirrors and smooth glass

    for (uint32_t bounce = 0;; ++bounce) {
        Hit hit;
        ++counters.rays;
        const bool met = intersect(*integrator.geometry, ray, seen, hit);

        // ---- Light that the ray ran into
        if (!met) {
            if (!scene.environment) break;
            const Environment &environment = *scene.environment;
            const float found =
                light_samples > 0 && scene.environment_light >= 0
                    ? light_samples *
                          scene.lights[static_cast<size_t>(scene.environment_light)].probability *
                          environment_pdf(environment, ray.direction)
                    : 0;
            radiance += power_heuristic(scatter_pdf, found) *
                        (throughput * environment_radiance(environment, ray.direction));
            break;
        }
        const Surface surface = scene.surfaces[hit.triangle];
        const Vec3 out = -ray.direction;
        const float facing = dot(hit.normal, out); // > 0: the front is seen
        const bool front = facing > 0;
        if (surface.light >= 0 &&
            (front || scene.lights[static_cast<size_t>(surface.light)].both_sides)) {
            const Light &light = scene.lights[static_cast<size_t>(surface.light)];
            const float found = light_samples > 0 ? light_samples * light.probability *
                                                        light_pdf(light, hit.distance, facing)
                                                  : 0;
            const Vec3 shining =
                light.mapped ? emission_at(scene, {hit.triangle, hit.u, hit.v}) : light.radiance;
            radiance += power_heuristic(scatter_pdf, found) * (throughput * shining);
        }
        const Material &even = scene.materials[surface.material];
        std::optional<Material> varied; // where something differs from place to place
        if (even.maps >= 0) varied = material_at(scene, even, {hit.triangle, hit.u, hit.v});
        const Material &material = varied ? *varied : even;
        const Vec3 normal = front ? hit.normal : -hit.normal; // geometric, on the side of `out`
        const Vec3 shading =
            scene.normals.empty() && scene.maps.empty()
                ? normal
                : shading_normal(scene, hit.triangle, hit.u, hit.v, hit.normal, out);
        const Vec3 place = ray.origin + hit.distance * ray.direction;
        if (bounce == 0) {
            result.hit = true;
            result.albedo = material_albedo(material);
            result.normal = shading;
            result.depth = dot(place - camera.position, camera.forward);
        }
        if (bounce == integrator.max_depth) {
            counters.cut_off += static_cast<double>(luminance(throughput));
            break;
        }

        // ---- The surface, seen from its own frame
        const Frame frame = frame_around(shading);
        const Vec3 local_out = to_local(frame, out);
        if (!(local_out.z > 0)) break;
        // Rays start on the side they leave to. Directions on which the shading normal and the
        // triangle do not agree carry nothing.
        const auto start = [&](float side) {
            return offset_point(place, side > 0 ? normal : -normal, hit.distance);
        };
        const auto agree = [&](float local_z, Vec3 direction) {
            return (local_z > 0) == (dot(normal, direction) > 0);
        };

        // ---- Next event: points on lights
        const bool smooth = material_is_smooth(material);
        const uint32_t count = smooth || scene.lights.empty() ? 0
                               : bounce == 0                  ? scene.light_samples
                                                              : 1;
        for (uint32_t k = 0; k < count; ++k) {
            Vec2 point = pair23(u);
            if (bounce == 0 && integrator.first_light_apart) {
                ++counters.draws_2d;
                point = pair01(draw_split(sample, integrator.first_light, count, k));
            }
            const Light &light = choose_light(scene, point);
            const LightSample to_light = light_sample(light, place, point);
            if (!(to_light.pdf > 0)) continue;
            const Vec3 in = to_local(frame, to_light.direction);
            const Vec3 scattered = material_eval(material, front, local_out, in);
            if (!(max_component(scattered) > 0) || !agree(in.z, to_light.direction)) continue;
            ++counters.rays;
            const Vec3 end = light.area > 0 ? offset_point(to_light.point,
                                                           dot(light.normal, to_light.direction) < 0
                                                               ? light.normal
                                                               : -light.normal,
                                                           0)
                                            : to_light.point;
            if (occluded(*integrator.geometry, start(in.z), end)) continue;
            const float pdf = static_cast<float>(count) * light.probability * to_light.pdf;
            const float weight =
                light_has_extent(light)
                    ? power_heuristic(pdf, material_pdf(material, front, local_out, in))
                    : 1;
            const Vec3 shining =
                light.mapped
                    ? emission_at(scene, {light.triangle, to_light.place.x, to_light.place.y})
                    : to_light.radiance;
            radiance += (weight / pdf) * (throughput * scattered * shining);
        }

        // ---- The next ray, and roulette for it
        const Integrator::RayDomains &next = integrator.rays[bounce + 1];
        const bool roulette = bounce >= FIRST_ROULETTE_BOUNCE;
        Draw choices{};
        if (roulette || material_reads_lobe(material)) choices = counted_draw(next.choices, 2);
        u = counted_draw(next.ray, next.dimensions);
        const MaterialSample scatter =
            material_sample(material, front, local_out, pair01(u), choices.u[0]);
        if (!(scatter.pdf > 0)) break;
        const Vec3 direction = to_world(frame, scatter.in);
        if (!agree(scatter.in.z, direction)) break;
        throughput *= scatter.weight;
        if (roulette) {
            // The share of light the bounce keeps, so that survivors carry on undimmed.
            const float survival = std::min(max_component(scatter.weight), 1.0f);
            if (choices.u[1] >= survival) break;
            throughput = (1 / survival) * throughput;
        }
        ray = {start(scatter.in.z), direction};
        scatter_pdf = scatter.pdf;
        seen = seen && smooth;
        light_samples = static_cast<float>(count); // 0 after a mirror
    }
    return result;
}
