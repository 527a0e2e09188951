// SPDX-License-Identifier: Apache-2.0
// The parts of the glTF reader. tinygltf parses the file but hardly checks its contents: every
// index, offset and size is checked here before it is used.
#pragma once

#include <tiny_gltf.h>

#include <functional>
#include <string>
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
    if (index < 0 || static_cast<size_t>(index) >= list.size())
        throw Error("refers to ", what, " ", index, ", and has ", list.size());
    return list[index];
}

// ---- gltf_material.cpp

// A function that returns the draft's material for a material of the model (-1: the default one), with
// vertex colours or without. It reads materials and their textures on first use: image files that are
// not used may be missing. It throws Error; its arguments must outlive it.
std::function<uint32_t(int, bool)> gltf_material_reader(const tinygltf::Model &model,
                                                        SceneFolder &folder, SceneDraft &draft);

// A number in an extension, or `otherwise` if it is missing.
double gltf_number(const tinygltf::ExtensionMap &extensions, const char *extension,
                   const char *name, double otherwise);
