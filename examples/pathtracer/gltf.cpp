// SPDX-License-Identifier: Apache-2.0
// Reads glTF 2.0: walks the scene's node tree and reads its meshes, cameras and lights.
// Transforms are composed and applied in double, so that geometry far from the origin keeps its
// precision. The walk is iterative; a node reached twice is an error: such nodes form no tree.
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "gltf_parts.h"

namespace {

// ---- The file

// Extensions that the reader supports, or reports itself where a material uses them.
bool is_known(const std::string &extension) {
    static const std::set<std::string> known = {
        "KHR_lights_punctual", "KHR_texture_transform", "KHR_mesh_quantization", "EXT_texture_webp",
        "EXT_texture_avif",    "KHR_texture_basisu",    "MSFT_texture_dds"};
    return known.count(extension) > 0 || extension.compare(0, 14, "KHR_materials_") == 0;
}

// Keeps the bytes of an image, to be decoded when a material first uses it. Images in buffer views
// stay there, as the view is not checked yet.
bool keep_image(tinygltf::Image *image, const int, std::string *, std::string *, int, int,
                const unsigned char *bytes, int size, void *) {
    if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
    return true;
}

std::string first_line(const std::string &text) {
    return text.substr(0, text.find('\n'));
}

// tinygltf requests files by the names in the scene, and reads them only through this.
struct FileAccess {
    SceneFolder &folder;
    std::string problem; // with the last file requested
};

bool read_whole_file(std::vector<unsigned char> *bytes, std::string *error, const std::string &name,
                     void *user) {
    auto &access = *static_cast<FileAccess *>(user);
    try {
        *bytes = access.folder.read(name);
        return true;
    } catch (const Error &problem) {
        access.problem = printable(name) + ": " + problem.what();
        *error = access.problem;
        return false;
    }
}

// tinygltf recurses into nested values.
void check_nesting(const char *text, size_t size) {
    constexpr int MAX_NESTING = 256;
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < size; ++i) {
        const char c = text[i];
        if (c == '\\') ++i; // only in strings
        if (c == '"') in_string = !in_string;
        if (in_string) continue;
        if (c == '{' || c == '[') ++depth;
        if (c == '}' || c == ']') --depth;
        if (depth > MAX_NESTING) throw Error("is not glTF: its JSON is nested too deeply");
    }
}

// tinygltf trusts the lengths of the chunks of a .glb.
void check_chunks(const std::vector<unsigned char> &bytes) {
    const auto word = [&](size_t at) {
        return bytes[at] | uint64_t{bytes[at + 1]} << 8 | uint64_t{bytes[at + 2]} << 16 |
               uint64_t{bytes[at + 3]} << 24;
    };
    if (bytes.size() < 20) throw Error("is cut short: it ends within its header");
    if (word(4) != 2) throw Error("is not of glTF version 2");
    const uint64_t size = word(8);
    if (size < 20 || size > bytes.size())
        throw Error("is cut short: its header says it has ", size, " bytes");
    for (uint64_t at = 12; at + 8 <= size; at += 8 + word(at))
        if (word(at) > size - at - 8) throw Error("is cut short: a chunk goes beyond its end");
    check_nesting(reinterpret_cast<const char *>(bytes.data()) + 20, word(12));
}

tinygltf::Model load(const std::vector<unsigned char> &bytes, SceneFolder &scene_folder) {
    FileAccess access{scene_folder, {}};
    tinygltf::Model model;
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader(keep_image, nullptr);
    reader.SetFsCallbacks({[](const std::string &, void *) { return true; },
                           [](const std::string &name, void *) { return name; }, read_whole_file,
                           nullptr, &access});
    const std::string folder; // empty: names get no prefix
    std::string error, warning;
    const auto size = static_cast<unsigned>(bytes.size());
    const char *const text = reinterpret_cast<const char *>(bytes.data());
    const bool binary = size >= 4 && std::memcmp(text, "glTF", 4) == 0;
    if (binary)
        check_chunks(bytes);
    else
        check_nesting(text, size);
    bool good = false;
    try {
        good = binary ? reader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), size,
                                                    folder)
                      : reader.LoadASCIIFromString(&model, &error, &warning, text, size, folder);
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &problem) {
        throw Error("is not valid glTF 2.0: ", printable(first_line(problem.what())));
    }
    // Checked first: data that an extension stores elsewhere would be reported as missing.
    for (const std::string &extension : model.extensionsRequired)
        if (!is_known(extension))
            throw Error("requires the extension ", printable(extension), ", which cannot be read");
    if (error.find("File read error") == 0) throw Error("buffer ", access.problem);
    if (!good) throw Error("is not valid glTF 2.0: ", printable(first_line(error)));
    if (model.asset.version.compare(0, 2, "2.") != 0)
        throw Error("is glTF ", printable(model.asset.version), "; version 2 is read");
    return model;
}

// ---- Transformations

using Transform = glm::dmat4x3; // without the last row, which is 0, 0, 0, 1

