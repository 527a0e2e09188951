// SPDX-License-Identifier: Apache-2.0
// Reads glTF 2.0 into a scene. JSON for Modern C++ parses the text. Every index, offset and size is
// checked here before it is used, and --max-memory limits memory. Transforms are composed and
// applied in double precision, and the scene is moved to the origin, so that distant geometry keeps
// its precision. Nodes are visited iteratively; reaching a node twice is an error.
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "files.h"
#include "scene.h"

namespace {

using Json = nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr size_t MAX_ELEMENTS = size_t{1} << 26; // vertices, or elements of an array
constexpr float LUMENS_PER_WATT = 683;           // at 555 nm; glTF exporters use it for all light
constexpr float MAX_GLOW = 1;                    // radiance
constexpr double MAX_COORDINATE = 1e15;          // doubles resolve an eighth there
// The largest distance from the scene's centre. Products of three lengths, and areas, still fit in
// a float, so images are right; a hundred times as far, Embree ends the program.
constexpr float MAX_REACH = 1e10f;

// ---- JSON: what is missing, or of another type, has a default

const Json &member(const Json &of, const char *name) {
    static const Json none;
    const auto found = of.is_object() ? of.find(name) : of.end();
    return found == of.end() ? none : *found;
}

double number(const Json &of, const char *name, double otherwise) {
    const Json &value = member(of, name);
    return value.is_number() ? value.get<double>() : otherwise;
}

std::string text(const Json &of, const char *name) {
    const Json &value = member(of, name);
    return value.is_string() ? value.get<std::string>() : "";
}

// Exactly `count` numbers; empty otherwise.
std::vector<double> numbers(const Json &of, const char *name, size_t count) {
    std::vector<double> values;
    for (const Json &value : member(of, name))
        if (value.is_number()) values.push_back(value.get<double>());
    return values.size() == count ? values : std::vector<double>{};
}

// An index into a list of the file, -1 if there is none.
int64_t index(const Json &of, const char *name) {
    const double value = number(of, name, -1);
    return value >= 0 && value < 4e9 ? int64_t(value) : -1;
}

// A size or an offset.
size_t size_in(const Json &of, const char *name) {
    const double value = number(of, name, 0);
    if (!(value >= 0 && value < 1e18)) throw Error("has an impossible ", name);
    return size_t(value);
}

bool flag(const Json &of, const char *name) {
    const Json &value = member(of, name);
    return value.is_boolean() && value.get<bool>();
}

const Json &extension(const Json &of, const char *name) {
    return member(member(of, "extensions"), name);
}

// A number of a file, clamped; what is not a number becomes `low`.
float bounded(double value, double low = 0, double high = 1) {
    return float(value > low ? std::min(value, high) : low);
}

Vec3 colour(const std::vector<double> &c, double high = 1) {
    if (c.size() < 3) return Vec3(1);
    return {bounded(c[0], 0, high), bounded(c[1], 0, high), bounded(c[2], 0, high)};
}

// ---- The file

Bytes base64_decoded(const std::string &text, size_t from) {
    static const std::string digits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    Bytes bytes;
    uint32_t bits = 0, count = 0;
    for (size_t i = from; i < text.size() && text[i] != '='; ++i) {
        const size_t digit = digits.find(text[i]);
        if (digit == std::string::npos) throw Error("is not valid base64");
        bits = bits << 6 | uint32_t(digit);
        if (++count % 4 != 1)
            bytes.push_back(static_cast<unsigned char>(bits >> (6 - 2 * ((count - 1) % 4))));
    }
    return bytes;
}

// The file name that a percent-encoded URI stands for. A plus stands for itself.
std::string percent_decoded(const std::string &uri) {
    std::string name;
    for (size_t i = 0; i < uri.size(); ++i) {
        unsigned byte = 0;
        const char *const digits = uri.data() + i + 1;
        const bool escape = uri[i] == '%' && i + 2 < uri.size() &&
                            std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
        name += escape ? static_cast<char>(byte) : uri[i];
        if (escape) i += 2;
    }
    return name;
}

// Whether a URI holds data. Schemes have no case.
bool holds_data(const std::string &uri) {
    std::string scheme = uri.substr(std::min(uri.find_first_not_of(' '), uri.size()), 5);
    for (char &c : scheme) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return scheme == "data:";
}

// Names a buffer or an image in messages.
std::string name_of(const char *what, const Json &source, int64_t number) {
    const std::string uri = text(source, "uri"), name = text(source, "name");
    if (!uri.empty() && !holds_data(uri)) return joined(what, " ", printable(percent_decoded(uri)));
    return joined(what, " ", number, name.empty() ? "" : " ", printable(name));
}

struct Span {
    const unsigned char *data;
    size_t size, stride; // stride 0: packed
};

// What the reader supports, or reports itself where a texture or a material uses it.
const std::set<std::string> KNOWN = {
    "KHR_lights_punctual", "KHR_texture_transform", "KHR_mesh_quantization", "EXT_texture_webp",
    "EXT_texture_avif",    "KHR_texture_basisu",    "MSFT_texture_dds"};
const std::set<std::string> KNOWN_MATERIALS = {"KHR_materials_ior", "KHR_materials_transmission",
                                               "KHR_materials_specular",
                                               "KHR_materials_emissive_strength"};

bool is_known(const std::string &name) {
    return KNOWN.count(name) > 0 || name.compare(0, 14, "KHR_materials_") == 0;
}

struct File {
    SceneFolder &folder;
    Bytes bytes; // of the scene file
    Json json = {};
    Span chunk = {};                       // the binary chunk of a .glb
    std::map<int64_t, Bytes> buffers = {}; // those that were read

