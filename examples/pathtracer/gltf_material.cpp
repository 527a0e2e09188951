// SPDX-License-Identifier: Apache-2.0
// Materials and textures of glTF. Full metal without a metallic-roughness texture becomes a
// conductor, a transmissive material a dielectric, one with neither metal nor coat diffuse; all
// others use glTF's metallic-roughness model.
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "gltf_parts.h"

namespace {

const tinygltf::Value *member(const tinygltf::ExtensionMap &extensions, const char *extension,
                              const char *name) {
    const auto found = extensions.find(extension);
    if (found == extensions.end() || !found->second.IsObject() || !found->second.Has(name))
        return nullptr;
    return &found->second.Get(name);
}

Vec3 colour(const std::vector<double> &factor, double high = 1) {
    return factor.size() < 3 ? Vec3(1) : bounded_colour(factor.data(), high);
}

const std::set<std::string> SUPPORTED = {"KHR_materials_ior", "KHR_materials_transmission",
                                         "KHR_materials_specular",
                                         "KHR_materials_emissive_strength"};

// Image formats that are not decoded. A texture may offer a PNG or JPEG as a fallback.
const std::pair<const char *, const char *> UNKNOWN_PICTURES[] = {{"EXT_texture_webp", "WebP"},
                                                                  {"EXT_texture_avif", "AVIF"},
                                                                  {"KHR_texture_basisu", "KTX2"},
                                                                  {"MSFT_texture_dds", "DDS"}};

std::string image_name(const tinygltf::Image &image, int number) {
    if (!image.uri.empty() && image.uri.compare(0, 5, "data:") != 0)
        return "image " + printable(image.uri);
    return "image " + std::to_string(number) +
           (image.name.empty() ? "" : " " + printable(image.name));
}

// The file name that a percent-encoded URI stands for.
std::string percent_decoded(const std::string &uri) {
    std::string name;
    for (size_t i = 0; i < uri.size(); ++i) {
        unsigned byte = 0;
        const char *const digits = uri.data() + i + 1;
        if (uri[i] == '%' && i + 2 < uri.size() &&
            std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
            name += static_cast<char>(byte);
            i += 2;
        } else {
            name += uri[i];
        }
    }
    return name;
}

// Names the image, and its format, of a texture that offers no PNG or JPEG.
std::string unreadable_picture(const tinygltf::Model &model, const tinygltf::Texture &texture) {
    for (const auto &[extension, kind] : UNKNOWN_PICTURES) {
        const double source = gltf_number(texture.extensions, extension, "source", -1);
        if (source >= 0 && source < static_cast<double>(model.images.size())) {
            const auto number = static_cast<int>(source);
            return image_name(model.images[number], number) + " (" + kind + ", not PNG or JPEG)";
        }
    }
    return "textures without a picture";
}

// The alpha of glTF's base colour.
double alpha_of(const tinygltf::Material &source) {
    const std::vector<double> &factor = source.pbrMetallicRoughness.baseColorFactor;
    return factor.size() == 4 ? factor[3] : 1.0;
}

// How strong the coat is that reflects without colour.
float coat_of(const tinygltf::Material &source) {
    return bounded(gltf_number(source.extensions, "KHR_materials_specular", "specularFactor", 1));
}

// Metal does not transmit. But a file that omits metallicFactor declares metal by default: if it
// also blends with an alpha below 1, it means glass.
bool transmits_light(const tinygltf::Material &source, float metallic) {
    const double factor =
        gltf_number(source.extensions, "KHR_materials_transmission", "transmissionFactor", 0);
    const bool blended = source.alphaMode == "BLEND" && alpha_of(source) < 1;
    return factor >= 0.5 && (metallic < 0.5f || blended);
}

Material factors_of(const tinygltf::Material &source) {
    const tinygltf::PbrMetallicRoughness &pbr = source.pbrMetallicRoughness;
    Material m;
    m.albedo = colour(pbr.baseColorFactor);
    m.metallic = bounded(pbr.metallicFactor);
    m.roughness = bounded(pbr.roughnessFactor);
    m.ior = bounded(gltf_number(source.extensions, "KHR_materials_ior", "ior", 1.5), 1, 10);
    const float coat = coat_of(source);
    if (coat < 1) { // a weaker coat acts like a lower index of refraction
        const float root = std::sqrt(coat) * (m.ior - 1) / (m.ior + 1);
        m.ior = (1 + root) / (1 - root);
    }
    return m;
}

// Reads materials and their textures, each once.
struct MaterialReader {
    const tinygltf::Model &model;
    SceneFolder &folder;
    SceneDraft &draft;
    std::map<std::pair<int, bool>, uint32_t> materials;
    std::map<std::pair<int, bool>, int32_t> textures;

