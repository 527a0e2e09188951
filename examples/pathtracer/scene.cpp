// SPDX-License-Identifier: Apache-2.0
// Prepares scenes for rendering, and evaluates the properties that vary over their surfaces.
#include "scene.h"

#include <iomanip>

namespace {

void include(Bounds &b, Vec3 v) {
    b.low = min(b.low, v);
    b.high = max(b.high, v);
}

// The bounds of all surfaces while the shutter is open.
Bounds extent_of(const Scene &scene) {
    Bounds b = scene_bounds(scene);
    for (size_t i = 0; i < scene.motions.size(); ++i)
        include(b, scene.vertices[i] + scene.motions[i]);
    if (scene.medium) include(b, scene.medium->low), include(b, scene.medium->high);
    if (!(b.low.x <= b.high.x)) b = {};
    return b;
}

void drop_triangles_without_area(Scene &scene) {
    size_t kept = 0;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const auto &t = scene.triangles[i].vertices;
        const Vec3 a = scene.vertices[t[0]], b = scene.vertices[t[1]], c = scene.vertices[t[2]];
        if (!(max_magnitude(cross(b - a, c - a)) > 0)) continue;
        scene.triangles[kept] = scene.triangles[i];
        for (size_t k = 0; k < 3 && !scene.tangents.empty(); ++k)
            scene.tangents[3 * kept + k] = scene.tangents[3 * i + k];
        ++kept;
    }
    scene.triangles.resize(kept);
}

void prepare_lights(Scene &scene) {
    std::vector<int32_t> new_index; // -1: it never shines
    size_t kept = 0;
    for (const Light &light : scene.lights) {
        const float power = light_power(light);
        const bool shines = power > 0 && std::isfinite(power);
        new_index.push_back(shines ? int32_t(kept) : -1);
        if (shines) scene.lights[kept++] = light;
    }
    scene.lights.resize(kept);
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        int32_t &light = scene.triangles[i].light;
        if (light >= 0) light = new_index[light];
        if (light >= 0) scene.lights[light].triangle = uint32_t(i);
    }
    if (scene.environment && scene.environment->irradiance > 0) {
        scene.environment_light = int32_t(kept);
        Light light{};
        light.kind = Light::ENVIRONMENT;
        light.environment = scene.environment.get();
        scene.lights.push_back(light);
    }
    // Lights without a position lie beyond everything, including the camera.
    const Bounds e = extent_of(scene);
    const float half_diagonal = 0.5f * length(e.high - e.low);
    const float radius = half_diagonal > 0 ? half_diagonal : 1;
    const float beyond = 4 * (radius + length(scene.camera.position - 0.5f * (e.low + e.high)));
    for (Light &light : scene.lights) light.distance = beyond;
    scene.light_tree = light_tree(scene.lights);
}

template <typename Value>
Value interpolated(const Scene &scene, const std::vector<Value> &values, SurfacePoint p) {
    const Triangle &t = scene.triangles[p.triangle];
    const Value a = values[t.vertices[0]], b = values[t.vertices[1]], c = values[t.vertices[2]];
    return (1 - p.u - p.v) * a + p.u * b + p.v * c;
}

const SurfaceMaps &maps_of(const Scene &scene, SurfacePoint p) {
    return scene.maps[material_of(scene, p.triangle).maps];
}

glm::vec4 looked_up(const Scene &scene, const TextureUse &use, SurfacePoint p) {
    const Vec2 uv = interpolated(scene, scene.texture_coordinates[use.set], p);
    return texture_at(scene.textures[use.texture], use.transform * Vec3(uv, 1));
}

// The shading normal, bent by the material's normal map if it has one.
Vec3 mapped_normal(const Scene &scene, SurfacePoint p, Vec3 normal) {
    if (material_of(scene, p.triangle).maps < 0) return normal;
    const SurfaceMaps &maps = maps_of(scene, p);
    if (maps.normal.texture < 0) return normal;
    const glm::vec4 *const corners = &scene.tangents[3 * p.triangle];
    const glm::vec4 mean = (1 - p.u - p.v) * corners[0] + p.u * corners[1] + p.v * corners[2];
    const Vec3 tangent = mean, n = looked_up(scene, maps.normal, p);
    const Vec3 across = normalize_or(tangent - dot(tangent, normal) * normal, {0, 0, 0});
    const Vec3 up = (mean.w < 0 ? -1.0f : 1.0f) * cross(normal, across);
    const float x = maps.normal_scale * (2 * n.x - 1), y = maps.normal_scale * (2 * n.y - 1);
    return normalize_or(x * across + y * up + (2 * n.z - 1) * normal, normal);
}

