// SPDX-License-Identifier: Apache-2.0
// The parts of the glTF reader. tinygltf takes the file apart and hardly checks what is in it:
// every number that leads to another place is checked here before it is followed.
#pragma once

#include <tiny_gltf.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "error.h"
#include "input_file.h"
#include "scene_file.h"

// ---- gltf_check.cpp

// Refuse the text of a .gltf, and a .glb, that tinygltf would follow too far: JSON nested deeper
// than its stack or of too many parts, chunks beyond the file. Throw Error.
void gltf_check_text(const char *text, size_t size);
void gltf_check_binary(const std::vector<unsigned char> &bytes);

// ---- gltf_accessor.cpp

// The elements of an accessor as numbers: `components` for each, integers scaled to [0, 1] or
// [-1, 1] where they are marked as normalized; at most `limit` of them, as they need not be in the
// file. `what` names them in an error. Throws Error.
std::vector<float> gltf_floats(const tinygltf::Model &model, int accessor, int components,
                               size_t limit, const char *what);

// The number of components of an accessor's elements, 0 where there is no such accessor.
int gltf_components(const tinygltf::Model &model, int accessor);

// The elements of an accessor of indices, each below `limit`. Throws Error.
std::vector<uint32_t> gltf_indices(const tinygltf::Model &model, int accessor, size_t limit);

// The bytes of a buffer view. Throws Error.
struct GltfBytes {
    const unsigned char *data;
    size_t size, stride; // stride 0: packed
};
GltfBytes gltf_buffer_view(const tinygltf::Model &model, int view, const char *what);

// An element of a list of the model, or an Error that says it is not there.
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
    // The draft's material for one of the model's (-1: the default one), read when it is first
    // asked for, and so are its textures: what is not used need not be there. Throws Error.
    uint32_t get(int material, bool vertex_colours);

  private:
    uint32_t read(int material, bool vertex_colours);
    TextureUse texture(int index, int set, const tinygltf::ExtensionMap &extensions, bool srgb);
    int32_t load(int index, bool srgb);

    const tinygltf::Model &model_;
    SceneFolder &folder_;
    SceneDraft &draft_;
    std::map<std::pair<int, bool>, uint32_t> materials_;
    std::map<std::pair<int, bool>, int32_t> textures_;
};

// A number of an extension, or what stands for it.
double gltf_number(const tinygltf::ExtensionMap &extensions, const char *extension,
                   const char *name, double otherwise);