    int32_t load(int index, bool srgb) {
        const auto [known, is_new] = textures.try_emplace({index, srgb}, -1);
        if (!is_new) return known->second;
        const tinygltf::Texture &texture = gltf_at(model.textures, index, "texture");
        if (texture.source < 0) {
            draft.ignored.insert(unreadable_picture(model, texture));
            return -1;
        }
        const tinygltf::Image &image = gltf_at(model.images, texture.source, "image");
        const auto read = [&]() -> std::vector<unsigned char> {
            if (image.bufferView >= 0) {
                const GltfBytes bytes = gltf_buffer_view(model, image.bufferView, "an image");
                return {bytes.data, bytes.data + bytes.size};
            }
            // If tinygltf read nothing, errors matter only now.
            return image.image.empty() ? folder.read(percent_decoded(image.uri)) : image.image;
        };
        known->second = draft_add_texture(draft, image_name(image, texture.source), srgb, read);
        Texture &loaded = draft.scene.textures.back();
        if (texture.sampler >= 0) {
            const tinygltf::Sampler &sampler = gltf_at(model.samplers, texture.sampler, "sampler");
            const auto wrap = [](int mode) {
                return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Texture::CLAMP
                       : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Texture::MIRROR
                                                                       : Texture::REPEAT;
            };
            loaded.wrap_u = wrap(sampler.wrapS);
            loaded.wrap_v = wrap(sampler.wrapT);
            loaded.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        }
        return known->second;
    }

    template <typename Info>
    TextureUse texture(const Info &info, bool srgb) {
        TextureUse use;
        if (info.index < 0) return use;
        const tinygltf::ExtensionMap &extensions = info.extensions;
        const char *const transform = "KHR_texture_transform";
        const auto pair = [&](const char *name, int i, double otherwise) {
            const tinygltf::Value *v = member(extensions, transform, name);
            if (!v || !v->IsArray() || v->ArrayLen() != 2 || !v->Get(i).IsNumber())
                return otherwise;
            return v->Get(i).GetNumberAsDouble();
        };
        const double turn = gltf_number(extensions, transform, "rotation", 0);
        const double sine = std::sin(turn), cosine = std::cos(turn);
        const double sx = pair("scale", 0, 1), sy = pair("scale", 1, 1);
        use.transform = glm::mat3x2(cosine * sx, -sine * sx, sine * sy, cosine * sy,
                                    pair("offset", 0, 0), pair("offset", 1, 0));
        const double set = gltf_number(extensions, transform, "texCoord", info.texCoord);
        if (!(set >= 0 && set <= 1)) {
            draft.ignored.insert("textures on a third set of coordinates");
            return use;
        }
        use.set = static_cast<uint32_t>(set);
        use.texture = load(info.index, srgb);
        return use;
    }

    void read_glass(const tinygltf::Material &source, Material &m) {
        m.kind = Material::DIELECTRIC;
        if (source.alphaMode == "BLEND") { // the uncovered part passes all colours
            const float cover = bounded(alpha_of(source));
            m.albedo = cover * m.albedo + (1 - cover) * Vec3{1, 1, 1};
        }
        if (member(source.extensions, "KHR_materials_transmission", "transmissionTexture"))
            draft.ignored.insert("textures of transmission");
        if (source.pbrMetallicRoughness.metallicRoughnessTexture.index >= 0)
            draft.ignored.insert("textures of roughness on what transmits");
    }