// Bends a shading normal just enough to reflect `wo`, on the front, above the surface with normal
// `geometric`. Otherwise, normal-mapped mirrors have black spots where reflections enter the
// surface (Keller et al., "The Iray Light Transport Simulation and Rendering System", 2017).
Vec3 mirroring_normal(Vec3 normal, Vec3 geometric, Vec3 wo) {
    // The smallest allowed cosine between the reflected direction and the geometric normal.
    const float facing = dot(geometric, wo);
    const float least = std::min(0.9f * facing, 0.01f);
    // Tilt a shading normal that faces away from `wo` until it is edge-on.
    const float aside = dot(normal, wo);
    if (aside < 0) normal = normalize_or(normal - aside * wo, geometric);
    const Vec3 mirrored = 2 * std::max(aside, 0.0f) * normal - wo;
    const float below = least - dot(mirrored, geometric);
    if (!(below > 0)) return normal;
    // Raise the reflected direction along the shading normal, or along the geometric normal if the
    // shading normal is nearly tangent to the surface.
    const float rise = dot(normal, geometric);
    const Vec3 lifted =
        rise > 0.1f ? mirrored + (below / rise) * normal : mirrored + below * geometric;
    return normalize_or(wo + normalize_or(lifted, geometric), geometric);
}

// ---- The camera

constexpr double DEGREE = 3.14159265358979323846 / 180;

// The smallest number of digits, at least `least`, with which read_back() accepts the number.
template <typename ReadBack>
std::string digits(double value, int least, const ReadBack &read_back) {
    std::ostringstream text;
    for (int precision = least;; ++precision, text.str("")) {
        text << std::setprecision(precision) << value;
        if (precision == 17 || read_back(std::stod(text.str()))) return text.str();
    }
}

// v plus the origin, with enough digits to get v back.
std::string digits(Vec3 v, Point3d origin) {
    const auto coordinate = [&](int i) {
        return digits(double{v[i]} + origin[i], 6,
                      [&](double sum) { return float(sum - origin[i]) == v[i]; });
    };
    return coordinate(0) + "," + coordinate(1) + "," + coordinate(2);
}

float tan_half(double fov) {
    return float(std::tan(0.5 * fov * DEGREE));
}

// Sets the scene's camera. Up in the image is +y, or -z if the camera looks straight down, or +z if it
// looks straight up. A lens keeps its radius and focus distance. Throws Error.
void choose_camera(Scene &scene, const SceneOptions &choice) {
    Camera &camera = scene.camera;
    if (choice.camera) {
        if (*choice.camera >= scene.cameras.size())
            throw Error("there is no camera ", *choice.camera, ": the scene has ",
                        scene.cameras.size(), " of its own; see --list-cameras, or set --eye");
        camera = scene.cameras[*choice.camera];
    }
    if (choice.lens) camera.lens_radius = *choice.lens;
    if (choice.fov) camera.tan_half_height = tan_half(*choice.fov);
    camera.frames_square = camera.frames_square && !choice.fov && !choice.eye && !choice.target;
    const Point3d eye = choice.eye.value_or(Point3d(camera.position) + scene.origin);
    const Point3d target = choice.target.value_or(Point3d(camera.target) + scene.origin);
    const Vec3 position = Vec3(eye - scene.origin), ahead = Vec3(target - scene.origin);
    const double distance = length(target - eye);
    if (choice.focus || !(camera.focus_distance > 0))
        camera.focus_distance = choice.focus.value_or(float(distance));
    // Re-aiming at the same target would change the last bits of the scene's own camera.
    if (position == camera.position && ahead == camera.target) return;
    if (!(distance > 0) || !std::isfinite(distance))
        throw Error("the camera has no direction: --eye and --target are both ",
                    digits(position, scene.origin), "; move one of them");
    const Vec3 forward = Vec3((target - eye) / distance);
    Vec3 up = {0, 1, 0};
    if (!(max_magnitude(cross(forward, up)) > 1e-6f)) up = {0, 0, forward.y < 0 ? -1.0f : 1.0f};
    camera.position = position;
    camera.target = ahead;
    camera_turn(camera, forward, up);
}

} // namespace

Bounds scene_bounds(const Scene &scene) {
    Bounds b = {Vec3(INFINITY), Vec3(-INFINITY)};
    for (const Vec3 v : scene.vertices) include(b, v);
    return b;
}

void scene_finish(Scene &scene) {
    if (!scene.normals.empty()) scene.normals.resize(scene.vertices.size(), {0, 0, 0});
    if (!scene.motions.empty()) scene.motions.resize(scene.vertices.size(), {0, 0, 0});
    drop_triangles_without_area(scene);
    prepare_lights(scene);
    for (Material &material : scene.materials) material_prepare(material);
}

