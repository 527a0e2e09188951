// SPDX-License-Identifier: Apache-2.0
// The parts of the glTF reader. tinygltf parses the file but hardly checks its contents: every
// index, offset and size is checked here before it is used.
#pragma once

#include <tiny_gltf.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "error.h"
#include "input_file.h"
#include "scene_file.h"

// ---- gltf_accessor.cpp

// Reads the elements of an accessor as floats, `components` each; normalized integers are scaled to
// [0, 1] or [-1, 1]. `what` names them in errors. Throws Error.
std::vector<float> gltf_floats(const tinygltf::Model &model, int accessor, int components,
                               const char *what);

// The number of components per element of an accessor; 0 if there is no such accessor.
int gltf_components(const tinygltf::Model &model, int accessor);

// Reads an accessor of indices, each of which must be below `limit`. Throws Error.
std::vector<uint32_t> gltf_indices(const tinygltf::Model &model, int accessor, size_t limit);

// The bytes of a buffer view. Throws Error.
struct GltfBytes {
    const unsigned char *data;
    size_t size, stride; // stride 0: packed
};
GltfBytes gltf_buffer_view(const tinygltf::Model &model, int view, const char *what);

// An element of one of the model's lists. Throws Error if the index is out of range.
template <typename Element>
const Element &gltf_at(const std::vector<Element> &list, int index, const char *what) {
    if (index < 0 || static_cast<size_t>(index) >= list.size()) {
        const std::string there = std::to_string(list.size());
        throw Error("refers to " + std::string(what) + " " + std::to_string(index) + ", and has " +
                    there);
    }
    return list[static_cast<size_t>(index)];
}

// ---- gltf_material.cpp

class GltfMaterials {
  public:
    GltfMaterials(const tinygltf::Model &model, SceneFolder &folder, SceneDraft &draft)
        : model_(model), folder_(folder), draft_(draft) {}
    // The draft's material for a material of the model (-1: the default one). Materials and their
    // textures are read on first use: image files that are not used may be missing. Throws Error.
    uint32_t get(int material, bool vertex_colours);

  private:
    uint32_t read(int material, bool vertex_colours);
    void read_glass(const tinygltf::Material &source, Material &m);
    void read_opaque(const tinygltf::Material &source, Material &m, SurfaceMaps &maps);
    Emission read_emission(const tinygltf::Material &source, SurfaceMaps &maps);
    void read_holes(const tinygltf::Material &source, bool transmits, SurfaceMaps &maps);
    template <typename Info> // TextureInfo, NormalTextureInfo
    TextureUse texture(const Info &info, bool srgb);
    int32_t load(int index, bool srgb);

    const tinygltf::Model &model_;
    SceneFolder &folder_;
    SceneDraft &draft_;
    std::map<std::pair<int, bool>, uint32_t> materials_;
    std::map<std::pair<int, bool>, int32_t> textures_;
};

// A number in an extension, or `otherwise` if it is missing.
double gltf_number(const tinygltf::ExtensionMap &extensions, const char *extension,
                   const char *name, double otherwise);
