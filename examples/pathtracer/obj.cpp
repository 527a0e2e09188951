// SPDX-License-Identifier: Apache-2.0
// Reading Wavefront OBJ and MTL. The old parameters are those of another age: diffuse and specular
// colours with an exponent become a ground under a coat, or metal where nothing is diffuse; what is
// transparent becomes glass. The newer Pr and Pm are taken as they are.
#include <tiny_obj_loader.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "error.h"
#include "polygon.h"
#include "scene_file.h"

namespace {

constexpr unsigned MAX_CORNERS = 1024; // of a polygon that is split here

// Reads material files beside the OBJ; one that is missing is noted.
class Materials : public tinyobj::MaterialReader {
  public:
    Materials(std::filesystem::path folder, std::set<std::string> &ignored)
        : folder_(std::move(folder)), ignored_(ignored) {}
    bool operator()(const std::string &name, std::vector<tinyobj::material_t> *materials,
                    std::map<std::string, int> *numbers, std::string *warning,
                    std::string *error) override {
        std::ifstream file(folder_ / name);
        if (!file) {
            ignored_.insert("the missing material file " + name);
            return false;
        }
        tinyobj::LoadMtl(numbers, materials, &file, warning, error);
        return true;
    }

  private:
    std::filesystem::path folder_;
    std::set<std::string> &ignored_;
};

Vec3 colour(const tinyobj::real_t (&c)[3], double high) {
    const auto one = [&](double v) {
        return std::isfinite(v) ? static_cast<float>(std::min(std::max(v, 0.0), high)) : 0.0f;
    };
    return {one(c[0]), one(c[1]), one(c[2])};
}

float unit(double v) {
    return v > 0 ? static_cast<float>(std::min(v, 1.0)) : 0.0f;
}

struct Reader {
    SceneDraft &draft;
    std::filesystem::path folder;
    std::map<std::pair<std::string, bool>, int32_t> textures;

    TextureUse texture(const std::string &name, const tinyobj::texture_option_t &options,
                       bool srgb) {
        TextureUse use;
        if (name.empty()) return use;
        const auto [known, is_new] = textures.try_emplace({name, srgb}, -1);
        if (is_new) {
            std::string file = name;
            for (char &c : file)
                if (c == '\\') c = '/';
            Texture loaded;
            try {
                loaded = texture_decode(read_file((folder / file).string()));
            } catch (const Error &error) {
                throw Error("image " + name + ": " + error.what());
            }
            loaded.srgb = srgb;
            if (options.clamp) loaded.wrap_u = loaded.wrap_v = Texture::CLAMP;
            known->second = static_cast<int32_t>(draft.scene.textures.size());
            draft.scene.textures.push_back(std::move(loaded));
        }
        use.texture = known->second;
        // Its v grows upwards.
        const auto f = [](double v) { return static_cast<float>(v); };
        const float rows[2][3] = {{f(options.scale[0]), 0, f(options.origin_offset[0])},
                                  {0, -f(options.scale[1]), 1 - f(options.origin_offset[1])}};
        std::copy(&rows[0][0], &rows[0][0] + 6, &use.transform[0][0]);
        return use;
    }

