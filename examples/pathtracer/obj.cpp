// SPDX-License-Identifier: Apache-2.0
// Reads Wavefront OBJ and MTL. The original parameters predate physically based shading: diffuse
// and specular colours with an exponent become a coated base, or metal if nothing is diffuse;
// transparent materials become glass. The newer Pr and Pm are used as they are.
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <sstream>

#include "error.h"
#include "scene_file.h"

namespace {

constexpr unsigned MAX_CORNERS = 1024; // of a polygon triangulated here

// Converts a name in the scene to a local one. Windows programs write backslashes, quotes and
// absolute paths on their own drives, of which only the last part is kept.
std::string local_name(std::string name) {
    if (name.size() >= 2 && name.front() == '"' && name.back() == '"')
        name = name.substr(1, name.size() - 2);
    std::replace(name.begin(), name.end(), '\\', '/');
    const bool on_a_disk = name.size() >= 3 && name[1] == ':' && name[2] == '/';
    return on_a_disk ? name.substr(name.rfind('/') + 1) : name;
}

// The loader drops the backslashes in `mtllib` lines, except those that escape a space: turn the
// others into slashes.
void mend_backslashes(std::string &content) {
    size_t at = 0;
    while (at < content.size()) {
        const size_t end = std::min(content.find('\n', at), content.size());
        at = std::min(content.find_first_not_of(" \t", at), end);
        if (content.compare(at, 6, "mtllib") == 0)
            for (; at + 1 < end; ++at)
                if (content[at] == '\\' && content[at + 1] != ' ') content[at] = '/';
        at = end + 1;
    }
}

// Reads each material file once. Missing files are noted as ignored; other errors are kept for
// finish(), as no exception should pass through the loader. The answer is never true, because the
// loader would then skip the other files of the line.
class MaterialFiles : public tinyobj::MaterialReader {
  public:
    MaterialFiles(SceneFolder &folder, std::set<std::string> &ignored)
        : folder_(folder), ignored_(ignored) {}
    bool operator()(const std::string &name, std::vector<tinyobj::material_t> *materials,
                    std::map<std::string, int> *numbers, std::string *warning,
                    std::string *error) override {
        try {
            if (!known_.insert(folder_.resolve(local_name(name))).second) return false;
            const auto bytes = folder_.find(local_name(name));
            if (bytes) {
                std::istringstream file(std::string(bytes->begin(), bytes->end()));
                tinyobj::LoadMtl(numbers, materials, &file, warning, error);
            } else {
                ignored_.insert("the missing material file " + printable(name));
            }
        } catch (const Error &problem) {
            problem_ = "material file " + printable(name) + ": " + problem.what();
        }
        return false;
    }

    // Throws the error that was kept, if any. Call it once the file is loaded.
    void finish() {
        if (!problem_.empty()) throw Error(problem_);
        known_.clear();
    }

  private:
    SceneFolder &folder_;
    std::set<std::string> &ignored_;
    std::set<std::filesystem::path> known_;
    std::string problem_;
};

// Converts the file's materials to the scene's.
struct MaterialReader {
    SceneDraft &draft;
    SceneFolder &folder;
    bool vertex_colours; // the file has vertex colours
    std::map<std::pair<std::string, bool>, int32_t> textures;

    TextureUse texture(const std::string &name, const tinyobj::texture_option_t &options,
                       bool srgb) {
        TextureUse use;
        if (name.empty()) return use;
        const auto [known, is_new] = textures.try_emplace({name, srgb}, -1);
        if (is_new) {
            known->second = draft_add_texture(draft, "image " + printable(name), srgb,
                                              [&] { return folder.read(local_name(name)); });
            Texture &loaded = draft.scene.textures.back();
            if (options.clamp) loaded.wrap_u = loaded.wrap_v = Texture::CLAMP;
        }
        use.texture = known->second;
        // OBJ's v points up.
        const auto &size = options.scale, &by = options.origin_offset;
        use.transform = glm::mat3x2(size[0], 0, 0, -size[1], by[0], 1 - by[1]);
        return use;
    }

