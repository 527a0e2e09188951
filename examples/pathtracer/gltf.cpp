// SPDX-License-Identifier: Apache-2.0
// Reads glTF 2.0 into a scene. JSON for Modern C++ parses the text and checks the types of values.
// Every index, offset and size is checked here before it is used, and --max-memory limits memory.
// Transforms are composed and applied in double precision, and the scene is moved to the origin, so
// that distant geometry keeps its precision. Nodes are visited iteratively; reaching a node twice is
// an error.
#include <strings.h>

#include <cstring>
#include <limits>
#include <set>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "scene.h"

namespace {

using Json = nlohmann::json;
using Bytes = std::vector<unsigned char>;
using Transform = glm::dmat4x3; // without the last row, which is 0, 0, 0, 1

constexpr size_t MAX_ELEMENTS = size_t{1} << 26; // vertices, or elements of an array
constexpr float LUMENS_PER_WATT = 683;           // at 555 nm; glTF exporters use it for all light
constexpr float MAX_GLOW = 1;                    // radiance
constexpr double MAX_COORDINATE = 1e15;          // where doubles still resolve an eighth
// The largest distance from the scene's centre. Products of three lengths, and areas, still fit in a
// float, so images are correct; at a hundred times this distance, Embree would abort.
constexpr float MAX_REACH = 1e10f;

// ---- JSON: missing values have defaults, and values of the wrong type are rejected

// Returns an empty object if there is none.
const Json &member(const Json &of, const char *name) {
    static const Json none = Json::object();
    const auto found = of.find(name);
    return found == of.end() ? none : *found;
}

const Json &extension(const Json &of, const char *name) {
    return member(member(of, "extensions"), name);
}

// An index, an offset, a size or an OpenGL constant.
int64_t integer(const Json &of, const char *name, int64_t otherwise = -1) {
    if (!of.contains(name)) return otherwise;
    const auto value = of[name].get<double>();
    if (!(value >= 0 && value < 1e18)) throw Error("has an impossible ", name);
    return int64_t(value);
}

size_t size_in(const Json &of, const char *name) {
    return size_t(integer(of, name, 0));
}

// A vector or a matrix of doubles.
template <typename Numbers>
Numbers numbers(const Json &of, const char *name, Numbers otherwise) {
    const Json &values = member(of, name);
    for (size_t i = 0; i < sizeof otherwise / sizeof(double) && !values.empty(); ++i)
        value_ptr(otherwise)[i] = values.at(i);
    return otherwise;
}

float bounded(double value, double low = 0, double high = 1) {
    return float(std::clamp(value, low, high));
}

// Throws Error if there is no element with that index.
const Json &element(const Json &of, const char *list, int64_t number) {
    const Json &elements = member(of, list);
    if (number < 0 || size_t(number) >= elements.size())
        throw Error("refers to ", list, "[", number, "], and has ", elements.size());
    return elements.at(size_t(number));
}

// ---- Data in text

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

// Decodes a percent-encoded URI to a file name. A plus is not decoded.
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

bool holds_data(const std::string &uri) {
    return strncasecmp(uri.c_str(), "data:", 5) == 0;
}

// The name of a buffer or an image in messages.
std::string name_of(const char *what, const Json &source, int64_t number) {
    const std::string uri = source.value("uri", ""), name = source.value("name", "");
    if (!uri.empty() && !holds_data(uri)) return joined(what, " ", percent_decoded(uri));
    return joined(what, " ", number, name.empty() ? "" : " ", name);
}

struct Span {
    const unsigned char *data;
    size_t size, stride; // stride 0: packed
};

// ---- Arrays. Elements are read where they are used: primitives may share large arrays.

// The bytes of a number of this component type.
size_t size_of(int64_t type) {
    return type < 5122 ? 1 : type < 5125 ? 2 : 4;
}

// Normalized integers become [0, 1] or [-1, 1].
double number_at(const unsigned char *at, int64_t type, bool normalized) {
    const auto as = [&](auto number) {
        std::memcpy(&number, at, sizeof number);
        const double limit = std::numeric_limits<decltype(number)>::max(), value = number;
        return normalized && limit < 1e10 ? std::max(value / limit, -1.0) : value;
    };
    if (type < 5122) return type == 5120 ? as(int8_t{}) : as(uint8_t{});
    if (type < 5125) return type == 5122 ? as(int16_t{}) : as(uint16_t{});
    return type == 5125 ? as(uint32_t{}) : as(float{});
}

struct Elements {
    size_t count, width; // numbers per element
    int64_t type = 5126;
    bool normalized = false;
    Span from = {};                            // without data: zeros
    std::map<size_t, glm::dvec4> changed = {}; // by a sparse accessor