    void read_opaque(const tinygltf::Material &source, Material &m, SurfaceMaps &maps) {
        maps.metallic_roughness =
            texture(source.pbrMetallicRoughness.metallicRoughnessTexture, false);
        const bool all_metal = m.metallic == 1 && maps.metallic_roughness.texture < 0;
        const bool bare = m.metallic == 0 && coat_of(source) == 0;
        m.kind = all_metal ? Material::CONDUCTOR
                 : bare    ? Material::DIFFUSE
                           : Material::METALLIC_ROUGHNESS;
    }

    Emission read_emission(const tinygltf::Material &source, SurfaceMaps &maps) {
        Emission emission;
        emission.both_sides = source.doubleSided;
        const double strength = gltf_number(source.extensions, "KHR_materials_emissive_strength",
                                            "emissiveStrength", 1);
        if (source.emissiveFactor.size() == 3)
            emission.radiance = bounded(strength, 0, 1e9) * colour(source.emissiveFactor, 1e9);
        maps.emission_factor = emission.radiance;
        if (max_component(emission.radiance) > 0)
            maps.emission = texture(source.emissiveTexture, true);
        return emission;
    }

    void read_holes(const tinygltf::Material &source, bool transmits, SurfaceMaps &maps) {
        const double alpha = alpha_of(source);
        const bool mask = source.alphaMode == "MASK", blend = source.alphaMode == "BLEND";
        const bool picture_has_holes =
            maps.colour.texture >= 0 && draft.scene.textures[maps.colour.texture].has_alpha;
        if (!mask && !(blend && !transmits && (alpha < 1 || picture_has_holes))) return;
        maps.alpha = bounded(alpha);
        maps.alpha_cutoff = mask ? bounded(source.alphaCutoff, 0, 2) : 0.5f;
        if (picture_has_holes) maps.cut_out = maps.colour;
        if (blend) draft.ignored.insert("blending (what covers less than half is cut out)");
    }

    uint32_t read(int index, bool vertex_colours) {
        const tinygltf::Material standard;
        const tinygltf::Material &source =
            index < 0 ? standard : gltf_at(model.materials, index, "material");
        for (const char *name : {"specularTexture", "specularColorTexture", "specularColorFactor"})
            if (member(source.extensions, "KHR_materials_specular", name))
                draft.ignored.insert("colours and textures of coats");
        for (const auto &[extension, value] : source.extensions)
            if (SUPPORTED.count(extension) == 0)
                draft.ignored.insert("the extension " + printable(extension));

        Material m = factors_of(source);
        const bool transmits = transmits_light(source, m.metallic);
        SurfaceMaps maps;
        maps.vertex_colours = vertex_colours;
        maps.colour = texture(source.pbrMetallicRoughness.baseColorTexture, true);
        if (transmits)
            read_glass(source, m);
        else
            read_opaque(source, m, maps);
        // Glass stays two-sided: what is inside is seen through its back faces.
        m.single_sided = !source.doubleSided && !transmits;
        maps.normal = texture(source.normalTexture, false);
        maps.normal_scale = bounded(source.normalTexture.scale, -100, 100);
        const Emission emission = read_emission(source, maps);
        read_holes(source, transmits, maps);
        return draft_add_material(draft, m, emission, maps);
    }

    uint32_t get(int material, bool vertex_colours) {
        const auto known = materials.find({material, vertex_colours});
        if (known != materials.end()) return known->second;
        return materials[{material, vertex_colours}] = read(material, vertex_colours);
    }
};

} // namespace

double gltf_number(const tinygltf::ExtensionMap &extensions, const char *extension,
                   const char *name, double otherwise) {
    const tinygltf::Value *value = member(extensions, extension, name);
    return value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise;
}

std::function<uint32_t(int, bool)> gltf_material_reader(const tinygltf::Model &model,
                                                        SceneFolder &folder, SceneDraft &draft) {
    return [reader = MaterialReader{model, folder, draft, {}, {}}](int material,
                                                                   bool vertex_colours) mutable {
        return reader.get(material, vertex_colours);
    };
}