    uint32_t material(const tinyobj::material_t &source) {
        Material m;
        SurfaceMaps maps;
        maps.vertex_colours = vertex_colours;
        const Vec3 diffuse = bounded_colour(source.diffuse);
        const Vec3 specular = bounded_colour(source.specular);
        const Vec3 passed = bounded_colour(source.transmittance);
        // The roughness whose lobe is as wide as that of the Blinn-Phong exponent.
        const double exponent = source.shininess > 0 ? source.shininess : 0;
        m.roughness = bounded(std::sqrt(std::sqrt(2 / (exponent + 2))));
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
            m.roughness = has_pbr ? bounded(source.roughness) : 0;
        } else if (has_pbr) {
            m.kind = Material::METALLIC_ROUGHNESS;
            m.roughness = source.roughness > 0 ? bounded(source.roughness) : 1.0f;
            m.metallic = source.metallic > 0               ? bounded(source.metallic)
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
        emission.radiance = bounded_colour(source.emission, 1e9);
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

// Checks an index of the file against the length of its array.
size_t checked(int index, size_t count, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= count)
        throw Error("has an index out of range: ", what, " ", static_cast<int64_t>(index) + 1,
                    " of ", count);
    return static_cast<size_t>(index);
}

// ---- Parsing

struct ObjFile {
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning;
};

// With `split`, the loader triangulates polygons.
ObjFile load(const std::string &content, MaterialFiles &material_files, bool split) {
    ObjFile file;
    std::istringstream text(content);
    std::string error;
    const bool good = tinyobj::LoadObj(&file.attributes, &file.shapes, &file.materials,
                                       &file.warning, &error, &text, &material_files, split, false);
    material_files.finish();
    if (!good) throw Error("is not valid OBJ: ", printable(error.substr(0, error.find('\n'))));
    // The loader may drop faces with such indices.
    if (file.warning.find("ndices out of bounds") != std::string::npos ||
        file.warning.find("invalid vertex index") != std::string::npos)
        throw Error("has an index out of range");
    return file;
}

// Whether all polygons can be triangulated here: some versions of the loader store a polygon's
// corner count in 8 bits, and very many corners take too long.
bool are_small(const ObjFile &file) {
    size_t corners = 0, largest = 0, stored = 0;
    for (const tinyobj::shape_t &shape : file.shapes) {
        for (const size_t count : shape.mesh.num_face_vertices)
            corners += count, largest = std::max(largest, count);
        stored += shape.mesh.indices.size();
    }
    return corners == stored && largest <= MAX_CORNERS;
}

void note_ignored(const ObjFile &file, SceneDraft &draft) {
    if (file.warning.find("not found in .mtl") != std::string::npos && !file.materials.empty())
        draft.ignored.insert("the names of materials that no material file has");
    bool smooth_groups = false, points_and_lines = false;
    for (const tinyobj::shape_t &shape : file.shapes) {
        for (const unsigned group : shape.mesh.smoothing_group_ids)
            smooth_groups = smooth_groups || group != 0;
        points_and_lines =
            points_and_lines || !shape.lines.indices.empty() || !shape.points.indices.empty();
    }
    if (smooth_groups && file.attributes.normals.empty())
        draft.ignored.insert("smoothing groups (without normals faces are flat)");
    if (points_and_lines) draft.ignored.insert("points and lines");
}

// ---- Polygons, as the loader gets concave ones wrong: ear clipping (Meisters, "Polygons Have Ears",
// 1975). Corners whose triangle lies inside the polygon and contains no other corner are cut off until
// one triangle is left. The polygon is projected along the axis nearest to its normal, which Newell's
// method gives.

using Point2d = glm::dvec2;

// Twice the signed area of a triangle, positive if it is counter-clockwise.
double turn(Point2d a, Point2d b, Point2d c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Projects the polygon so that it is counter-clockwise.
std::vector<Point2d> flattened(const std::vector<Point3d> &corners) {
    Point3d n(0);
    const Point3d o = corners[0];
    for (size_t i = 0; i < corners.size(); ++i)
        n += cross(corners[i] - o, corners[(i + 1) % corners.size()] - o);
    int axis = std::abs(n.x) > std::abs(n.y) ? 0 : 1;
    if (std::abs(n.z) > std::abs(n[axis])) axis = 2;
    const double side = n[axis] < 0 ? -1 : 1;
    std::vector<Point2d> result;
    for (const Point3d p : corners) {
        const Point3d v = p - o;
        result.push_back({v[(axis + 1) % 3], side * v[(axis + 2) % 3]});
    }
    return result;
}

// Splits a polygon without holes into n - 2 triangles with the same orientation, each given by three
// corner indices. It may be concave and not quite flat. For a degenerate or self-intersecting polygon,
// the triangles are valid but their area is unspecified. Takes up to n^3 steps.
std::vector<std::array<size_t, 3>> polygon_triangles(const std::vector<Point3d> &corners) {
    std::vector<std::array<size_t, 3>> triangles;
    if (corners.size() < 3) return triangles;
    if (corners.size() == 3) return {{0, 1, 2}};
    const std::vector<Point2d> points = flattened(corners);
    std::vector<size_t> left(corners.size());
    for (size_t i = 0; i < left.size(); ++i) left[i] = i;
    const auto neighbours = [&](size_t i) {
        const size_t n = left.size();
        return std::array<size_t, 3>{left[(i + n - 1) % n], left[i], left[(i + 1) % n]};
    };
    const auto is_ear = [&](const std::array<size_t, 3> &t) {
        const Point2d a = points[t[0]], b = points[t[1]], c = points[t[2]];
        if (!(turn(a, b, c) > 0)) return false;
        for (const size_t i : left) {
            const Point2d p = points[i];
            // Coincident corners, as on a bridge to a hole and back, are not inside.
            if (p == a || p == b || p == c) continue;
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    };
    while (left.size() > 3) {
        // Only an invalid polygon has no ear: cutting off the smallest triangle does least harm.
        size_t ear = 0;
        double least = std::numeric_limits<double>::infinity();
        for (size_t i = 0; i < left.size() && least >= 0; ++i) {
            const std::array<size_t, 3> t = neighbours(i);
            const double area = std::abs(turn(points[t[0]], points[t[1]], points[t[2]]));
            if (const double rank = is_ear(t) ? -1 : area; rank < least) least = rank, ear = i;
        }
        triangles.push_back(neighbours(ear));
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({left[0], left[1], left[2]});
    return triangles;
}

// ---- Vertices and faces

DraftVertex vertex_of(const tinyobj::attrib_t &a, const tinyobj::index_t &index) {
    DraftVertex v;
    const size_t p = 3 * checked(index.vertex_index, a.vertices.size() / 3, "vertex");
    v.position = {a.vertices[p], a.vertices[p + 1], a.vertices[p + 2]};
    if (p + 2 < a.colors.size()) v.colour = bounded_colour(&a.colors[p]);
    if (index.normal_index >= 0) {
        const size_t n = 3 * checked(index.normal_index, a.normals.size() / 3, "normal");
        v.normal = {a.normals[n], a.normals[n + 1], a.normals[n + 2]};
    }
    if (index.texcoord_index >= 0) {
        const size_t t =
            2 * checked(index.texcoord_index, a.texcoords.size() / 2, "texture coordinate");
        v.coordinates[0] = {a.texcoords[t], a.texcoords[t + 1]};
    }
    return v;
}

// Calls material(number in the file, or -1) for each face, and vertex(index) for each of its corners.
template <typename MaterialOf, typename VertexOf>
void add_faces(const tinyobj::mesh_t &mesh, MaterialOf material_of, VertexOf vertex,
               SceneDraft &draft) {
    size_t first = 0;
    for (size_t face = 0; face < mesh.num_face_vertices.size(); ++face) {
        const size_t count = mesh.num_face_vertices[face];
        if (first + count > mesh.indices.size()) throw Error("has invalid faces");
        const uint32_t material =
            material_of(face < mesh.material_ids.size() ? mesh.material_ids[face] : -1);
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

} // namespace

SceneDraft obj_read(SceneFolder &folder) {
    SceneDraft draft;
    const std::vector<unsigned char> bytes = folder.read_scene();
    std::string content(bytes.begin(), bytes.end());
    mend_backslashes(content);
    MaterialFiles material_files(folder, draft.ignored);
    ObjFile file = load(content, material_files, false);
    if (!are_small(file)) {
        file = load(content, material_files, true);
        draft.ignored.insert("that polygons of more than 255 corners may be concave");
    }
    note_ignored(file, draft);

    MaterialReader reader{draft, folder, !file.attributes.colors.empty(), {}};
    std::vector<uint32_t> materials;
    for (const tinyobj::material_t &source : file.materials)
        materials.push_back(reader.material(source));
    std::optional<uint32_t> standard; // of faces without one: grey, made on first use
    const auto material_of = [&](int number) {
        if (number >= 0) return materials[checked(number, materials.size(), "material")];
        if (!standard) {
            Material grey;
            grey.albedo = Vec3(0.6f);
            SurfaceMaps maps;
            maps.vertex_colours = reader.vertex_colours;
            standard = draft_add_material(draft, grey, {}, maps);
        }
        return *standard;
    };
    // Corners with the same indices become one vertex.
    std::map<std::array<int, 3>, uint32_t> vertices;
    const auto vertex = [&](const tinyobj::index_t &i) {
        const auto [known, is_new] =
            vertices.try_emplace({i.vertex_index, i.normal_index, i.texcoord_index}, 0);
        if (is_new) known->second = draft_add_vertex(draft, vertex_of(file.attributes, i));
        return known->second;
    };
    for (const tinyobj::shape_t &shape : file.shapes)
        add_faces(shape.mesh, material_of, vertex, draft);
    return draft;
}