ShadingNormals shading_normals(const Scene &scene, SurfacePoint p, Vec3 normal, Vec3 wo) {
    const Material &material = material_of(scene, p.triangle);
    Vec3 smooth = normal;
    if (!scene.normals.empty())
        smooth = normalize_or(interpolated(scene, scene.normals, p), normal);
    Vec3 bent = scene.maps.empty() ? smooth : mapped_normal(scene, p, smooth);
    if (dot(smooth, normal) < 0) { // the corners are in the wrong order, or the normals flipped
        if (material.single_sided)
            bent -= 2 * dot(bent, smooth) * smooth, smooth = -smooth;
        else
            normal = -normal;
    }
    const bool front = dot(normal, wo) > 0;
    const Vec3 geometric = front ? normal : -normal;
    if (scene.normals.empty() && scene.maps.empty()) return {geometric, geometric, front};
    const bool mirrors = material.kind != Material::DIFFUSE;
    if (mirrors || dot(front ? bent : -bent, wo) > 0) smooth = bent;
    const Vec3 turned = front ? smooth : -smooth;
    if (mirrors) return {geometric, mirroring_normal(turned, geometric, wo), front};
    return {geometric, dot(turned, wo) > 0 ? turned : geometric, front};
}

Material material_at(const Scene &scene, const Material &material, SurfacePoint p) {
    Material m = material;
    const SurfaceMaps &maps = maps_of(scene, p);
    if (maps.vertex_colours) m.albedo *= Vec3(interpolated(scene, scene.colours, p));
    if (maps.colour.texture >= 0) m.albedo *= Vec3(looked_up(scene, maps.colour, p));
    if (maps.metallic_roughness.texture >= 0) {
        const glm::vec4 texel = looked_up(scene, maps.metallic_roughness, p);
        m.metallic *= texel.b;
        m.roughness *= texel.g;
    }
    return m;
}

bool is_cut_out(const Scene &scene, SurfacePoint p) {
    if (material_of(scene, p.triangle).maps < 0) return false;
    const SurfaceMaps &maps = maps_of(scene, p);
    if (!(maps.alpha_cutoff > 0)) return false;
    float alpha = maps.alpha;
    if (maps.vertex_colours) alpha *= interpolated(scene, scene.colours, p).a;
    if (maps.cut_out.texture >= 0) alpha *= looked_up(scene, maps.cut_out, p).a;
    return alpha < maps.alpha_cutoff - 1e-6f; // rounding makes no holes
}

Vec3 emission_at(const Scene &scene, SurfacePoint p) {
    if (is_cut_out(scene, p)) return Vec3(0);
    const SurfaceMaps &maps = maps_of(scene, p);
    if (maps.emission.texture < 0) return maps.emission_factor;
    return maps.emission_factor * Vec3(looked_up(scene, maps.emission, p));
}

std::string camera_text(const Scene &scene, const Camera &camera) {
    const float tangent = camera.tan_half_height;
    return joined("--eye ", digits(camera.position, scene.origin), " --target ",
                  digits(camera.target, scene.origin), " --fov ",
                  digits(2 * std::atan(double{tangent}) / DEGREE, 3,
                         [&](double fov) { return tan_half(fov) == tangent; }));
}

std::string camera_list(const Scene &scene) {
    if (scene.cameras.empty())
        return "none of its own; everything is framed by " + camera_text(scene, scene.camera) +
               "\n";
    std::string list;
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        const std::string &name = scene.cameras[i].name;
        list += joined(i, "  ", camera_text(scene, scene.cameras[i]),
                       name.empty() ? "" : "  '" + name + "'", "\n");
    }
    return list;
}

std::string scene_extent_text(const Scene &scene) {
    const auto [low, high] = scene_bounds(scene);
    const Point3d a = Point3d(low) + scene.origin, b = Point3d(high) + scene.origin;
    return joined("reaches from ", a.x, ",", a.y, ",", a.z, " to ", b.x, ",", b.y, ",", b.z);
}

// ---- Finding scenes by name

Scene scene_build(const std::string &name, const SceneOptions &options) {
    Scene scene;
    std::string known;
    for (const SceneEntry &entry : scene_entries()) {
        known += std::string(entry.name) + ", ";
        if (name == entry.name) {
            scene = entry.build();
            scene.cameras = {scene.camera};
            if (options.environment) scene.environment = options.environment;
        }
    }
    if (is_scene_file(name))
        scene = scene_file_read(name, options);
    else if (name.find('.') != std::string::npos)
        throw Error(name, ": scenes are read from .gltf and .glb; convert it: scripts/to-gltf ",
                    name);
    else if (scene.cameras.empty())
        throw Error("there is no scene '", name, "'; the scenes are ", known,
                    "or a file named .gltf or .glb");
    named(name, [&] { choose_camera(scene, options); });
    scene_finish(scene);
    return scene;
}