    // Missing components are 0, but the last is 1.
    glm::dvec4 operator[](size_t i) const {
        const auto found = changed.find(i);
        if (found != changed.end()) return found->second;
        glm::dvec4 element = {0, 0, 0, width < 4 ? 1 : 0};
        const unsigned char *at = from.data + i * from.stride;
        for (int c = 0; c < int(width) && from.data; ++c, at += size_of(type))
            element[c] = number_at(at, type, normalized);
        return element;
    }
};

// ---- The file

// Extensions that the reader supports, or reports where a texture uses them.
const std::set<std::string> KNOWN = {"KHR_lights_punctual",
                                     "KHR_texture_transform",
                                     "KHR_mesh_quantization",
                                     "EXT_texture_webp",
                                     "EXT_texture_avif",
                                     "KHR_texture_basisu",
                                     "MSFT_texture_dds",
                                     "KHR_materials_ior",
                                     "KHR_materials_transmission",
                                     "KHR_materials_specular",
                                     "KHR_materials_emissive_strength"};

// Others are reported where a material uses them.
bool is_known(const std::string &name) {
    return KNOWN.count(name) > 0 || name.compare(0, 14, "KHR_materials_") == 0;
}

struct Emission {
    Vec3 radiance = {0, 0, 0}; // without its texture
    Vec3 mean = {0, 0, 0};     // with its whole texture
    bool both_sides = false;
};

// The file, and the results of reading it.
struct Reader {
    const std::string &path;
    const SceneOptions &options;
    Scene scene = {};
    Bytes bytes = scene.inputs.read(path); // the scene file
    Json json = {};
    Span chunk = {};                       // the binary chunk of a .glb
    std::map<int64_t, Bytes> buffers = {}; // those that were read
    std::map<int64_t, Elements> accessors = {};

    std::vector<Point3d> points = {};                            // the vertices
    std::vector<Emission> emission = {};                         // one per material
    std::vector<std::pair<const Json *, Transform>> placed = {}; // nodes with a camera or a light
    std::map<std::pair<int64_t, bool>, uint32_t> materials = {}; // with vertex colours, or without
    std::map<std::pair<int64_t, bool>, int32_t> textures = {};   // in sRGB, or linear
    std::map<std::string, std::shared_ptr<const Texels>> images = {}; // by where they are stored
    std::vector<uint32_t> place = {};   // of the current primitive's vertices
    std::set<std::string> ignored = {}; // features of the file that the scene lacks

    Reader(const std::string &scene_path, const SceneOptions &scene_options)
        : path(scene_path), options(scene_options) {
        Span all = {bytes.data(), bytes.size(), 0};
        if (all.size >= 4 && std::memcmp(all.data, "glTF", 4) == 0) all = glb_text();
        json = Json::parse(all.data, all.data + all.size);
        const Json &asset = member(json, "asset");
        const std::string version = asset.value("version", ""),
                          least = asset.value("minVersion", "");
        if (version.compare(0, 2, "2.") != 0 || (!least.empty() && least != "2.0"))
            throw Error("is glTF ", least.empty() ? version : least, "; version 2.0 is read");
        for (const std::string required : member(json, "extensionsRequired"))
            if (!is_known(required))
                throw Error("requires the extension ", required, ", which cannot be read");
    }

    // A .glb file's JSON, its first chunk. The second chunk may be binary.
    Span glb_text() {
        const auto word = [&](size_t at) {
            uint32_t value;
            std::memcpy(&value, &bytes[at], sizeof value);
            return size_t{value};
        };
        const size_t size = bytes.size() < 20 ? 20 : word(8);
        if (size < 20 || size > bytes.size())
            throw Error("is cut short: it has ", bytes.size(), " bytes of ", size);
        const auto chunk_at = [&](size_t at) {
            if (word(at) > size - at - 8) throw Error("is cut short: a chunk goes beyond its end");
            return Span{bytes.data() + at + 8, word(at), 0};
        };
        const Span text = chunk_at(12);
        const size_t second = 20 + text.size;
        if (second + 8 <= size && std::memcmp(&bytes[second + 4], "BIN", 4) == 0)
            chunk = chunk_at(second);
        return text;
    }

    std::filesystem::path resolve(const std::string &uri) const {
        return std::filesystem::path(path).parent_path() / percent_decoded(uri);
    }

    // The bytes in a data URI, or in the file that a URI names.
    Bytes resource(const std::string &uri) {
        if (!holds_data(uri)) return scene.inputs.read(resolve(uri));
        const size_t comma = uri.find(";base64,");
        if (comma == std::string::npos) throw Error("is not base64");
        return base64_decoded(uri, comma + 8);
    }

    Span buffer(int64_t number) {
        const Json &source = element(json, "buffers", number);
        const std::string uri = source.value("uri", ""), name = name_of("buffer", source, number);
        Span found = chunk;
        if (!uri.empty()) {
            const auto [known, is_new] = buffers.try_emplace(number);
            if (is_new) known->second = named(name, [&] { return resource(uri); });
            found = {known->second.data(), known->second.size(), 0};
        }
        const size_t wanted = size_in(source, "byteLength");
        if (found.size < wanted)
            throw Error("is cut short: ", name, " has ", found.size, " bytes of ", wanted);
        return {found.data, wanted, 0};
    }