    explicit File(SceneFolder &scene_folder) : folder(scene_folder), bytes(folder.read_scene()) {
        Span all = {bytes.data(), bytes.size(), 0};
        if (all.size >= 4 && std::memcmp(all.data, "glTF", 4) == 0) all = glb_text();
        json = Json::parse(all.data, all.data + all.size);
        const Json &asset = member(json, "asset");
        const std::string version = text(asset, "version"), least = text(asset, "minVersion");
        if (version.compare(0, 2, "2.") != 0 || (!least.empty() && least != "2.0"))
            throw Error("is glTF ", printable(least.empty() ? version : least),
                        "; version 2.0 is read");
        for (const Json &required : member(json, "extensionsRequired"))
            if (required.is_string() && !is_known(required))
                throw Error("requires the extension ", printable(required),
                            ", which cannot be read");
    }

    // The JSON of a .glb.
    Span glb_text() {
        const auto word = [&](size_t at) {
            return bytes[at] | size_t{bytes[at + 1]} << 8 | size_t{bytes[at + 2]} << 16 |
                   size_t{bytes[at + 3]} << 24;
        };
        if (bytes.size() < 20) throw Error("is cut short: it ends within its header");
        if (word(4) != 2) throw Error("is not of glTF version 2");
        const size_t size = word(8);
        if (size < 20 || size > bytes.size())
            throw Error("is cut short: its header says it has ", size, " bytes");
        std::vector<Span> chunks;
        for (size_t at = 12; at + 8 <= size; at += 8 + chunks.back().size) {
            if (word(at) > size - at - 8) throw Error("is cut short: a chunk goes beyond its end");
            chunks.push_back({bytes.data() + at + 8, word(at), word(at + 4)});
        }
        for (const Span &c : chunks)
            if (c.stride == 0x004e4942 && !chunk.data) chunk = c; // "BIN"
        return chunks[0];
    }

    // An element of a list of the file. Throws Error if the index is out of range.
    const Json &at(const char *list, int64_t index, const char *what) const {
        return element(member(json, list), index, what);
    }
    static const Json &element(const Json &elements, int64_t index, const char *what) {
        const size_t count = elements.is_array() ? elements.size() : 0;
        if (index < 0 || size_t(index) >= count)
            throw Error("refers to ", what, " ", index, ", and has ", count);
        return elements[size_t(index)];
    }

    // The bytes that a URI holds, or of the file that it names.
    Bytes resource(const std::string &uri) const {
        if (!holds_data(uri)) return folder.read(percent_decoded(uri));
        const size_t comma = uri.find(";base64,");
        if (comma == std::string::npos) throw Error("is not base64");
        return base64_decoded(uri, comma + 8);
    }

    Span buffer(int64_t number) {
        const Json &source = at("buffers", number, "buffer");
        const std::string uri = text(source, "uri"), name = name_of("buffer", source, number);
        Span found = chunk;
        if (!uri.empty()) {
            const auto [known, is_new] = buffers.try_emplace(number);
            try {
                if (is_new) known->second = resource(uri);
            } catch (const Error &problem) {
                throw Error(name, ": ", problem.what());
            }
            found = {known->second.data(), known->second.size(), 0};
        }
        const size_t wanted = size_in(source, "byteLength");
        if (found.size < wanted)
            throw Error("is cut short: ", name, " has ", found.size, " bytes of ", wanted);
        return {found.data, wanted, 0};
    }

