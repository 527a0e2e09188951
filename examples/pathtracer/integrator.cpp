// SPDX-License-Identifier: Apache-2.0
// A unidirectional path tracer (Kajiya, "The Rendering Equation", 1986) with next event estimation. The
// power heuristic combines light sampling and BSDF sampling (Veach and Guibas, "Optimally Combining
// Sampling Techniques for Monte Carlo Rendering", 1995). Paths end by Russian roulette or after
// max_depth bounces. Pixel filters are sampled, because splatting would correlate neighbours and
// destroy the blue noise.
#include "integrator.h"

namespace {

// The first bounces contribute most light: Russian roulette there would cost more than it saves.
constexpr uint32_t FIRST_ROULETTE_BOUNCE = 3;

bool has_lens(const Scene &scene) {
    return scene.camera.lens_radius > 0;
}

// Whether the first light sample cannot use ray 0: a lens uses that pair, or the sample is split.
bool first_light_apart(const Scene &scene) {
    return has_lens(scene) || scene.light_samples > 1;
}

// The surface or particle that a ray hits. A particle's normal points back along the ray.
struct Vertex {
    const Material *material;
    Vec3 point;
    float distance;         // from the ray's origin
    ShadingNormals normals; // on the side the ray came from
    glm::mat3 frame;        // around the shading normal
    Vec3 wo;                // back along the ray, in the frame

    Vertex(const Material &of, const Ray &ray, float flight, const ShadingNormals &n)
        : material(&of), point(ray.origin + flight * ray.direction), distance(flight), normals(n),
          frame(frame_around(n.shading)), wo(-ray.direction * frame) {}
    Receiver receiver() const {
        const auto kind = material->kind;
        return {point, normals.shading, kind != Material::DIELECTRIC && kind != Material::PHASE};
    }
    Vec3 start(Vec3 wi) const {
        return offset_point(point, wi.z > 0 ? normals.geometric : -normals.geometric, distance);
    }
    // Whether the triangle and the shading normal agree on the side of `wi`; otherwise it carries no light.
    bool same_side(Vec3 wi, Vec3 direction) const {
        return (wi.z > 0) == (dot(normals.geometric, direction) > 0);
    }
};

template <typename PathNumbers>
class Path {
  public:
    Path(const Integrator &integrator, const PathNumbers &numbers, PathCounters &counters)
        : integrator_(integrator), scene_(*integrator.scene), path_numbers_(numbers),
          counters_(counters), numbers_(numbers.ray(0)) {}

    PathSample trace(int x, int y) {
        const Camera &camera = scene_.camera;
        u_ = draw(0);
        const auto position = [&](float u) {
            return integrator_.gaussian_filter ? gaussian_position(u) : u;
        };
        ray_ = camera_ray(camera, {float(x) + position(u_[0]), float(y) + position(u_[1])},
                          {u_[2], u_[3]});
        // Time could use ray 0's second pair, as a lens does, but then the first light could not.
        if (!scene_.motions.empty()) ray_.time = path_numbers_.time_wavelength()[0];
        PathSample result{};
        while (true) {
            Hit hit;
            ++counters_.rays;
            const bool met = intersect(*integrator_.geometry, ray_, seen_by_camera_, hit);
            const float flight = free_flight(met ? hit.distance : INFINITY);
            const bool in_medium = flight < INFINITY;
            std::optional<Material> textured;
            std::optional<Vertex> vertex;
            if (met && (bounce_ == 0 || !in_medium)) vertex = vertex_at(hit, textured);
            if (met && bounce_ == 0) {
                // Also for surfaces behind fog, because denoisers need guides without noise.
                result.hit = true;
                const Material &m = *vertex->material;
                result.albedo = m.kind == Material::DIELECTRIC ? Vec3(1) : m.albedo;
                result.normal = vertex->normals.shading;
                result.depth = dot(vertex->point - camera.position, camera.forward);
            }
            if (in_medium)
                vertex.emplace(scene_.medium->material, ray_, flight,
                               ShadingNormals{-ray_.direction, -ray_.direction, true});
            else if (met)
                add_emission(hit);
            else
                add_environment();
            if (!vertex) break;
            if (bounce_ == integrator_.max_depth) {
                counters_.cut_off += double(luminance(throughput_));
                break;
            }
            if (!(vertex->wo.z > 0)) break;
            const uint32_t count = add_light_samples(*vertex);
            numbers_ = path_numbers_.ray(++bounce_);
            if (!scatter(*vertex)) break;
            light_samples_ = float(count); // 0 after a mirror
        }
        result.radiance = radiance_;
        return result;
    }

