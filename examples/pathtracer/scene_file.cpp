// SPDX-License-Identifier: Apache-2.0
// What all scene readers share.
#include "scene_file.h"

#include <cctype>

#include "error.h"

namespace {

// At 555 nm, by the definition of the candela; glTF exporters use it for all light.
constexpr float LUMENS_PER_WATT = 683;
constexpr float MAX_GLOW = 1;           // radiance
constexpr double MAX_COORDINATE = 1e15; // doubles resolve an eighth there
// The largest distance from the scene's centre. Products of three lengths, and areas, still fit in
// a float, so pictures are right; a hundred times as far, Embree ends the program.
constexpr float MAX_REACH = 1e10f;

std::string ending(const std::string &name) {
    const size_t dot = name.rfind('.');
    std::string result = dot == std::string::npos ? "" : name.substr(dot);
    for (char &c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

bool is_usable(Point3d p) {
    return is_finite(p) && max_magnitude(p) <= MAX_COORDINATE;
}

// Turns triangles of emissive materials into lights. Returns whether any counts as a lamp. Textured
// emission does not, nor does emission no brighter than a display's white, the most that glTF's
// emissiveFactor reaches: eyes, labels and switches glow, but the scene keeps its sky.
bool make_area_lights(SceneDraft &draft) {
    Scene &scene = draft.scene;
    std::vector<Vec3> whole_textures; // of each map
    for (const SurfaceMaps &maps : scene.maps)
        whole_textures.push_back(maps.emission.texture >= 0 ? mean_emission(scene, maps)
                                                            : Vec3{0, 0, 0});
    bool lit = false;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uint32_t material = scene.surfaces[i].material;
        const Emission &emission = draft.emission[material];
        if (!(max_component(emission.radiance) > 0)) continue;
        const auto &t = scene.triangles[i].vertices;
        const Vec3 corner = scene.vertices[t[0]];
        Light light = area_light(Light::TRIANGLE, corner, scene.vertices[t[1]] - corner,
                                 scene.vertices[t[2]] - corner, emission.radiance);
        light.both_sides = emission.both_sides;
        const int32_t maps = scene.materials[material].maps;
        light.mapped = maps >= 0 && scene.maps[maps].emission.texture >= 0;
        if (light.mapped)
            light.radiance = mean_emission(scene, static_cast<uint32_t>(i), whole_textures[maps]);
        lit = lit || (!light.mapped && max_component(light.radiance) > MAX_GLOW);
        if (scene.lights.size() >= (1u << 22))
            throw Error("has more than 2^22 triangles that emit light");
        scene.surfaces[i].light = static_cast<int32_t>(scene.lights.size());
        scene.lights.push_back(light);
    }
    return lit;
}

// Converts double-precision points, such as those of transformed files, to float vertices. The
// centre of their bounds is subtracted first, so float keeps the digits that matter. Returns the
// centre; subtract it from cameras and lights too.
Point3d recentre(const std::vector<Point3d> &points, std::vector<Vec3> &vertices) {
    Point3d low = points[0], high = points[0];
    for (const Point3d p : points) {
        low = min(low, p);
        high = max(high, p);
    }
    const Point3d middle = 0.5 * (low + high);
    vertices.reserve(points.size());
    for (const Point3d p : points) vertices.push_back(p - middle);
    return middle;
}

// A three-quarter front view, slightly from above, as close as shows everything in a square.
Camera framing_camera(const Scene &scene) {
    const auto [low, high] = scene_bounds(scene);
    const Vec3 middle = 0.5f * (low + high), half = 0.5f * (high - low);
    const float tan_half_height = 0.35f, margin = 1.05f;
    const Vec3 to_eye = normalize(Vec3{0.55f, 0.42f, 1});
    Camera camera = camera_look_at(middle + to_eye, middle, {0, 1, 0}, tan_half_height);
    float distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 v = half * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const float aside = std::max(std::abs(dot(v, camera.right)), std::abs(dot(v, camera.up)));
        distance = std::max(distance, margin * aside / tan_half_height - dot(v, camera.forward));
    }
    camera.position = middle + (distance > 0 ? distance : 1) * to_eye;
    return camera;
}

// Moves a camera of the file to the origin along with the scene. Its target is the point on its
// axis nearest to the scene's centre.
Camera placed_camera(const DraftCamera &draft, Point3d middle) {
    const Vec3 position = Vec3(draft.position - middle);
    const float ahead = -dot(position, draft.forward);
    const Vec3 target = position + (ahead > 0 ? ahead : 1) * draft.forward;
    Camera camera = camera_look_at(position, target, draft.up, draft.tan_half_height);
    // Far from the centre, target - position loses precision: keep the file's direction.
    camera_turn(camera, draft.forward, draft.up);
    return camera;
}

} // namespace

bool is_scene_file(const std::string &name) {
    const std::string end = ending(name);
    return end == ".gltf" || end == ".glb" || end == ".obj";
}