    Span view(int64_t number, const char *what) {
        const Json &source = at("bufferViews", number, "buffer view");
        const Span whole = buffer(index(source, "buffer"));
        const size_t offset = size_in(source, "byteOffset"), size = size_in(source, "byteLength");
        if (offset > whole.size || size > whole.size - offset)
            throw Error("is cut short: the buffer view of ", what,
                        " runs past the end of its buffer");
        return {whole.data + offset, size, size_in(source, "byteStride")};
    }
};

// ---- Arrays, as vectors of four numbers: those that an element lacks are 0, but the last is 1

using Elements = std::vector<glm::dvec4>;

size_t size_of_type(int64_t type, const char *what) {
    if (type < 5120 || type > 5126 || type == 5124)
        throw Error(what, " have a number type that glTF does not have");
    return type < 5122 ? 1 : type < 5125 ? 2 : 4;
}

// A number of a component type; normalized integers become [0, 1] or [-1, 1].
double decoded(const unsigned char *at, int64_t type, bool normalized) {
    const auto read = [&](auto number) {
        std::memcpy(&number, at, sizeof number);
        const double limit = normalized ? std::numeric_limits<decltype(number)>::max() : 1;
        return std::max(double(number) / limit, normalized ? -1 : -HUGE_VAL);
    };
    if (type == 5120) return read(int8_t{});
    if (type == 5121) return read(uint8_t{});
    if (type == 5122) return read(int16_t{});
    if (type == 5123) return read(uint16_t{});
    if (type == 5125) return read(uint32_t{});
    float value;
    std::memcpy(&value, at, sizeof value);
    return double(value);
}

// Stores `count` elements of a buffer view, at the places given if there are any.
void copy_elements(File &file, const Json &source, int64_t type, bool normalized, int width,
                   size_t count, const char *what, Elements &to, const Elements *places = nullptr) {
    const Span from = file.view(index(source, "bufferView"), what);
    const size_t offset = size_in(source, "byteOffset"), each = size_of_type(type, what),
                 size = each * size_t(width), stride = from.stride == 0 ? size : from.stride;
    if (stride < size) throw Error(what, " overlap each other in their buffer");
    if (count > 0 && (offset > from.size || size > from.size - offset ||
                      (count - 1) > (from.size - offset - size) / stride))
        throw Error(what, " run past the end of their buffer view");
    for (size_t i = 0; i < count; ++i) {
        const size_t place = places ? size_t((*places)[i].x) : i;
        if (place >= to.size())
            throw Error("has an index out of range: ", place, " of ", to.size());
        for (int c = 0; c < width; ++c)
            to[place][c] =
                decoded(from.data + offset + i * stride + size_t(c) * each, type, normalized);
    }
}

// The elements of an accessor of one of these types. Indices are unsigned integers in the file.
Elements elements(File &file, int64_t number, const std::set<std::string> &types,
                  const char *what) {
    const auto check_indices = [&](int64_t type) {
        if (type != 5121 && type != 5123 && type != 5125)
            throw Error("has ", what, " that are not unsigned integers");
        return type;
    };
    const Json &accessor = file.at("accessors", number, "accessor");
    const size_t count = size_in(accessor, "count");
    if (count > MAX_ELEMENTS) throw Error("has ", count, " ", what, "; at most 2^26 are read");
    const std::string kind = text(accessor, "type");
    if (types.count(kind) == 0) throw Error(what, " have the wrong number of components");
    const int width = kind == "SCALAR" ? 1 : kind[3] - '0';
    const int64_t type = index(accessor, "componentType");
    if (width == 1) check_indices(type);
    const bool normalized = flag(accessor, "normalized") && type != 5126;
    // Without a buffer view, all elements are zero.
    Elements values(count, {0, 0, 0, width < 4 ? 1 : 0});
    if (member(accessor, "bufferView").is_number())
        copy_elements(file, accessor, type, normalized, width, count, what, values);
    if (const Json &sparse = member(accessor, "sparse"); sparse.is_object()) {
        const size_t changes = size_in(sparse, "count");
        if (changes > count) throw Error(what, " have invalid sparse parts");
        const Json &where = member(sparse, "indices");
        Elements places(changes);
        copy_elements(file, where, check_indices(index(where, "componentType")), false, 1, changes,
                      what, places);
        copy_elements(file, member(sparse, "values"), type, normalized, width, changes, what,
                      values, &places);
    }
    return values;
}

// ---- What is read

struct Emission {
    Vec3 radiance = {0, 0, 0}; // without its texture
    bool both_sides = false;
};

struct Reader {
    File &file;
    Scene scene = {};
    std::vector<Point3d> points = {};    // the vertices
    std::vector<Emission> emission = {}; // of each material
    std::vector<Point3d> light_places = {}, camera_places = {};
    std::map<std::pair<int64_t, bool>, uint32_t> materials = {}; // with vertex colours, or without
    std::map<std::pair<int64_t, bool>, int32_t> textures = {};   // in sRGB, or linear
    std::set<std::string> ignored = {}; // what the file has and the scene lacks
};

// ---- Textures

int32_t load_texture(Reader &r, int64_t number, bool srgb) {
    const auto [known, is_new] = r.textures.try_emplace({number, srgb}, -1);
    if (!is_new) return known->second;
    const Json &texture = r.file.at("textures", number, "texture");
    const int64_t source = index(texture, "source");
    if (source < 0) { // a texture may offer a PNG or JPEG beside an image of another format
        r.ignored.insert("textures without a PNG or JPEG");
        return -1;
    }
    const Json &image = r.file.at("images", source, "image");
    const std::string name = name_of("image", image, source), uri = text(image, "uri");
    Texture loaded;
    try {
        if (const int64_t view = index(image, "bufferView"); view >= 0) {
            const Span bytes = r.file.view(view, "an image");
            loaded = texture_decode({bytes.data, bytes.data + bytes.size});
        } else if (!holds_data(uri) && !r.file.folder.has(percent_decoded(uri))) {
            r.ignored.insert("the missing " + name);
            return -1;
        } else {
            loaded = texture_decode(r.file.resource(uri));
        }
    } catch (const Error &error) {
        throw Error(name, ": ", error.what());
    }
    loaded.srgb = srgb;
    if (loaded.cut_short) r.ignored.insert("that " + name + " is cut short");
    if (const int64_t at = index(texture, "sampler"); at >= 0) {
        const Json &sampler = r.file.at("samplers", at, "sampler");
        const auto wrap = [&](const char *mode) {
            const int64_t value = index(sampler, mode);
            return value == 33071   ? Texture::CLAMP
                   : value == 33648 ? Texture::MIRROR
                                    : Texture::REPEAT;
        };
        loaded.wrap_u = wrap("wrapS");
        loaded.wrap_v = wrap("wrapT");
        loaded.nearest = index(sampler, "magFilter") == 9728;
    }
    r.scene.textures.push_back(std::move(loaded));
    return known->second = int32_t(r.scene.textures.size() - 1);
}

TextureUse texture_use(Reader &r, const Json &info, bool srgb) {
    TextureUse use;
    if (index(info, "index") < 0) return use;
    const Json &transform = extension(info, "KHR_texture_transform");
    const double turn = number(transform, "rotation", 0);
    const double sine = std::sin(turn), cosine = std::cos(turn);
    std::vector<double> s = numbers(transform, "scale", 2), o = numbers(transform, "offset", 2);
    if (s.empty()) s = {1, 1};
    if (o.empty()) o = {0, 0};
    use.transform =
        glm::mat3x2(cosine * s[0], -sine * s[0], sine * s[1], cosine * s[1], o[0], o[1]);
    const double set = number(transform, "texCoord", number(info, "texCoord", 0));
    if (!(set >= 0 && set <= 1)) {
        r.ignored.insert("textures on a third set of coordinates");
        return use;
    }
    use.set = uint32_t(set);
    use.texture = load_texture(r, index(info, "index"), srgb);
    return use;
}

// ---- Materials: full metal without a metallic-roughness texture becomes a conductor, a
// transmissive material a dielectric, one with neither metal nor coat diffuse; all others use
// glTF's metallic-roughness model.

// The coat's reflectance at normal incidence, as an index of refraction and a colour. Converters
// from specular-glossiness write an index of 1000, or 0 for infinity, and the reflectance as colour.
void read_coat(Reader &r, const Json &source, double ior, Material &m) {
    const Json &specular = extension(source, "KHR_materials_specular");
    for (const char *name : {"specularTexture", "specularColorTexture"})
        if (!member(specular, name).is_null()) {
            r.ignored.insert("textures of coats");
            if (ior < 1 || ior > 3) ior = 1.5; // which only the texture would make sense of
        }
    m.ior = bounded(ior, 1, 10);
    const double root = ior < 1 ? 1 : (ior - 1) / (ior + 1);
    const std::vector<double> tint = numbers(specular, "specularColorFactor", 3);
    const Vec3 coat = bounded(number(specular, "specularFactor", 1)) *
                      min(float(root * root) * colour(tint, 1e9), Vec3(0.98f));
    m.coat_colour = max_component(coat) > 0 ? coat / max_component(coat) : Vec3(1);
    if (specular.is_object() || ior < 1 || ior > 10) {
        const float edge = std::sqrt(max_component(coat));
        m.ior = (1 + edge) / (1 - edge);
    }
}

Emission read_emission(Reader &r, const Json &source, SurfaceMaps &maps) {
    const double strength =
        number(extension(source, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
    const std::vector<double> factor = numbers(source, "emissiveFactor", 3);
    if (!factor.empty()) maps.emission_factor = bounded(strength, 0, 1e9) * colour(factor, 1e9);
    const Json &texture = member(source, "emissiveTexture");
    if (max_component(maps.emission_factor) > 0)
        maps.emission = texture_use(r, texture, true);
    else if (!texture.is_null())
        r.ignored.insert("textures of emission without an emissiveFactor, which is then 0");
    return {maps.emission_factor, flag(source, "doubleSided")};
}

void read_holes(Reader &r, const Json &source, double alpha, SurfaceMaps &maps) {
    const std::string mode = text(source, "alphaMode");
    const int32_t texture = maps.colour.texture;
    const bool image_has_holes = texture >= 0 && r.scene.textures[texture].has_alpha;
    const bool blend = mode == "BLEND" && (alpha < 1 || image_has_holes || maps.vertex_colours);
    if (mode != "MASK" && !blend) return;
    maps.alpha = bounded(alpha);
    maps.alpha_cutoff = blend ? 0.5f : bounded(number(source, "alphaCutoff", 0.5), 0, 2);
    if (image_has_holes) maps.cut_out = maps.colour;
    if (blend) r.ignored.insert("blending (what covers less than half is cut out)");
    r.scene.has_cut_outs = r.scene.has_cut_outs || maps.alpha_cutoff > 0;
}

uint32_t material_number(Reader &r, int64_t number_in_file, bool vertex_colours) {
    const auto [known, is_new] =
        r.materials.try_emplace({number_in_file, vertex_colours}, uint32_t(r.materials.size()));
    if (!is_new) return known->second;
    const Json none;
    const Json &source =
        number_in_file < 0 ? none : r.file.at("materials", number_in_file, "material");
    for (const auto &[name, value] : member(source, "extensions").items())
        if (KNOWN_MATERIALS.count(name) == 0) r.ignored.insert("the extension " + printable(name));

    const Json &pbr = member(source, "pbrMetallicRoughness"),
               &transmission = extension(source, "KHR_materials_transmission");
    const std::vector<double> base = numbers(pbr, "baseColorFactor", 4);
    const double alpha = base.empty() ? 1 : base[3];
    const double ior = number(extension(source, "KHR_materials_ior"), "ior", 1.5);
    const bool blended = text(source, "alphaMode") == "BLEND" && alpha < 1;
    Material m;
    SurfaceMaps maps;
    m.albedo = colour(base);
    m.metallic = bounded(number(pbr, "metallicFactor", 1));
    m.roughness = bounded(number(pbr, "roughnessFactor", 1));
    maps.vertex_colours = vertex_colours;
    maps.colour = texture_use(r, member(pbr, "baseColorTexture"), true);
    // Metal does not transmit. But a file that omits metallicFactor declares metal by default: if it
    // also blends with an alpha below 1, it means glass.
    const bool transmits =
        number(transmission, "transmissionFactor", 0) >= 0.5 && (m.metallic < 0.5f || blended);
    if (transmits) {
        m.kind = Material::DIELECTRIC;
        read_coat(r, source, ior, m);
        if (ior >= 1 && ior <= 10) {
            if (extension(source, "KHR_materials_specular").is_object())
                r.ignored.insert("the specular colour of glass");
            m.ior = bounded(ior, 1, 10);
        }
        // The uncovered part passes all colours.
        if (blended) m.albedo = glm::mix(Vec3(1), m.albedo, bounded(alpha));
        if (!member(transmission, "transmissionTexture").is_null() ||
            !member(pbr, "metallicRoughnessTexture").is_null())
            r.ignored.insert("textures of transmission and its roughness");
    } else {
        read_coat(r, source, ior, m);
        maps.metallic_roughness = texture_use(r, member(pbr, "metallicRoughnessTexture"), false);
        const bool all_metal = m.metallic == 1 && maps.metallic_roughness.texture < 0;
        const bool bare = m.metallic == 0 && !(m.ior > 1);
        m.kind = all_metal ? Material::CONDUCTOR
                 : bare    ? Material::DIFFUSE
                           : Material::METALLIC_ROUGHNESS;
        // What is inside glass is seen through its back.
        m.single_sided = !flag(source, "doubleSided");
    }
    // Blended glass passes light instead.
    if (!transmits || text(source, "alphaMode") == "MASK") read_holes(r, source, alpha, maps);
    const Json &normal = member(source, "normalTexture");
    maps.normal = texture_use(r, normal, false);
    maps.normal_scale = bounded(number(normal, "scale", 1), -100, 100);
    r.emission.push_back(read_emission(r, source, maps));

    Scene &scene = r.scene;
    scene.has_single_sided = scene.has_single_sided || m.single_sided;
    bool any = maps.alpha_cutoff > 0 || maps.vertex_colours;
    for (const TextureUse *use :
         {&maps.colour, &maps.metallic_roughness, &maps.emission, &maps.normal})
        any = any || use->texture >= 0;
    if (any) {
        m.maps = int32_t(scene.maps.size());
        scene.maps.push_back(maps);
    }
    scene.materials.push_back(m);
    return known->second;
}

// ---- Transformations

using Transform = glm::dmat4x3; // without the last row, which is 0, 0, 0, 1

glm::dmat4 local_transform(const Json &node) {
    const std::vector<double> matrix = numbers(node, "matrix", 16),
                              r = numbers(node, "rotation", 4), scale = numbers(node, "scale", 3),
                              by = numbers(node, "translation", 3);
    if (!matrix.empty()) return glm::dmat4(Transform(glm::make_mat4(matrix.data())));
    glm::dmat4 t(1);
    if (!r.empty()) t = mat4_cast(normalize(glm::dquat(r[3], r[0], r[1], r[2])));
    if (!scale.empty()) t = glm::scale(t, glm::make_vec3(scale.data()));
    if (!by.empty()) t[3] = {by[0], by[1], by[2], 1};
    return t;
}

// The unit vector along t * v; zero if there is none.
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

// Calls `triangle` with three corner indices below `count`, for each triangle of a primitive mode.
template <typename Function>
void for_each_triangle(int64_t mode, size_t count, const Function &triangle) {
    for (size_t i = 0; i + 2 < count; i += mode == 4 ? 3 : 1) {
        if (mode == 4) triangle(i, i + 1, i + 2);
        if (mode == 5) triangle(i, i + 1 + i % 2, i + 2 - i % 2);
        if (mode == 6) triangle(i + 1, i + 2, size_t{0});
    }
}

// Tangents where a file has none, after Mikkelsen ("Simulation of Wrinkled Surfaces Revisited",
// 2008): at each vertex the mean over the faces that share its place, normal and coordinates,
// weighted by their angles there. Faces whose textures are mirror images share none.
void make_tangents(Reader &r, const TextureUse &map, size_t first_triangle) {
    using Key = std::array<float, 9>;
    Scene &scene = r.scene;
    const std::vector<Vec2> &coordinates = scene.texture_coordinates[map.set];
    std::map<Key, Vec3> sums;
    const auto corners = [&](const auto &visit) {
        for (size_t i = first_triangle; i < scene.triangles.size(); ++i) {
            const auto &t = scene.triangles[i].vertices;
            const auto place = [&](int c) {
                return map.transform * Vec3(coordinates[t[c % 3]], 1);
            };
            const Vec2 u = place(1) - place(0), v = place(2) - place(0);
            const float turn = u.x * v.y - u.y * v.x > 0 ? 1 : -1;
            for (int c = 0; c < 3; ++c) {
                const Vec3 p = Vec3(r.points[t[c]] - r.points[0]), n = scene.normals[t[c]];
                const Vec2 uv = coordinates[t[c]];
                Vec3 &sum = sums[{p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y, turn}];
                const auto edge = [&](int to) { // and how its coordinates change
                    return std::pair{Vec3(r.points[t[(c + to) % 3]] - r.points[t[c]]),
                                     place(c + to) - place(c)};
                };
                visit(scene.tangents[3 * i + size_t(c)], sum, n, turn, edge(1), edge(2));
            }
        }
    };
    corners([](glm::vec4 &, Vec3 &sum, Vec3 n, float turn, const auto &a, const auto &b) {
        const Vec3 along = turn * (b.second.y * a.first - a.second.y * b.first);
        const float cosine = dot(normalize_or(a.first, {}), normalize_or(b.first, {}));
        sum += std::acos(std::clamp(cosine, -1.0f, 1.0f)) *
               normalize_or(along - dot(along, n) * n, {});
    });
    corners([](glm::vec4 &own, Vec3 &sum, Vec3 n, float turn, const auto &a, const auto &b) {
        const bool against_winding = dot(n, cross(a.first, b.first)) < 0;
        own = glm::vec4(normalize_or(sum, {}), against_winding ? turn : -turn);
    });
}

void read_primitive(Reader &r, const Json &primitive, const Transform &transform) {
    const auto mode = int64_t(number(primitive, "mode", 4));
    if (mode < 4 || mode > 6) {
        r.ignored.insert("points and lines");
        return;
    }
    if (!member(primitive, "targets").empty()) r.ignored.insert("morph targets");
    const Json &attributes = member(primitive, "attributes");
    if (index(attributes, "POSITION") < 0) return; // glTF says to skip it
    const Elements positions =
        elements(r.file, index(attributes, "POSITION"), {"VEC3"}, "positions");
    const size_t count = positions.size();
    if (r.points.size() + count > MAX_ELEMENTS) throw Error("has more than 2^26 vertices");
    // Of other attributes, as many, or none.
    const auto optional = [&](const char *name, const std::set<std::string> &types,
                              const char *what) {
        if (index(attributes, name) < 0) return Elements{};
        const Elements values = elements(r.file, index(attributes, name), types, what);
        if (values.size() != count)
            throw Error("has ", what, " of another count than its positions");
        return values;
    };
    const Elements normals = optional("NORMAL", {"VEC3"}, "normals"),
                   tangents = optional("TANGENT", {"VEC4"}, "tangents"),
                   colours = optional("COLOR_0", {"VEC3", "VEC4"}, "vertex colours"),
                   coordinates[] = {optional("TEXCOORD_0", {"VEC2"}, "texture coordinates"),
                                    optional("TEXCOORD_1", {"VEC2"}, "texture coordinates")};

    bool mirrored;
    const glm::dmat3 turn(transform), normal_matrix = cofactors(turn, mirrored);
    const auto first = uint32_t(r.points.size());
    for (size_t i = 0; i < count; ++i) {
        const Point3d position = transform * positions[i];
        if (!is_finite(position) || max_magnitude(position) > MAX_COORDINATE)
            throw Error("has a vertex that is not a finite number, or beyond 1e15");
        r.points.push_back(position);
        r.scene.normals.push_back(normals.empty() ? Vec3(0) : direction(normal_matrix, normals[i]));
        for (int set = 0; set < 2; ++set)
            r.scene.texture_coordinates[set].push_back(
                coordinates[set].empty() ? Vec2(0) : Vec2(coordinates[set][i]));
        r.scene.colours.push_back(colours.empty() ? glm::vec4(1)
                                                  : glm::vec4(clamp(colours[i], 0.0, 1.0)));
    }

    const uint32_t material = material_number(r, index(primitive, "material"), !colours.empty());
    std::vector<uint32_t> indices;
    if (member(primitive, "indices").is_null())
        for (uint32_t i = 0; i < count; ++i) indices.push_back(i);
    else
        for (const glm::dvec4 &v :
             elements(r.file, index(primitive, "indices"), {"SCALAR"}, "indices"))
            indices.push_back(uint32_t(v.x));
    for (const uint32_t vertex : indices)
        if (vertex >= count)
            throw Error("has an index out of range: vertex ", vertex, " of ", count);
    const size_t first_triangle = r.scene.triangles.size();
    for_each_triangle(mode, indices.size(), [&](size_t a, size_t b, size_t c) {
        if (mirrored) std::swap(b, c);
        r.scene.triangles.push_back({{first + indices[a], first + indices[b], first + indices[c]}});
        r.scene.surfaces.push_back({material, -1});
        for (const uint32_t i : {indices[a], indices[b], indices[c]}) {
            glm::vec4 tangent(0);
            if (!tangents.empty() && !normals.empty())
                tangent = {direction(turn, tangents[i]),
                           (tangents[i].w < 0) != mirrored ? -1.0f : 1.0f};
            r.scene.tangents.push_back(tangent);
        }
    });
    const int32_t maps = r.scene.materials[material].maps;
    if (maps >= 0 && r.scene.maps[maps].normal.texture >= 0 && !normals.empty() && tangents.empty())
        make_tangents(r, r.scene.maps[maps].normal, first_triangle);
}

// ---- Cameras and lights: both point along their node's -z

void read_camera(Reader &r, const Json &camera, const Transform &t, const std::string &node_name) {
    const Vec3 forward = direction(glm::dmat3(t), {0, 0, -1}),
               up = direction(glm::dmat3(t), {0, 1, 0});
    const double angle = number(member(camera, "perspective"), "yfov", 0);
    if (text(camera, "type") != "perspective") {
        r.ignored.insert("orthographic cameras");
    } else if (!(max_magnitude(cross(forward, up)) > 1e-3f) || !(angle > 1e-4 && angle < 3.1)) {
        r.ignored.insert("a camera without direction or angle");
    } else {
        Camera read{};
        read.tan_half_height = float(std::tan(0.5 * angle));
        camera_turn(read, forward, up);
        const std::string &name = node_name.empty() ? text(camera, "name") : node_name;
        r.scene.cameras.push_back({read, printable(name)});
        r.camera_places.push_back(t[3]);
    }
}

void read_light(Reader &r, const Json &source, const Transform &t, bool photometric) {
    Light light{};
    const std::map<std::string, Light::Kind> kinds = {
        {"point", Light::POINT}, {"spot", Light::SPOT}, {"directional", Light::DIRECTIONAL}};
    const auto kind = kinds.find(text(source, "type"));
    light.normal = direction(glm::dmat3(t), {0, 0, -1});
    if (kind == kinds.end() ||
        (kind->second != Light::POINT && !(max_magnitude(light.normal) > 0))) {
        r.ignored.insert("lights of unknown kinds or without a direction");
        return;
    }
    light.kind = kind->second;
    const std::vector<double> c = numbers(source, "color", 3);
    const Vec3 tint = c.empty() ? Vec3(1) : Vec3(c[0], c[1], c[2]);
    const auto intensity = float(number(source, "intensity", 1));
    light.radiance = (photometric ? intensity / LUMENS_PER_WATT : intensity) * tint;
    if (!is_finite(light.radiance) || std::min({tint.x, tint.y, tint.z}) < 0)
        throw Error("has a light whose intensity is negative or not a number");
    const Json &cone = member(source, "spot");
    light.cosine_inner = float(std::cos(number(cone, "innerConeAngle", 0)));
    light.cosine_outer = float(std::cos(number(cone, "outerConeAngle", 0.25 * double(PI))));
    if (number(source, "range", 0) > 0) r.ignored.insert("the range of lights");
    r.scene.lights.push_back(light);
    r.light_places.push_back(t[3]);
}

// ---- Nodes

void read_node(Reader &r, const Json &node, const Transform &t, bool photometric) {
    if (!member(node, "mesh").is_null())
        for (const Json &p : member(r.file.at("meshes", index(node, "mesh"), "mesh"), "primitives"))
            read_primitive(r, p, t);
    if (!member(node, "skin").is_null()) r.ignored.insert("skins");
    const Json &camera = member(node, "camera"), &light = extension(node, "KHR_lights_punctual");
    if (camera.is_null() && light.is_null()) return;
    if (!is_finite(t[3]) || max_magnitude(t[3]) > MAX_COORDINATE) {
        r.ignored.insert("a camera or a light beyond 1e15");
        return;
    }
    if (!camera.is_null())
        read_camera(r, r.file.at("cameras", index(node, "camera"), "camera"), t,
                    text(node, "name"));
    if (!light.is_null()) {
        const Json &list = member(extension(r.file.json, "KHR_lights_punctual"), "lights");
        read_light(r, File::element(list, index(light, "light"), "light"), t, photometric);
    }
}

void read_nodes(Reader &r, bool photometric) {
    const Json &nodes = member(r.file.json, "nodes"), &scenes = member(r.file.json, "scenes");
    std::vector<std::pair<int64_t, Transform>> open; // a stack of nodes still to be read
    std::set<int64_t> reached;
    const auto as_index = [](const Json &v) {
        return v.is_number_unsigned() ? v.get<int64_t>() : -1;
    };
    const auto reach = [&](const Json &children, const Transform &parent) {
        for (auto child = children.rbegin(); child != children.rend(); ++child) {
            const int64_t at = as_index(*child);
            r.file.at("nodes", at, "node");
            if (!reached.insert(at).second)
                throw Error("reaches node ", at, " twice: its nodes do not form a tree");
            open.push_back({at, parent});
        }
    };
    if (!scenes.empty()) {
        const int64_t chosen =
            member(r.file.json, "scene").is_null() ? 0 : index(r.file.json, "scene");
        reach(member(r.file.at("scenes", chosen, "scene"), "nodes"), Transform(1));
        if (scenes.size() > 1) r.ignored.insert("scenes but the default one");
    } else { // glTF leaves this open: read every node without a parent
        std::set<int64_t> children;
        for (const Json &node : nodes)
            for (const Json &child : member(node, "children")) children.insert(as_index(child));
        Json roots = Json::array();
        for (size_t i = 0; i < nodes.size(); ++i)
            if (children.count(int64_t(i)) == 0) roots.push_back(i);
        reach(roots, Transform(1));
    }
    while (!open.empty()) {
        const auto [at, parent] = open.back();
        open.pop_back();
        const Json &node = nodes[size_t(at)];
        const Transform transform = parent * local_transform(node);
        read_node(r, node, transform, photometric);
        reach(member(node, "children"), transform);
    }
}

// ---- From what was read to a scene

// The mean over a few points of a triangle.
Vec3 mean_emission(const Scene &scene, uint32_t triangle) {
    const int rows = 6;
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < rows * rows; ++i) {
        const Vec2 at =
            square_to_triangle((Vec2(float(i % rows), float(i / rows)) + 0.5f) / float{rows});
        sum += emission_at(scene, {triangle, at.x, at.y});
    }
    return sum / float{rows * rows};
}

// Turns triangles of emissive materials into lights. Returns whether any counts as a lamp. Textured
// emission does not, nor does emission no brighter than a display's white, the most that glTF's
// emissiveFactor reaches: eyes, labels and switches glow, but the scene keeps its sky.
bool make_area_lights(Reader &r) {
    Scene &scene = r.scene;
    std::vector<Vec3> whole_textures; // of each map
    for (const SurfaceMaps &maps : scene.maps) {
        const int32_t texture = maps.emission.texture;
        whole_textures.push_back(maps.emission_factor *
                                 (texture >= 0 ? texture_mean(scene.textures[texture]) : Vec3(1)));
    }
    bool lit = false;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uint32_t material = scene.surfaces[i].material;
        const Emission &emission = r.emission[material];
        if (!(max_component(emission.radiance) > 0)) continue;
        const auto &t = scene.triangles[i].vertices;
        const Vec3 corner = scene.vertices[t[0]];
        Light light = area_light(Light::TRIANGLE, corner, scene.vertices[t[1]] - corner,
                                 scene.vertices[t[2]] - corner, emission.radiance);
        light.both_sides = emission.both_sides;
        bool textured = false, there = true;
        if (const int32_t number = scene.materials[material].maps; number >= 0) {
            const SurfaceMaps &maps = scene.maps[number];
            textured = maps.emission.texture >= 0;
            light.mapped = textured || maps.alpha_cutoff > 0;
            const Vec3 mean = mean_emission(scene, uint32_t(i));
            there = max_component(mean) > 0;
            // What is between the points counts a little, so that it is sampled, too.
            const bool even = maps.cut_out.texture < 0 && !maps.vertex_colours;
            const bool gone = even && maps.alpha < maps.alpha_cutoff;
            if (light.mapped) light.radiance = mean + (gone ? 0 : 0.01f) * whole_textures[number];
        }
        if (!(max_component(light.radiance) > 0)) continue;
        lit = lit || (there && !textured && max_component(emission.radiance) > MAX_GLOW);
        scene.surfaces[i].light = int32_t(scene.lights.size());
        scene.lights.push_back(light);
    }
    return lit;
}

// Moves the points' centre to the origin, so that float keeps the digits that matter.
void recentre(Reader &r) {
    Scene &scene = r.scene;
    Point3d low = r.points[0], high = low;
    for (const Point3d p : r.points) low = min(low, p), high = max(high, p);
    scene.origin = 0.5 * (low + high);
    for (const Point3d p : r.points) scene.vertices.push_back(p - scene.origin);
    if (!(max_magnitude(high - scene.origin) <= MAX_REACH))
        throw Error("extends more than 1e10 from its centre; scale it down");
    r.points = {};
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

// Moves the file's cameras and punctual lights along with the scene. A camera's target is the point
// on its axis nearest to the scene's centre.
void place_cameras_and_lights(Reader &r) {
    Scene &scene = r.scene;
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        Camera &camera = scene.cameras[i].camera;
        camera.position = Vec3(r.camera_places[i] - scene.origin);
        const float ahead = -dot(camera.position, camera.forward);
        camera.target = camera.position + (ahead > 0 ? ahead : 1) * camera.forward;
    }
    for (size_t i = 0; i < scene.lights.size(); ++i)
        scene.lights[i].corner = Vec3(r.light_places[i] - scene.origin);
    scene.camera = scene.cameras.empty() ? framing_camera(scene) : scene.cameras[0].camera;
}

} // namespace

