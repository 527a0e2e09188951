// SPDX-License-Identifier: Apache-2.0
// Scenes from files: glTF 2.0 and OBJ. A reader makes a draft of its file, in double and in the
// file's own coordinates. Shared code then moves the scene to the origin, turns emissive triangles
// into lights, and adds a camera and a sky where they are missing.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "input_file.h"
#include "scene.h"

// Whether a name is that of a scene file: it ends in .gltf, .glb or .obj, in upper or lower case.
bool is_scene_file(const std::string &name);

// Reads a scene; scene_finish must still be called. An environment in the options replaces the sky.
// Throws Error.
Scene scene_file_read(const std::string &path, const SceneOptions &options);

// The most triangles, and the most vertices, of a scene.
constexpr size_t MAX_SCENE_ELEMENTS = size_t{1} << 26;

// A number of a file, clamped; what is not a number becomes `low`.
inline float bounded(double value, double low = 0, double high = 1) {
    return static_cast<float>(value > low ? std::min(value, high) : low);
}

template <typename Number>
Vec3 bounded_colour(const Number *rgb, double high = 1) {
    return {bounded(rgb[0], 0, high), bounded(rgb[1], 0, high), bounded(rgb[2], 0, high)};
}

struct DraftCamera {
    Point3d position;
    Vec3 forward, up; // unit vectors
    float tan_half_height;
    std::string name; // may be empty
};

struct DraftLight {
    Light light; // except its corner
    Point3d position;
};

// The light that a material emits.
struct Emission {
    Vec3 radiance = {0, 0, 0}; // without its texture
    bool both_sides = false;
};

struct SceneDraft {
    Scene scene;                    // all but vertices, camera and lights
    std::vector<Point3d> points;    // its vertices; their other attributes are in the scene
    std::vector<Emission> emission; // of each material
    std::vector<DraftLight> lights;
    std::vector<DraftCamera> cameras;
    std::set<std::string> ignored; // what the file has and the scene lacks
};

// Adds a vertex; missing attributes have the values below. Throws Error if there are too many
// vertices, or if the position is not finite or beyond 1e15.
struct DraftVertex {
    Point3d position;
    Vec3 normal = {0, 0, 0};
    Vec2 coordinates[2] = {};
    Vec3 colour = {1, 1, 1};
};
uint32_t draft_add_vertex(SceneDraft &draft, const DraftVertex &vertex);
void draft_add_triangle(SceneDraft &draft, uint32_t material, uint32_t a, uint32_t b, uint32_t c);
// Decodes the bytes of an image file and adds the texture; returns its number. Throws Error, which
// names the image.
int32_t draft_add_texture(SceneDraft &draft, const std::string &name, bool srgb,
                          const std::function<std::vector<unsigned char>()> &bytes);
uint32_t draft_add_material(SceneDraft &draft, const Material &material, const Emission &emission,
                            const SurfaceMaps &maps);

// Read a scene file, and through its folder the files it names. Errors say what is wrong, without
// the file's name.
SceneDraft gltf_read(SceneFolder &folder);
SceneDraft obj_read(SceneFolder &folder);