  private:
    // A ray's numbers. The second pair is drawn only if it serves a light or the lens.
    std::array<float, 4> draw(uint32_t ray) const {
        const bool light = !scene_.lights.empty() && ray < integrator_.max_depth;
        if (ray > 0 ? light : has_lens(scene_) || (light && !first_light_apart(scene_)))
            return numbers_.draw();
        const auto [u, v] = numbers_.draw_direction();
        return {u, v, 0, 0};
    }

    // The distance to the ray's next collision before `end`, or infinity.
    float free_flight(float end) const {
        if (!scene_.medium) return INFINITY;
        bn::LoopSampler walk = numbers_.draw_loop(0);
        return medium_free_flight(*scene_.medium, ray_, end, walk);
    }

    // The material at a point, stored in `textured` if it has maps.
    Vertex vertex_at(const Hit &hit, std::optional<Material> &textured) const {
        const Material &base = material_of(scene_, hit.point.triangle);
        if (base.maps >= 0) textured = material_at(scene_, base, hit.point);
        return {textured ? *textured : base, ray_, hit.distance,
                shading_normals(scene_, hit.point, hit.normal, -ray_.direction)};
    }

    // ---- Light that the ray hits

    // Adds light that the ray found. Had next event estimation chosen this light (-1 for none), it
    // would have sampled the ray's direction with density `pdf`.
    void add_found_light(int32_t light, float pdf, Vec3 emitted) {
        float other = 0;
        if (light_samples_ > 0 && light >= 0)
            other =
                light_samples_ * pdf * light_probability(scene_.light_tree, from_, uint32_t(light));
        radiance_ += power_heuristic(scatter_pdf_, other) * (throughput_ * emitted);
    }

    void add_environment() {
        if (!scene_.environment) return;
        const Environment &environment = *scene_.environment;
        add_found_light(scene_.environment_light, environment_pdf(environment, ray_.direction),
                        environment_radiance(environment, ray_.direction));
    }

    void add_emission(const Hit &hit) {
        const int32_t number = scene_.triangles[hit.point.triangle].light;
        if (number < 0) return;
        const Light &light = scene_.lights[number];
        const float cosine = -dot(hit.normal, ray_.direction);
        if (!(cosine > 0) && !light.both_sides) return;
        add_found_light(number, light_pdf(light, hit.distance, cosine),
                        light.mapped ? emission_at(scene_, hit.point) : light.radiance);
    }

    // ---- Next event estimation

    // Adds the contribution of light sample k of `count`, chosen by u.
    void add_light_sample(const Vertex &v, Vec2 u, uint32_t count, uint32_t k) {
        const LightChoice choice = light_choose(scene_.light_tree, v.receiver(), u.x);
        if (choice.light < 0) return;
        const Light &light = scene_.lights[choice.light];
        const LightSample sample = light_sample(light, v.point, u);
        if (!(sample.pdf > 0)) return;
        const Vec3 wi = sample.direction * v.frame;
        const auto [scattered, own_pdf] = material_value(*v.material, v.normals.front, v.wo, wi);
        if (!(max_component(scattered) > 0) || !v.same_side(wi, sample.direction)) return;
        ++counters_.rays;
        const Ray shadow = {v.start(wi), sample.direction, ray_.time};
        Vec3 end = sample.point; // moved off the light to the side that emits towards the surface
        if (light.area > 0)
            end = offset_point(
                end, dot(light.normal, sample.direction) < 0 ? light.normal : -light.normal, 0);
        if (occluded(*integrator_.geometry, shadow.origin, end, shadow.time)) return;
        float passed = 1;
        if (scene_.medium) {
            bn::LoopSampler walk = numbers_.draw_loop(k + 1);
            passed =
                medium_transmittance(*scene_.medium, shadow, length(end - shadow.origin), walk);
        }
        const float pdf = float(count) * choice.probability * sample.pdf;
        const float weight = light.has_extent() ? power_heuristic(pdf, own_pdf) : 1;
        const SurfacePoint place = {light.triangle, sample.place.x, sample.place.y};
        const Vec3 emitted = light.mapped ? emission_at(scene_, place) : sample.radiance;
        radiance_ += (passed * weight / pdf) * (throughput_ * scattered * emitted);
    }