bool is_scene_file(const std::string &name) {
    std::string end = name.substr(std::min(name.rfind('.'), name.size()));
    for (char &c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return end == ".gltf" || end == ".glb";
}

Scene scene_file_read(const std::string &path, const SceneOptions &options) {
    try {
        SceneFolder folder(path, options.allow_outside, options.record);
        File file(folder);
        Reader r{file};
        for (const Json &used : member(file.json, "extensionsUsed"))
            if (used.is_string() && !is_known(used))
                r.ignored.insert("the extension " + printable(used));
        if (!member(file.json, "animations").empty()) r.ignored.insert("animations");
        read_nodes(r, options.photometric);
        Scene &scene = r.scene;
        if (scene.triangles.empty()) throw Error("has no triangles to render");
        if (scene.maps.empty()) { // then nothing looks these up
            scene.texture_coordinates[0] = scene.texture_coordinates[1] = {};
            scene.colours = scene.tangents = {};
        }
        const auto none = [](Vec3 n) { return !(max_magnitude(n) > 0); };
        if (std::all_of(scene.normals.begin(), scene.normals.end(), none)) scene.normals = {};
        recentre(r);
        place_cameras_and_lights(r);
        const bool punctual = !scene.lights.empty(), lamps = make_area_lights(r);
        scene.environment = options.environment;
        if (!scene.environment && !punctual && !lamps)
            scene.environment = std::make_shared<Environment>(environment_read("sky"));
        std::string ignored;
        for (const std::string &what : r.ignored) ignored += (ignored.empty() ? "" : ", ") + what;
        if (!ignored.empty()) scene.notes.push_back(path + ": ignores " + ignored);
        return std::move(scene);
    } catch (const Json::exception &error) {
        const std::string what = error.what(); // its end is a part of the file, which may be long
        throw Error(
            path, ": is not valid glTF 2.0: ", printable(what.substr(0, what.find("; last read"))));
    } catch (const Error &error) {
        throw Error(path, ": ", error.what());
    }
}