    uint32_t material(const tinyobj::material_t &source, bool vertex_colours) {
        Material m;
        SurfaceMaps maps;
        maps.vertex_colours = vertex_colours;
        const Vec3 diffuse = colour(source.diffuse, 1), specular = colour(source.specular, 1);
        const Vec3 passed = colour(source.transmittance, 1);
        // An exponent of Blinn and Phong as a roughness of the same width.
        const double exponent = source.shininess > 0 ? source.shininess : 0;
        m.roughness = unit(std::sqrt(std::sqrt(2 / (exponent + 2))));
        m.albedo = diffuse;
        const bool has_pbr = source.roughness > 0 || source.metallic > 0 ||
                             !source.roughness_texname.empty() || !source.metallic_texname.empty();
        const bool refracts = source.illum == 4 || source.illum == 6 || source.illum == 7 ||
                              source.illum == 9 ||
                              (source.dissolve < 0.5 && source.alpha_texname.empty());
        if (refracts) {
            m.kind = Material::DIELECTRIC;
            m.ior = source.ior > 1 ? static_cast<float>(std::min(source.ior, 10.0)) : 1.5f;
            m.albedo = max_component(passed) > 0 ? passed : Vec3{1, 1, 1};
            m.roughness = has_pbr ? unit(source.roughness) : 0;
        } else if (has_pbr) {
            m.kind = Material::METALLIC_ROUGHNESS;
            m.roughness = source.roughness > 0 ? unit(source.roughness) : 1.0f;
            m.metallic = source.metallic > 0               ? unit(source.metallic)
                         : source.metallic_texname.empty() ? 0.0f
                                                           : 1.0f;
            maps.roughness = texture(source.roughness_texname, source.roughness_texopt, false);
            maps.metallic = texture(source.metallic_texname, source.metallic_texopt, false);
        } else if (source.illum >= 2 && max_component(specular) > 0) {
            const bool metal = max_component(diffuse) < 0.01f && source.diffuse_texname.empty();
            m.kind = metal ? Material::CONDUCTOR : Material::METALLIC_ROUGHNESS;
            if (metal) m.albedo = specular;
        }
        if (!refracts) maps.colour = texture(source.diffuse_texname, source.diffuse_texopt, true);
        maps.normal = texture(source.normal_texname, source.normal_texopt, false);
        maps.cut_out = texture(source.alpha_texname, source.alpha_texopt, false);
        if (maps.cut_out.texture >= 0) maps.alpha_cutoff = 0.5f;

        Emission emission;
        emission.radiance = colour(source.emission, 1e9);
        if (max_component(emission.radiance) > 0)
            maps.emission = texture(source.emissive_texname, source.emissive_texopt, true);
        maps.emission_factor = emission.radiance;

        if (!source.bump_texname.empty() || !source.displacement_texname.empty())
            draft.ignored.insert("bump and displacement maps");
        if (!source.specular_texname.empty() || !source.specular_highlight_texname.empty())
            draft.ignored.insert("maps of specular colours and exponents");
        if (source.sheen > 0 || source.clearcoat_thickness > 0)
            draft.ignored.insert("sheen and clearcoat");
        if (source.dissolve < 1 && !refracts)
            draft.ignored.insert("partial transparency (what covers less than half is glass)");
        return draft_add_material(draft, m, emission, maps);
    }
};

// An element of an array that an index of the file points at.
size_t checked(int index, size_t count, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= count)
        throw Error("has an index out of range: " + std::string(what) + " " +
                    std::to_string(static_cast<int64_t>(index) + 1) + " of " +
                    std::to_string(count));
    return static_cast<size_t>(index);
}

} // namespace

