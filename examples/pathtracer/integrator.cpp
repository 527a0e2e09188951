// SPDX-License-Identifier: Apache-2.0
// A unidirectional path tracer (Kajiya, "The Rendering Equation", 1986) with next event estimation.
// Light is found both by choosing points on lights and by scattered rays that hit one; the power
// heuristic weighs the two (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte
// Carlo Rendering", 1995). Paths end by Russian roulette or after max_depth bounces, whichever is
// first; up to there the estimate is unbiased. Pixels are boxes, each sample counts for its own
// pixel only: splatting would tie neighbours together and spoil the blue noise.
#include "integrator.h"

namespace {

// The first bounces decide most of a pixel; roulette there would cost more noise than time.
constexpr uint32_t FIRST_ROULETTE_BOUNCE = 3;

// The weight of a sample of density pdf > 0.
float power_heuristic(float pdf, float other_pdf) {
    const float ratio = other_pdf / pdf;
    return 1 / (1 + ratio * ratio);
}

} // namespace

Integrator integrator_create(const Scene &scene, const Geometry &geometry,
                             const bn_sampler *sampler, uint32_t max_depth) {
    Integrator result{&scene, &geometry, sampler, max_depth, pixel_domain(), {}};
    for (uint32_t bounce = 0; bounce < max_depth; ++bounce) {
        const uint32_t domain = bounce_domain(bounce);
        result.bounces.push_back({light_domain(domain), scatter_domain(domain)});
    }
    return result;
}

Vec3 trace_path(const Integrator &integrator, int x, int y, uint32_t index, uint64_t &ray_count) {
    const Scene &scene = *integrator.scene;
    const PixelSample sample = {integrator.sampler, x, y, index};
    const float light_count = static_cast<float>(scene.lights.size());

    const Vec2 in_pixel = pair01(draw(sample, integrator.pixel, 2));
    Ray ray = camera_ray(scene.camera,
                         {static_cast<float>(x) + in_pixel.x, static_cast<float>(y) + in_pixel.y});
    Vec3 radiance = {0, 0, 0};
    Vec3 throughput = {1, 1, 1};
    float scatter_pdf = 0; // of the ray, per steradian

    for (uint32_t bounce = 0;; ++bounce) {
        Hit hit;
        ++ray_count;
        if (!intersect(*integrator.geometry, ray, hit)) break;
        const Surface surface = scene.surfaces[hit.triangle];
        const float facing = -dot(hit.normal, ray.direction); // > 0: the front is seen

        // ---- Light that the ray ran into
        if (surface.light >= 0 && facing > 0) {
            const Light &light = scene.lights[static_cast<size_t>(surface.light)];
            const float weight =
                bounce == 0 ? 1
                            : power_heuristic(scatter_pdf,
                                              light_pdf(light, hit.distance, facing) / light_count);
            radiance += weight * (throughput * light.radiance);
        }
        if (bounce == integrator.max_depth) break;

        const Integrator::BounceDomains domains = integrator.bounces[bounce];
        const Material &material = scene.materials[surface.material];
        const Frame frame = frame_around(facing > 0 ? hit.normal : -hit.normal);
        const Vec3 point =
            offset_point(ray.origin + hit.distance * ray.direction, frame.normal, hit.distance);

        // ---- Next event: a point on a light
        if (!scene.lights.empty()) {
            const Draw u = draw(sample, domains.light, scene.lights.size() > 1 ? 4 : 2);
            const auto chosen = static_cast<size_t>(u.u[2] * light_count);
            const Light &light = scene.lights[std::min(chosen, scene.lights.size() - 1)];
            const LightSample to_light = light_sample(light, point, pair01(u));
            const Vec3 scattered = material_eval(material, frame, to_light.direction);
            if (to_light.pdf > 0 && max_component(scattered) > 0) {
                ++ray_count;
                const Vec3 end = offset_point(to_light.point, light.normal, 0);
                if (!occluded(*integrator.geometry, point, end)) {
                    const float pdf = to_light.pdf / light_count;
                    const float weight =
                        power_heuristic(pdf, material_pdf(material, frame, to_light.direction));
                    radiance += (weight / pdf) * (throughput * scattered * light.radiance);
                }
            }
        }

        // ---- The next ray, and roulette for it
        const bool roulette = bounce >= FIRST_ROULETTE_BOUNCE;
        const Draw u = draw(sample, domains.scatter, roulette ? 4 : 2);
        const MaterialSample scatter = material_sample(material, frame, pair01(u));
        if (!(scatter.pdf > 0)) break;
        throughput *= scatter.weight;
        if (roulette) {
            // The share of light the bounce keeps, so that survivors carry on undimmed.
            const float survival = std::min(max_component(scatter.weight), 1.0f);
            if (u.u[2] >= survival) break;
            throughput = (1 / survival) * throughput;
        }
        ray = {point, scatter.in};
        scatter_pdf = scatter.pdf;
    }
    return radiance;
}