    // The buffer view that an accessor or an image refers to.
    Span view(const Json &of, const char *what) {
        const Json &source = element(json, "bufferViews", integer(of, "bufferView"));
        const Span whole = buffer(integer(source, "buffer"));
        const size_t offset = size_in(source, "byteOffset"), size = size_in(source, "byteLength");
        if (offset > whole.size || size > whole.size - offset)
            throw Error("is cut short: the buffer view of ", what,
                        " runs past the end of its buffer");
        return {whole.data + offset, size, size_in(source, "byteStride")};
    }
};

// ---- Reading arrays

// The elements in a buffer view, or zeros without one. They have the accessor's types. Single numbers are
// indices, unsigned in the file.
Elements stored(Reader &r, const Json &source, const Json &accessor, size_t width, size_t count,
                const char *name) {
    Elements elements = {count, width};
    if (!source.contains("bufferView")) return elements;
    const int64_t type = elements.type = integer(accessor, "componentType");
    if (type < 5120 || type == 5124 || type > 5126)
        throw Error(name, " has a number type that glTF does not have");
    if (width == 1 && type != 5121 && type != 5123 && type != 5125)
        throw Error("has ", name, " that are not unsigned integers");
    elements.normalized = accessor.value("normalized", false);
    Span &from = elements.from = r.view(source, name);
    const size_t offset = size_in(source, "byteOffset"), size = width * size_of(type);
    if (from.stride == 0) from.stride = size;
    if (from.stride < size) throw Error(name, " has elements that overlap");
    if (count > 0 && (offset > from.size || size > from.size - offset ||
                      (count - 1) > (from.size - offset - size) / from.stride))
        throw Error(name, " runs past the end of its buffer view");
    from.data += offset;
    return elements;
}

// The elements of an accessor, such as an attribute, which must have one of these types.
const Elements &elements(Reader &r, const Json &of, const char *name,
                         const std::set<std::string> &types) {
    const int64_t number = integer(of, name);
    const Json &accessor = element(r.json, "accessors", number);
    const size_t count = size_in(accessor, "count");
    if (count > MAX_ELEMENTS) throw Error(name, " has ", count, " elements; at most 2^26 are read");
    const std::string type = accessor.value("type", "");
    if (types.count(type) == 0) throw Error(name, " has the wrong number of components");
    const size_t width = type == "SCALAR" ? 1 : size_t(type[3] - '0');
    const auto [known, is_new] = r.accessors.try_emplace(number, Elements{count, width});
    Elements &values = known->second;
    if (!is_new) return values;
    values = stored(r, accessor, accessor, width, count, name);
    const Json &sparse = member(accessor, "sparse"), &where = member(sparse, "indices");
    const size_t changes = size_in(sparse, "count");
    if (changes > count) throw Error(name, " has invalid sparse parts");
    const Elements places = stored(r, where, where, 1, changes, name),
                   changed = stored(r, member(sparse, "values"), accessor, width, changes, name);
    for (size_t i = 0; i < changes; ++i) {
        const auto place = size_t(places[i].x);
        if (place >= count) throw Error("has an index out of range: ", place, " of ", count);
        values.changed[place] = changed[i];
    }
    return values;
}

// ---- Textures

int32_t load_texture(Reader &r, int64_t number, bool srgb) {
    const auto [known, is_new] = r.textures.try_emplace({number, srgb}, -1);
    if (!is_new) return known->second;
    const Json &texture = element(r.json, "textures", number);
    const int64_t source = integer(texture, "source");
    if (source < 0) { // a texture may offer a PNG or JPEG beside an image of another format
        r.ignored.insert("textures without a PNG or JPEG");
        return -1;
    }
    const Json &image = element(r.json, "images", source);
    const std::string name = name_of("image", image, source), uri = image.value("uri", "");
    const bool apart = !image.contains("bufferView") && !holds_data(uri);
    if (apart && !std::filesystem::exists(named(name, [&] { return r.resolve(uri); }))) {
        r.ignored.insert("the missing " + name);
        return -1;
    }
    const std::string where = holds_data(uri) ? "image " + std::to_string(source)
                              : apart         ? "file " + uri
                                              : image["bufferView"].dump();
    std::shared_ptr<const Texels> &texels = r.images[where];
    if (!texels)
        texels = std::make_shared<Texels>(named(name, [&] {
            if (!image.contains("bufferView")) return image_decode(r.resource(uri));
            const Span bytes = r.view(image, "an image");
            return image_decode({bytes.data, bytes.data + bytes.size});
        }));
    Texture loaded;
    loaded.texels = texels;
    loaded.srgb = srgb;
    if (texture.contains("sampler")) {
        const Json &sampler = element(r.json, "samplers", integer(texture, "sampler"));
        const auto wrap = [&](const char *mode) {
            const int64_t value = integer(sampler, mode);
            return value == 33071   ? Texture::CLAMP
                   : value == 33648 ? Texture::MIRROR
                                    : Texture::REPEAT;
        };
        loaded.wrap_u = wrap("wrapS");
        loaded.wrap_v = wrap("wrapT");
        loaded.nearest = integer(sampler, "magFilter") == 9728;
    }
    r.scene.textures.push_back(std::move(loaded));
    return known->second = int32_t(r.scene.textures.size() - 1);
}

TextureUse texture_use(Reader &r, const Json &info, bool srgb) {
    TextureUse use;
    if (!info.contains("index")) return use;
    const Json &transform = extension(info, "KHR_texture_transform");
    const double turn = transform.value("rotation", 0.0);
    const double sine = std::sin(turn), cosine = std::cos(turn);
    const glm::dvec2 s = numbers(transform, "scale", glm::dvec2(1)),
                     o = numbers(transform, "offset", glm::dvec2(0));
    use.transform = glm::mat3x2(cosine * s.x, -sine * s.x, sine * s.y, cosine * s.y, o.x, o.y);
    const int64_t set = integer(transform, "texCoord", integer(info, "texCoord", 0));
    if (set > 1) {
        r.ignored.insert("textures on a third set of coordinates");
        return use;
    }
    use.set = uint32_t(set);
    use.texture = load_texture(r, integer(info, "index"), srgb);
    return use;
}

// ---- Materials: transmissive ones become dielectrics, and those with neither metal nor coat become
// diffuse; all others use glTF's metallic-roughness model.

// The coat's reflectance at normal incidence, as an index of refraction and a colour, and at grazing angles.
// Converters from specular-glossiness write an index of 1000 (or 0: infinity) and the reflectance as colour.
void read_coat(Reader &r, const Json &source, double ior, Material &m) {
    const Json &specular = extension(source, "KHR_materials_specular");
    if (specular.contains("specularTexture") || specular.contains("specularColorTexture")) {
        r.ignored.insert("textures of coats");
        if (ior < 1 || ior > 3) ior = 1.5; // makes sense only with the texture
    }
    m.ior = bounded(ior, 1, 10);
    const double root = ior < 1 ? 1 : (ior - 1) / (ior + 1);
    const Vec3 tint = clamp(numbers(specular, "specularColorFactor", glm::dvec3(1)), 0.0, 1e9);
    const float factor = bounded(specular.value("specularFactor", 1.0));
    const Vec3 coat = factor * min(float(root * root) * tint, Vec3(0.98f));
    m.coat_edge = ior == 1 ? 0 : factor; // then there is no interface
    m.coat_colour = max_component(coat) > 0 ? coat / max_component(coat) : Vec3(1);
    if (!specular.empty() || ior < 1 || ior > 10) {
        const float edge = std::sqrt(max_component(coat));
        m.ior = (1 + edge) / (1 - edge);
    }
}

Emission read_emission(Reader &r, const Json &source, SurfaceMaps &maps) {
    const bool even = maps.cut_out.texture < 0 && !maps.vertex_colours;
    if (even && maps.alpha < maps.alpha_cutoff) return {}; // all of it is cut out
    const double strength =
        extension(source, "KHR_materials_emissive_strength").value("emissiveStrength", 1.0);
    const glm::dvec3 factor = numbers(source, "emissiveFactor", glm::dvec3(0));
    maps.emission_factor = bounded(strength, 0, 1e9) * Vec3(clamp(factor, 0.0, 1e9));
    if (max_component(maps.emission_factor) > 0)
        maps.emission = texture_use(r, member(source, "emissiveTexture"), true);
    else if (source.contains("emissiveTexture"))
        r.ignored.insert("textures of emission without an emissiveFactor, which is then 0");
    const int32_t texture = maps.emission.texture;
    const Vec3 mean = texture >= 0 ? texture_mean(r.scene.textures[texture]) : Vec3(1);
    return {maps.emission_factor, maps.emission_factor * mean, source.value("doubleSided", false)};
}

void read_holes(Reader &r, const Json &source, double alpha, SurfaceMaps &maps) {
    const std::string mode = source.value("alphaMode", "");
    const int32_t texture = maps.colour.texture;
    const bool image_has_holes = texture >= 0 && r.scene.textures[texture].texels->has_alpha;
    const bool blend = mode == "BLEND" && (alpha < 1 || image_has_holes || maps.vertex_colours);
    if (mode != "MASK" && !blend) return;
    maps.alpha = bounded(alpha);
    maps.alpha_cutoff = blend ? 0.5f : bounded(source.value("alphaCutoff", 0.5), 0, 2);
    if (image_has_holes) maps.cut_out = maps.colour;
    if (blend) r.ignored.insert("blending (what covers less than half is cut out)");
    r.scene.has_cut_outs = r.scene.has_cut_outs || maps.alpha_cutoff > 0;
}

uint32_t material_number(Reader &r, int64_t number, bool vertex_colours) {
    const auto [known, is_new] =
        r.materials.try_emplace({number, vertex_colours}, uint32_t(r.materials.size()));
    if (!is_new) return known->second;
    const Json none = Json::object();
    const Json &source = number < 0 ? none : element(r.json, "materials", number);
    for (const auto &[name, value] : member(source, "extensions").items())
        if (KNOWN.count(name) == 0) r.ignored.insert("the extension " + name);

    const Json &pbr = member(source, "pbrMetallicRoughness"),
               &transmission = extension(source, "KHR_materials_transmission");
    const glm::dvec4 base = numbers(pbr, "baseColorFactor", glm::dvec4(1));
    const double ior = extension(source, "KHR_materials_ior").value("ior", 1.5);
    const std::string alpha_mode = source.value("alphaMode", "");
    const bool blended = alpha_mode == "BLEND" && base.a < 1;
    Material m;
    SurfaceMaps maps;
    m.albedo = clamp(Vec3(base), 0.0f, 1.0f);
    m.metallic = bounded(pbr.value("metallicFactor", 1.0));
    m.roughness = bounded(pbr.value("roughnessFactor", 1.0));
    maps.vertex_colours = vertex_colours;
    maps.colour = texture_use(r, member(pbr, "baseColorTexture"), true);
    read_coat(r, source, ior, m);
    // Metal does not transmit. But metal is the default if a file omits metallicFactor: if it also
    // blends with an alpha below 1, it means glass.
    const double transmitted = transmission.value("transmissionFactor", 0.0);
    const bool transmits = transmitted >= 0.5 && (m.metallic < 0.5f || blended);
    if (transmitted > 0 && transmitted < 1)
        r.ignored.insert("partial transmission (below one half is opaque, the rest is glass)");
    if (transmits) {
        m.kind = Material::DIELECTRIC;
        if (ior >= 1 && ior <= 10) {
            if (!extension(source, "KHR_materials_specular").empty())
                r.ignored.insert("the specular colour of glass");
            m.ior = bounded(ior, 1, 10);
        }
        // The uncovered part transmits all colours.
        if (blended) m.albedo = glm::mix(Vec3(1), m.albedo, bounded(base.a));
        if (pbr.contains("metallicRoughnessTexture"))
            r.ignored.insert("textures of the roughness of glass");
    } else {
        maps.metallic_roughness = texture_use(r, member(pbr, "metallicRoughnessTexture"), false);
        const bool bare = m.metallic == 0 && !(m.ior > 1) && m.coat_edge == 0;
        m.kind = bare ? Material::DIFFUSE : Material::METALLIC_ROUGHNESS;
        // Objects inside glass are seen through its back.
        m.single_sided = !source.value("doubleSided", false);
    }
    if (transmitted > 0 && transmission.contains("transmissionTexture"))
        r.ignored.insert("textures of transmission");
    // Blended glass transmits light instead.
    if (!transmits || alpha_mode == "MASK") read_holes(r, source, base.a, maps);
    const Json &normal = member(source, "normalTexture");
    maps.normal = texture_use(r, normal, false);
    maps.normal_scale = bounded(normal.value("scale", 1.0), -100, 100);
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

// ---- Meshes

glm::dmat4 local_transform(const Json &node) {
    const Json &matrix = member(node, "matrix");
    if (!matrix.empty()) return glm::dmat4(Transform(numbers(node, "matrix", glm::dmat4(1))));
    const glm::dvec4 r = numbers(node, "rotation", glm::dvec4(0, 0, 0, 1));
    glm::dmat4 t = glm::scale(mat4_cast(normalize(glm::dquat(r.w, r.x, r.y, r.z))),
                              numbers(node, "scale", glm::dvec3(1)));
    t[3] = glm::dvec4(numbers(node, "translation", glm::dvec3(0)), 1);
    return t;
}

// The unit vector along t * v; zero if it does not exist.
Vec3 direction(const glm::dmat3 &t, glm::dvec3 v) {
    v = t * v;
    const double size = length(v);
    return size > 0 && std::isfinite(size) ? Vec3(v / size) : Vec3(0);
}

void read_primitive(Reader &r, const Json &primitive, const Transform &transform) {
    const int64_t mode = integer(primitive, "mode", 4);
    if (mode < 4 || mode > 6) {
        r.ignored.insert("points and lines");
        return;
    }
    if (!member(primitive, "targets").empty()) r.ignored.insert("morph targets");
    const Json &attributes = member(primitive, "attributes");
    if (!attributes.contains("POSITION")) return; // glTF says to skip these
    const Elements &positions = elements(r, attributes, "POSITION", {"VEC3"});
    const size_t count = positions.count;
    // Other attributes have the same number of elements, or none.
    const auto optional = [&](const char *name,
                              const std::set<std::string> &types) -> const Elements & {
        static const Elements none = {};
        if (!attributes.contains(name)) return none;
        const Elements &values = elements(r, attributes, name, types);
        if (values.count != count) throw Error("has ", name, " of another count than POSITION");
        return values;
    };
    const Elements &normals = optional("NORMAL", {"VEC3"}),
                   &tangents = optional(normals.width == 0 ? "" : "TANGENT", {"VEC4"}),
                   &colours = optional("COLOR_0", {"VEC3", "VEC4"}),
                   *coordinates[] = {&optional("TEXCOORD_0", {"VEC2"}),
                                     &optional("TEXCOORD_1", {"VEC2"})};

    // The cofactor matrix transforms normals correctly under any scale. Mirroring would flip them,
    // so its cofactors are negated.
    const glm::dmat3 m(transform);
    const glm::dmat3 cofactors(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    const bool mirrored = dot(m[0], cofactors[0]) < 0;
    const glm::dmat3 normal_matrix = mirrored ? -cofactors : cofactors;
    const auto at = [](const Elements &values, size_t i, double otherwise) {
        return values.width == 0 ? glm::dvec4(otherwise) : values[i];
    };
    const bool indexed = primitive.contains("indices");
    const Elements &order = indexed ? elements(r, primitive, "indices", {"SCALAR"}) : positions;
    std::vector<uint32_t> indices(order.count);
    for (size_t i = 0; i < indices.size(); ++i) {
        indices[i] = indexed ? uint32_t(order[i].x) : uint32_t(i);
        if (indices[i] >= count)
            throw Error("has an index out of range: vertex ", indices[i], " of ", count);
    }
    // Only the vertices that triangles use count, and each once.
    r.place.resize(std::max(r.place.size(), count), UINT32_MAX);
    for (const uint32_t i : indices) {
        if (r.place[i] != UINT32_MAX) continue;
        if (r.points.size() == MAX_ELEMENTS) throw Error("has more than 2^26 vertices");
        r.place[i] = uint32_t(r.points.size());
        const Point3d position = transform * positions[i];
        if (!is_finite(position) || max_magnitude(position) > MAX_COORDINATE)
            throw Error("has a vertex that is not a finite number, or beyond 1e15");
        r.points.push_back(position);
        r.scene.normals.push_back(direction(normal_matrix, at(normals, i, 0)));
        r.scene.colours.push_back(clamp(at(colours, i, 1), 0.0, 1.0));
        for (int set = 0; set < 2; ++set)
            r.scene.texture_coordinates[set].push_back(at(*coordinates[set], i, 0));
    }

    const uint32_t material = material_number(r, integer(primitive, "material"), colours.width > 0);
    for (size_t i = 0; i + 2 < indices.size(); i += mode == 4 ? 3 : 1) {
        std::array<size_t, 3> corners = {i, i + 1, i + 2};
        if (mode == 5) corners = {i, i + 1 + i % 2, i + 2 - i % 2};
        if (mode == 6) corners = {i + 1, i + 2, 0};
        if (mirrored) std::swap(corners[1], corners[2]);
        Triangle triangle{{}, material};
        for (size_t c = 0; c < 3; ++c) {
            const uint32_t vertex = indices[corners[c]];
            triangle.vertices[c] = r.place[vertex];
            const glm::dvec4 tangent = at(tangents, vertex, 0);
            const float sign = (tangent.w < 0) != mirrored ? -1 : 1;
            r.scene.tangents.push_back({direction(m, tangent), sign});
        }
        r.scene.triangles.push_back(triangle);
    }
    for (const uint32_t i : indices) r.place[i] = UINT32_MAX;
}

// ---- Nodes

void read_nodes(Reader &r) {
    std::vector<std::pair<const Json *, Transform>> open; // a stack of nodes still to be read
    std::set<const Json *> reached;
    const auto reach = [&](const Json &children, const Transform &parent) {
        for (auto child = children.rbegin(); child != children.rend(); ++child) {
            const int64_t at = child->is_number_unsigned() ? child->get<int64_t>() : -1;
            const Json &node = element(r.json, "nodes", at);
            if (!reached.insert(&node).second)
                throw Error("reaches node ", at, " twice: its nodes do not form a tree");
            open.push_back({&node, parent});
        }
    };
    const Json &scenes = member(r.json, "scenes");
    if (!scenes.empty())
        reach(member(element(r.json, "scenes", integer(r.json, "scene", 0)), "nodes"),
              Transform(1));
    if (scenes.size() > 1) r.ignored.insert("scenes but the default one");
    while (!open.empty()) {
        const auto [at, parent] = open.back();
        open.pop_back();
        const Json &node = *at;
        const Transform transform = parent * local_transform(node);
        if (node.contains("mesh"))
            for (const Json &primitive :
                 member(element(r.json, "meshes", integer(node, "mesh")), "primitives"))
                read_primitive(r, primitive, transform);
        if (node.contains("skin")) r.ignored.insert("skins");
        if (node.contains("camera") || !extension(node, "KHR_lights_punctual").empty())
            r.placed.push_back({&node, transform});
        reach(member(node, "children"), transform);
    }
}

// ---- Converting the results to a scene

// Moves the centre of the points to the origin, so that floats keep their significant digits.
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

// Makes tangents if a file has none, after Mikkelsen ("Simulation of Wrinkled Surfaces Revisited",
// 2008): at each vertex, the mean over the faces that share its position, normal and texture
// coordinates, weighted by their angles there. Faces with mirrored textures share none.
void make_tangents(Scene &scene) {
    std::map<std::array<float, 9>, Vec3> sums;
    std::vector<std::pair<glm::vec4 *, const Vec3 *>> corners;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const int32_t maps = material_of(scene, uint32_t(i)).maps;
        glm::vec4 *const tangents = &scene.tangents[3 * i];
        if (maps < 0 || scene.maps[maps].normal.texture < 0 || Vec3(tangents[0]) != Vec3(0))
            continue;
        const TextureUse &map = scene.maps[maps].normal;
        Vec3 p[3], n[3];
        Vec2 uv[3];
        for (size_t c = 0; c < 3; ++c) {
            const uint32_t vertex = scene.triangles[i].vertices[c];
            p[c] = scene.vertices[vertex];
            n[c] = scene.normals[vertex];
            uv[c] = map.transform * Vec3(scene.texture_coordinates[map.set][vertex], 1);
        }
        const Vec2 u = uv[1] - uv[0], v = uv[2] - uv[0];
        const float turn = u.x * v.y - u.y * v.x > 0 ? 1 : -1;
        const Vec3 along = turn * (v.y * (p[1] - p[0]) - u.y * (p[2] - p[0]));
        const Vec3 flat = normalize_or(cross(p[1] - p[0], p[2] - p[0]), {});
        for (size_t c = 0; c < 3; ++c) {
            if (n[c] == Vec3(0)) n[c] = flat;
            Vec3 &sum =
                sums[{p[c].x, p[c].y, p[c].z, n[c].x, n[c].y, n[c].z, uv[c].x, uv[c].y, turn}];
            const Vec3 a = normalize_or(p[(c + 1) % 3] - p[c], {}),
                       b = normalize_or(p[(c + 2) % 3] - p[c], {});
            sum += std::acos(std::clamp(dot(a, b), -1.0f, 1.0f)) *
                   normalize_or(along - dot(along, n[c]) * n[c], {});
            tangents[c].w = dot(n[c], flat) < 0 ? turn : -turn;
            corners.push_back({&tangents[c], &sum});
        }
    }
    for (const auto &[tangent, sum] : corners)
        *tangent = glm::vec4(normalize_or(*sum, {}), tangent->w);
}

// A camera's target is the point on its axis nearest to the scene's centre.
void read_camera(Reader &r, const Json &node, const glm::dmat3 &turn, Vec3 position) {
    const Json &source = element(r.json, "cameras", integer(node, "camera"));
    const Vec3 forward = direction(turn, {0, 0, -1}), up = direction(turn, {0, 1, 0});
    const double angle = member(source, "perspective").value("yfov", 0.0);
    if (source.value("type", "") != "perspective") {
        r.ignored.insert("orthographic cameras");
    } else if (!(max_magnitude(cross(forward, up)) > 1e-3f) || !(angle > 1e-4 && angle < 3.1)) {
        r.ignored.insert("a camera without direction or angle");
    } else {
        Camera camera{};
        camera.position = position;
        camera.tan_half_height = float(std::tan(0.5 * angle));
        camera_turn(camera, forward, up);
        const float ahead = -dot(position, camera.forward);
        camera.target = position + (ahead > 0 ? ahead : 1) * camera.forward;
        camera.name = without_controls(node.value("name", source.value("name", "")));
        r.scene.cameras.push_back(camera);
    }
}

void read_light(Reader &r, const Json &node, const glm::dmat3 &turn, Vec3 position) {
    const std::map<std::string, Light::Kind> kinds = {
        {"point", Light::POINT}, {"spot", Light::SPOT}, {"directional", Light::DIRECTIONAL}};
    const Json &source = element(extension(r.json, "KHR_lights_punctual"), "lights",
                                 integer(extension(node, "KHR_lights_punctual"), "light"));
    const auto kind = kinds.find(source.value("type", ""));
    Light light{};
    light.corner = position;
    light.normal = direction(turn, {0, 0, -1});
    if (kind == kinds.end() ||
        (kind->second != Light::POINT && !(max_magnitude(light.normal) > 0))) {
        r.ignored.insert("lights of unknown kinds or without a direction");
        return;
    }
    light.kind = kind->second;
    const Vec3 tint = numbers(source, "color", glm::dvec3(1));
    const auto intensity = float(source.value("intensity", 1.0));
    light.radiance = (r.options.photometric ? intensity / LUMENS_PER_WATT : intensity) * tint;
    if (!is_finite(light.radiance) || std::min({tint.x, tint.y, tint.z}) < 0)
        throw Error("has a light whose intensity is negative or not a number");
    const Json &cone = member(source, "spot");
    light.cosine_inner = float(std::cos(cone.value("innerConeAngle", 0.0)));
    light.cosine_outer = float(std::cos(cone.value("outerConeAngle", 0.25 * double(PI))));
    if (source.value("range", 0.0) > 0) r.ignored.insert("the range of lights");
    r.scene.lights.push_back(light);
}

// Cameras and lights both point along their node's -z axis.
void read_cameras_and_lights(Reader &r) {
    for (const auto &[node, t] : r.placed) {
        if (!is_finite(t[3]) || max_magnitude(t[3]) > MAX_COORDINATE) {
            r.ignored.insert("a camera or a light beyond 1e15");
            continue;
        }
        const glm::dmat3 turn(t);
        const Vec3 position = t[3] - r.scene.origin;
        if (node->contains("camera")) read_camera(r, *node, turn, position);
        if (!extension(*node, "KHR_lights_punctual").empty()) read_light(r, *node, turn, position);
    }
}

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
// emission does not, nor does emission up to a display's white, the maximum of glTF's emissiveFactor: a
// scene with glowing eyes, labels and switches keeps its sky.
bool make_area_lights(Reader &r) {
    Scene &scene = r.scene;
    bool lit = false;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        const uint32_t material = scene.triangles[i].material;
        const Emission &emission = r.emission[material];
        if (!(max_component(emission.radiance) > 0)) continue;
        const auto &t = scene.triangles[i].vertices;
        const Vec3 corner = scene.vertices[t[0]];
        Light light = area_light(Light::TRIANGLE, corner, scene.vertices[t[1]] - corner,
                                 scene.vertices[t[2]] - corner, emission.radiance);
        light.both_sides = emission.both_sides;
        bool lamp = max_component(emission.radiance) > MAX_GLOW;
        if (const int32_t number = scene.materials[material].maps; number >= 0) {
            const SurfaceMaps &maps = scene.maps[number];
            const Vec3 mean = mean_emission(scene, uint32_t(i));
            lamp = lamp && maps.emission.texture < 0 && max_component(mean) > 0;
            light.mapped = maps.emission.texture >= 0 || maps.alpha_cutoff > 0;
            // The area between the points gets a small weight, so that it is sampled, too.
            if (light.mapped) light.radiance = mean + 0.01f * emission.mean;
        }
        if (!(max_component(light.radiance) > 0)) continue;
        lit = lit || lamp;
        scene.triangles[i].light = int32_t(scene.lights.size());
        scene.lights.push_back(light);
    }
    return lit;
}

// A three-quarter front view, slightly from above, that just fits everything into a square image.
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
    camera.frames_square = true;
    return camera;
}

} // namespace