int32_t draft_add_texture(SceneDraft &draft, const std::string &name, bool srgb,
                          const std::function<std::vector<unsigned char>()> &bytes) {
    try {
        draft.scene.textures.push_back(texture_decode(bytes()));
    } catch (const Error &error) {
        throw Error(name, ": ", error.what());
    }
    Texture &texture = draft.scene.textures.back();
    texture.srgb = srgb;
    if (texture.cut_short) draft.ignored.insert("that " + name + " is cut short");
    return static_cast<int32_t>(draft.scene.textures.size() - 1);
}

uint32_t draft_add_vertex(SceneDraft &draft, const DraftVertex &v) {
    if (draft.points.size() >= MAX_SCENE_ELEMENTS) throw Error("has more than 2^26 vertices");
    if (!is_usable(v.position))
        throw Error("has a vertex that is not a finite number, or beyond 1e15");
    Scene &scene = draft.scene;
    draft.points.push_back(v.position);
    scene.normals.push_back(v.normal);
    for (int set = 0; set < 2; ++set) scene.texture_coordinates[set].push_back(v.coordinates[set]);
    scene.colours.push_back(v.colour);
    return static_cast<uint32_t>(draft.points.size() - 1);
}

void draft_add_triangle(SceneDraft &draft, uint32_t material, uint32_t a, uint32_t b, uint32_t c) {
    if (draft.scene.triangles.size() >= MAX_SCENE_ELEMENTS)
        throw Error("has more than 2^26 triangles");
    draft.scene.triangles.push_back({{a, b, c}});
    draft.scene.surfaces.push_back({material, -1});
}

uint32_t draft_add_material(SceneDraft &draft, const Material &material, const Emission &emission,
                            const SurfaceMaps &maps) {
    Scene &scene = draft.scene;
    scene.materials.push_back(material);
    scene.has_single_sided = scene.has_single_sided || material.single_sided;
    draft.emission.push_back(emission);
    bool any = maps.alpha_cutoff > 0 || maps.vertex_colours;
    for (const TextureUse *use : {&maps.colour, &maps.metallic_roughness, &maps.roughness,
                                  &maps.metallic, &maps.emission, &maps.normal, &maps.cut_out})
        any = any || use->texture >= 0;
    if (any) {
        scene.materials.back().maps = static_cast<int32_t>(scene.maps.size());
        scene.maps.push_back(maps);
        scene.has_cut_outs = scene.has_cut_outs || maps.alpha_cutoff > 0;
    }
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

Scene scene_file_read(const std::string &path, const SceneOptions &options) {
    try {
        SceneFolder folder(path, options.allow_outside, options.record);
        SceneDraft draft = ending(path) == ".obj" ? obj_read(folder) : gltf_read(folder);
        Scene &scene = draft.scene;
        if (scene.triangles.empty()) throw Error("has no triangles to render");
        if (scene.maps.empty()) { // then nothing looks these up
            for (std::vector<Vec2> &set : scene.texture_coordinates) set = {};
            scene.colours = {};
        }
        bool has_normals = false;
        for (const Vec3 n : scene.normals) has_normals = has_normals || max_magnitude(n) > 0;
        if (!has_normals) scene.normals = {};
        const Point3d middle = recentre(draft.points, scene.vertices);
        draft.points = {};

        for (const Vec3 v : scene.vertices)
            if (!(max_magnitude(v) <= MAX_REACH))
                throw Error("extends more than 1e10 from its centre; scale it down");
        bool lit = make_area_lights(draft);
        for (DraftLight &light : draft.lights) {
            if (!is_usable(light.position)) {
                draft.ignored.insert("a light beyond 1e15");
                continue;
            }
            light.light.corner = Vec3(light.position - middle);
            if (options.photometric)
                light.light.radiance = (1 / LUMENS_PER_WATT) * light.light.radiance;
            scene.lights.push_back(light.light);
            lit = true;
        }
        scene.origin = middle;
        for (const DraftCamera &camera : draft.cameras) {
            if (is_usable(camera.position))
                scene.cameras.push_back({placed_camera(camera, middle), camera.name});
            else
                draft.ignored.insert("a camera beyond 1e15");
        }
        scene.camera = scene.cameras.empty() ? framing_camera(scene) : scene.cameras[0].camera;
        if (options.environment)
            scene.environment = options.environment;
        else if (!lit)
            scene.environment = std::make_shared<Environment>(environment_read("sky"));

        std::string ignored;
        for (const std::string &what : draft.ignored)
            ignored += (ignored.empty() ? "" : ", ") + what;
        if (!ignored.empty()) scene.notes.push_back(path + ": ignores " + ignored);
        return std::move(scene);
    } catch (const Error &error) {
        throw Error(path, ": ", error.what());
    } catch (const std::bad_alloc &) {
        throw Error(path, ": needs more memory than there is, or than --max-memory allows");
    }
}