    // Returns the number of light samples.
    uint32_t add_light_samples(const Vertex &v) {
        if (material_is_smooth(*v.material) || scene_.lights.empty()) return 0;
        const uint32_t count = bounce_ == 0 ? scene_.light_samples : 1;
        for (uint32_t k = 0; k < count; ++k) {
            Vec2 u = {u_[2], u_[3]};
            if (bounce_ == 0 && first_light_apart(scene_)) {
                const auto [s, t] = path_numbers_.first_light(count, k);
                u = {s, t};
            }
            add_light_sample(v, u, count, k);
        }
        return count;
    }

    // ---- The next ray

    // Continues the path in a direction sampled from the material. Returns false if the path ends.
    bool scatter(const Vertex &v) {
        const Material &m = *v.material;
        const bool roulette = bounce_ > FIRST_ROULETTE_BOUNCE;
        float lobe = 0, fate = 0;
        if (roulette || (m.kind == Material::DIELECTRIC && !material_is_smooth(m))) {
            lobe = numbers_.next_1d();
            fate = numbers_.next_1d();
        }
        u_ = draw(bounce_);
        const MaterialSample sample =
            material_sample(m, v.normals.front, v.wo, Vec2{u_[0], u_[1]}, lobe);
        if (!(sample.pdf > 0)) return false;
        const Vec3 direction = v.frame * sample.wi;
        if (!v.same_side(sample.wi, direction)) return false;
        throughput_ *= sample.weight;
        if (roulette) {
            // The survival probability is the share of light kept, so survivors keep their throughput.
            const float survival = std::min(max_component(sample.weight), 1.0f);
            if (fate >= survival) return false;
            throughput_ = (1 / survival) * throughput_;
        }
        ray_ = {v.start(sample.wi), direction, ray_.time};
        scatter_pdf_ = sample.pdf;
        from_ = v.receiver();
        seen_by_camera_ = seen_by_camera_ && material_is_smooth(m);
        return true;
    }

    const Integrator &integrator_;
    const Scene &scene_;
    const PathNumbers &path_numbers_;
    PathCounters &counters_;
    decltype(path_numbers_.ray(0)) numbers_;
    uint32_t bounce_ = 0;
    // The first pair chose the ray, the second chooses a light where the ray ends.
    std::array<float, 4> u_;
    Ray ray_;
    Vec3 throughput_ = {1, 1, 1};
    Vec3 radiance_ = {0, 0, 0};
    // The density per steradian with which the ray was chosen, and the number of light samples that
    // compete with it: none after the camera or a mirror.
    float scatter_pdf_ = 1, light_samples_ = 0;
    Receiver from_ = {};         // where the ray was scattered, and light samples were chosen
    bool seen_by_camera_ = true; // directly, or through mirrors and smooth glass
};

} // namespace

PathSample trace_path(const Integrator &integrator, int x, int y, uint32_t index,
                      PathCounters &counters) {
    ++counters.paths;
    return with_path(
        *integrator.sampler, x - integrator.draw_dx, y - integrator.draw_dy, index,
        [&](const auto &numbers) { return Path(integrator, numbers, counters).trace(x, y); });
}