bool is_scene_file(const std::string &name) {
    const std::string end = std::filesystem::path(name).extension();
    return strcasecmp(end.c_str(), ".gltf") == 0 || strcasecmp(end.c_str(), ".glb") == 0;
}

Scene scene_file_read(const std::string &path, const SceneOptions &options) {
    try {
        Reader r(path, options);
        for (const std::string used : member(r.json, "extensionsUsed"))
            if (!is_known(used)) r.ignored.insert("the extension " + used);
        if (!member(r.json, "animations").empty()) r.ignored.insert("animations");
        read_nodes(r);
        Scene &scene = r.scene;
        if (scene.triangles.empty()) throw Error("has no triangles to render");
        recentre(r);
        make_tangents(scene);
        if (scene.maps.empty()) { // then nothing looks these up
            scene.texture_coordinates[0] = scene.texture_coordinates[1] = {};
            scene.colours = scene.tangents = {};
        }
        const auto none = [](Vec3 n) { return !(max_magnitude(n) > 0); };
        if (std::all_of(scene.normals.begin(), scene.normals.end(), none)) scene.normals = {};
        read_cameras_and_lights(r);
        scene.camera = scene.cameras.empty() ? framing_camera(scene) : scene.cameras[0];
        const bool punctual = !scene.lights.empty(), lamps = make_area_lights(r);
        scene.environment = options.environment;
        if (!scene.environment && !punctual && !lamps)
            scene.environment = std::make_shared<Environment>(environment_read("sky"));
        std::string ignored;
        for (const std::string &what : r.ignored) ignored += (ignored.empty() ? "" : ", ") + what;
        if (!ignored.empty()) scene.notes.push_back(path + ": ignores " + ignored);
        return std::move(scene);
    } catch (const Json::exception &error) {
        const std::string what = error.what(); // it ends with part of the file, which may be long
        throw Error(path, ": is not valid glTF 2.0: ", what.substr(0, what.find("; last read")));
    } catch (const Error &error) {
        throw Error(path, ": ", error.what());
    }
}