glm::dmat4 local_transform(const tinygltf::Node &node) {
    const std::vector<double> &r = node.rotation, &scale = node.scale, &by = node.translation;
    if (node.matrix.size() == 16) return glm::dmat4(Transform(glm::make_mat4(node.matrix.data())));
    glm::dmat4 t(1);
    if (r.size() == 4) t = mat4_cast(normalize(glm::dquat(r[3], r[0], r[1], r[2])));
    if (scale.size() == 3) t = glm::scale(t, glm::make_vec3(scale.data()));
    if (by.size() == 3) t[3] = {by[0], by[1], by[2], 1};
    return t;
}

// The unit vector along t * v; zero if that has no direction.
Vec3 direction(const glm::dmat3 &t, glm::dvec3 v) {
    v = t * v;
    const double size = length(v);
    return size > 0 && std::isfinite(size) ? Vec3(v / size) : Vec3(0);
}

// The cofactor matrix transforms normals correctly under any scale. A mirror would flip them, so
// its cofactors are negated.
glm::dmat3 cofactors(const glm::dmat3 &m, bool &mirrors) {
    const glm::dmat3 c(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    mirrors = dot(m[0], c[0]) < 0;
    return mirrors ? -c : c;
}

// ---- Meshes

struct Reader {
    const tinygltf::Model &model;
    SceneDraft &draft;
    std::function<uint32_t(int, bool)> material;
};

// Calls `triangle` with three corner indices below `count`, for each triangle of a primitive mode.
template <typename Function>
void for_each_triangle(int mode, size_t count, const Function &triangle) {
    if (mode == TINYGLTF_MODE_TRIANGLES)
        for (size_t i = 0; i + 2 < count; i += 3) triangle(i, i + 1, i + 2);
    else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
        for (size_t i = 0; i + 2 < count; ++i) triangle(i, i + 1 + i % 2, i + 2 - i % 2);
    else if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
        for (size_t i = 1; i + 1 < count; ++i) triangle(i, i + 1, size_t{0});
}

void read_primitive(Reader &r, const tinygltf::Primitive &primitive, const Transform &transform) {
    SceneDraft &draft = r.draft;
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES &&
        primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        primitive.mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        draft.ignored.insert("points and lines");
        return;
    }
    if (!primitive.targets.empty()) draft.ignored.insert("morph targets");
    const auto attribute = [&](const char *name) {
        const auto found = primitive.attributes.find(name);
        return found == primitive.attributes.end() ? -1 : found->second;
    };
    if (attribute("POSITION") < 0) return; // glTF says to skip it
    const std::vector<float> positions =
        gltf_floats(r.model, attribute("POSITION"), 3, "positions");
    const size_t count = positions.size() / 3;
    const auto optional = [&](const char *name, int components, const char *what) {
        std::vector<float> values;
        if (attribute(name) >= 0) {
            values = gltf_floats(r.model, attribute(name), components, what);
            if (values.size() / static_cast<size_t>(components) != count)
                throw Error("has ", what, " of another count than its positions");
        }
        return values;
    };
    const std::vector<float> normals = optional("NORMAL", 3, "normals");
    const std::vector<float> coordinates[2] = {optional("TEXCOORD_0", 2, "texture coordinates"),
                                               optional("TEXCOORD_1", 2, "texture coordinates")};
    const int colour_components = gltf_components(r.model, attribute("COLOR_0")) == 3 ? 3 : 4;
    const std::vector<float> colours = optional("COLOR_0", colour_components, "vertex colours");

    bool mirrored;
    const glm::dmat3 normal_matrix = cofactors(glm::dmat3(transform), mirrored);
    const auto first = static_cast<uint32_t>(draft.points.size());
    for (size_t i = 0; i < count; ++i) {
        DraftVertex v;
        v.position = transform * glm::dvec4(glm::make_vec3(&positions[3 * i]), 1);
        if (!normals.empty()) v.normal = direction(normal_matrix, glm::make_vec3(&normals[3 * i]));
        for (int set = 0; set < 2; ++set)
            if (!coordinates[set].empty())
                v.coordinates[set] = glm::make_vec2(&coordinates[set][2 * i]);
        if (!colours.empty())
            v.colour = bounded_colour(&colours[static_cast<size_t>(colour_components) * i]);
        draft_add_vertex(draft, v);
    }

    const uint32_t material = r.material(primitive.material, !colours.empty());
    std::vector<uint32_t> indices(count);
    std::iota(indices.begin(), indices.end(), 0u);
    if (primitive.indices >= 0) indices = gltf_indices(r.model, primitive.indices, count);
    for_each_triangle(primitive.mode, indices.size(), [&](size_t a, size_t b, size_t c) {
        if (mirrored) std::swap(b, c);
        draft_add_triangle(draft, material, first + indices[a], first + indices[b],
                           first + indices[c]);
    });
}

// ---- Cameras and lights: both point along their node's -z