SceneDraft obj_read(const std::string &path) {
    SceneDraft draft;
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    const std::vector<unsigned char> bytes = read_file(path);
    const std::string content(bytes.begin(), bytes.end());
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> sources;
    std::string warning;
    Materials material_files(folder, draft.ignored);
    const auto load = [&](bool split) {
        std::istringstream text(content);
        std::string error;
        attributes = {}, shapes.clear(), sources.clear(), warning.clear();
        if (!tinyobj::LoadObj(&attributes, &shapes, &sources, &warning, &error, &text,
                              &material_files, split, false))
            throw Error("is no OBJ: " + error.substr(0, error.find('\n')));
    };
    // Polygons are split here, as the loader does not get concave ones right. Those of very many
    // corners, of which some of its versions lose count, are left to it.
    load(false);
    bool all_counted = true;
    for (const tinyobj::shape_t &shape : shapes) {
        size_t corners = 0;
        for (const size_t count : shape.mesh.num_face_vertices) { // of 8 bits in some versions
            corners += count;
            all_counted = all_counted && count <= MAX_CORNERS;
        }
        all_counted = all_counted && corners == shape.mesh.indices.size();
    }
    if (!all_counted) {
        load(true);
        draft.ignored.insert("that polygons of more than 255 corners may be concave");
    }
    // Faces with such indices may be left out by the loader.
    if (warning.find("ndices out of bounds") != std::string::npos ||
        warning.find("invalid vertex index") != std::string::npos)
        throw Error("has an index out of range");
    if (warning.find("not found in .mtl") != std::string::npos && !sources.empty())
        draft.ignored.insert("the names of materials that no material file has");

    bool smooth_groups = false;
    for (const tinyobj::shape_t &shape : shapes)
        for (const unsigned group : shape.mesh.smoothing_group_ids)
            smooth_groups = smooth_groups || group != 0;
    if (smooth_groups && attributes.normals.empty())
        draft.ignored.insert("smoothing groups (without normals faces are flat)");

    const bool vertex_colours = !attributes.colors.empty();
    Reader reader{draft, folder, {}};
    std::vector<uint32_t> materials;
    for (const tinyobj::material_t &source : sources)
        materials.push_back(reader.material(source, vertex_colours));
    tinyobj::material_t standard{};
    for (double &c : standard.diffuse) c = 0.6;
    standard.dissolve = 1;
    int64_t standard_material = -1;

    // Corners that have everything in common are one vertex.
    std::map<std::array<int, 3>, uint32_t> vertices;
    const auto vertex = [&](const tinyobj::index_t &index) {
        const auto [known, is_new] =
            vertices.try_emplace({index.vertex_index, index.normal_index, index.texcoord_index}, 0);
        if (!is_new) return known->second;
        DraftVertex v;
        const size_t p = checked(index.vertex_index, attributes.vertices.size() / 3, "vertex");
        v.position = {attributes.vertices[3 * p], attributes.vertices[3 * p + 1],
                      attributes.vertices[3 * p + 2]};
        if (vertex_colours && 3 * p + 2 < attributes.colors.size())
            v.colour = {unit(attributes.colors[3 * p]), unit(attributes.colors[3 * p + 1]),
                        unit(attributes.colors[3 * p + 2])};
        if (index.normal_index >= 0) {
            const size_t n = checked(index.normal_index, attributes.normals.size() / 3, "normal");
            v.normal = {static_cast<float>(attributes.normals[3 * n]),
                        static_cast<float>(attributes.normals[3 * n + 1]),
                        static_cast<float>(attributes.normals[3 * n + 2])};
        }
        if (index.texcoord_index >= 0) {
            const size_t t = checked(index.texcoord_index, attributes.texcoords.size() / 2,
                                     "texture coordinate");
            v.coordinates[0] = {static_cast<float>(attributes.texcoords[2 * t]),
                                static_cast<float>(attributes.texcoords[2 * t + 1])};
        }
        return known->second = draft_add_vertex(draft, v);
    };
    for (const tinyobj::shape_t &shape : shapes) {
        if (!shape.lines.indices.empty() || !shape.points.indices.empty())
            draft.ignored.insert("points and lines");
        const tinyobj::mesh_t &mesh = shape.mesh;
        size_t first = 0;
        for (size_t face = 0; face < mesh.num_face_vertices.size(); ++face) {
            const size_t count = mesh.num_face_vertices[face];
            if (first + count > mesh.indices.size()) throw Error("has faces that cannot be");
            const int number = face < mesh.material_ids.size() ? mesh.material_ids[face] : -1;
            uint32_t material;
            if (number >= 0) {
                material = materials[checked(number, materials.size(), "material")];
            } else {
                if (standard_material < 0)
                    standard_material = reader.material(standard, vertex_colours);
                material = static_cast<uint32_t>(standard_material);
            }
            std::vector<uint32_t> corners;
            std::vector<Point3d> places;
            for (size_t i = first; i < first + count; ++i) {
                corners.push_back(vertex(mesh.indices[i]));
                places.push_back(draft.points[corners.back()]);
            }
            for (const std::array<size_t, 3> &t : polygon_triangles(places))
                draft_add_triangle(draft, material, corners[t[0]], corners[t[1]], corners[t[2]]);
            first += count;
        }
    }
    return draft;
}