void read_camera(Reader &r, int index, const Transform &t, const std::string &node_name) {
    const tinygltf::Camera &camera = gltf_at(r.model.cameras, index, "camera");
    const Vec3 forward = direction(glm::dmat3(t), {0, 0, -1});
    const Vec3 up = direction(glm::dmat3(t), {0, 1, 0});
    const double angle = camera.perspective.yfov;
    if (camera.type != "perspective") {
        r.draft.ignored.insert("orthographic cameras");
    } else if (!(max_magnitude(cross(forward, up)) > 1e-3f) || !(angle > 1e-4 && angle < 3.1)) {
        r.draft.ignored.insert("a camera without direction or angle");
    } else {
        r.draft.cameras.push_back({t[3], forward, up, static_cast<float>(std::tan(0.5 * angle)),
                                   printable(node_name.empty() ? camera.name : node_name)});
    }
}

void read_light(Reader &r, int index, const Transform &t) {
    const tinygltf::Light &source = gltf_at(r.model.lights, index, "light");
    Light light{};
    const std::map<std::string, Light::Kind> kinds = {
        {"point", Light::POINT}, {"spot", Light::SPOT}, {"directional", Light::DIRECTIONAL}};
    const auto kind = kinds.find(source.type);
    light.normal = direction(glm::dmat3(t), {0, 0, -1});
    if (kind == kinds.end() || !is_finite(t[3]) ||
        (kind->second != Light::POINT && !(max_magnitude(light.normal) > 0))) {
        r.draft.ignored.insert("lights of unknown kinds or without a direction");
        return;
    }
    light.kind = kind->second;
    const std::vector<double> &c = source.color;
    const Vec3 colour = c.size() == 3 ? Vec3(c[0], c[1], c[2]) : Vec3(1);
    light.radiance = static_cast<float>(source.intensity) * colour;
    if (!is_finite(light.radiance) || std::min({colour.x, colour.y, colour.z}) < 0)
        throw Error("has a light whose intensity is negative or not a number");
    if (light.kind == Light::SPOT) {
        light.cosine_inner = static_cast<float>(std::cos(source.spot.innerConeAngle));
        light.cosine_outer = static_cast<float>(std::cos(source.spot.outerConeAngle));
    }
    if (source.range > 0) r.draft.ignored.insert("the range of lights");
    r.draft.lights.push_back({light, t[3]});
}

// ---- Nodes

void read_node(Reader &r, const tinygltf::Node &node, const Transform &t) {
    if (node.mesh >= 0)
        for (const tinygltf::Primitive &p : gltf_at(r.model.meshes, node.mesh, "mesh").primitives)
            read_primitive(r, p, t);
    if (node.skin >= 0) r.draft.ignored.insert("skins");
    if (node.camera >= 0) read_camera(r, node.camera, t, node.name);
    const double light = gltf_number(node.extensions, "KHR_lights_punctual", "light", -1);
    if (light >= 0 && light < 1e9) read_light(r, static_cast<int>(light), t);
}

void read_nodes(Reader &r) {
    const tinygltf::Model &model = r.model;
    std::vector<std::pair<int, Transform>> open; // a stack of nodes still to be read
    std::vector<bool> reached(model.nodes.size());
    const auto reach = [&](const std::vector<int> &nodes, const Transform &parent) {
        for (size_t i = nodes.size(); i-- > 0;) {
            gltf_at(model.nodes, nodes[i], "node");
            const auto at = static_cast<size_t>(nodes[i]);
            if (reached[at])
                throw Error("reaches node ", nodes[i], " twice: its nodes do not form a tree");
            reached[at] = true;
            open.push_back({nodes[i], parent});
        }
    };
    if (!model.scenes.empty()) {
        const int chosen = model.defaultScene < 0 ? 0 : model.defaultScene;
        reach(gltf_at(model.scenes, chosen, "scene").nodes, Transform(1));
        if (model.scenes.size() > 1) r.draft.ignored.insert("scenes but the default one");
    } else { // glTF leaves this open: read every node without a parent
        std::set<int> children;
        for (const tinygltf::Node &node : model.nodes)
            for (const int child : node.children) {
                gltf_at(model.nodes, child, "node");
                children.insert(child);
            }
        std::vector<int> roots;
        for (int i = 0; i < static_cast<int>(model.nodes.size()); ++i)
            if (children.count(i) == 0) roots.push_back(i);
        reach(roots, Transform(1));
    }
    while (!open.empty()) {
        const auto [index, parent] = open.back();
        open.pop_back();
        const tinygltf::Node &node = model.nodes[index];
        const Transform transform = parent * local_transform(node);
        read_node(r, node, transform);
        reach(node.children, transform);
    }
}

} // namespace

SceneDraft gltf_read(SceneFolder &folder) {
    const std::vector<unsigned char> bytes = folder.read_scene();
    const tinygltf::Model model = load(bytes, folder);
    SceneDraft draft;
    for (const std::string &extension : model.extensionsUsed)
        if (!is_known(extension)) draft.ignored.insert("the extension " + printable(extension));
    if (!model.animations.empty()) draft.ignored.insert("animations");
    Reader reader = {model, draft, gltf_material_reader(model, folder, draft)};
    read_nodes(reader);
    return draft;
}
