// SPDX-License-Identifier: Apache-2.0
// Scenes from files: glTF 2.0 and OBJ. A reader makes a draft of what its file says, in double and
// where the file has it; what all of them need is done once: the scene is moved to the origin, what
// shines becomes a light, and a camera and a sky stand in for those that are missing.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "input_file.h"
#include "scene_options.h"

// Whether a name is that of a file, by its ending: .gltf, .glb or .obj in any case.
bool is_scene_file(const std::string &name);

// Reads a scene; it still has to be finished. An environment given takes the place of the sky.
// Throws Error.
Scene scene_file_read(const std::string &path, const SceneOptions &options);

// At most so many triangles, and so many vertices.
constexpr size_t MAX_SCENE_ELEMENTS = size_t{1} << 26;

struct DraftCamera {
    Point3d position;
    Vec3 forward, up; // unit vectors
    float tan_half_height;
    std::string name; // may be empty
};

struct DraftLight {
    Light light; // but for its corner
    Point3d position;
};

// What a material sends out by itself.
struct Emission {
    Vec3 radiance = {0, 0, 0}; // without its texture
    bool both_sides = false;
};

struct SceneDraft {
    Scene scene;                    // all but vertices, camera and lights
    std::vector<Point3d> points;    // its vertices; whatever a vertex has beside is in the scene
    std::vector<Emission> emission; // of each material
    std::vector<DraftLight> lights;
    std::vector<DraftCamera> cameras;
    std::set<std::string> ignored;            // what the file has and the scene has not
    size_t max_elements = MAX_SCENE_ELEMENTS; // vertices, and triangles, by the size of the files
    uint64_t bytes = 0;                       // of the file
    uint64_t texels = 0;                      // of all textures
};

// Says how large the file is, and what it has read from its folder: those that ask for much memory
// by using the same bytes again, or none at all, are refused.
void draft_set_input(SceneDraft &draft, uint64_t bytes, const SceneFolder &folder);

// Adds a vertex with everything a vertex may have, 0 where it lacks it. Throws Error when there are
// too many.
struct DraftVertex {
    Point3d position;
    Vec3 normal = {0, 0, 0};
    Vec2 coordinates[2] = {};
    Vec3 colour = {1, 1, 1};
};
uint32_t draft_add_vertex(SceneDraft &draft, const DraftVertex &vertex);
void draft_add_triangle(SceneDraft &draft, uint32_t material, uint32_t a, uint32_t b, uint32_t c);
// Adds a texture out of the bytes of its file; returns its number. Throws Error, its text to follow
// the picture's name.
int32_t draft_add_texture(SceneDraft &draft, const std::vector<unsigned char> &bytes,
                          const SceneFolder &folder);
uint32_t draft_add_material(SceneDraft &draft, const Material &material, const Emission &emission,
                            const SurfaceMaps &maps);

// Readers of a file, and through its folder of the files it names. Errors say what is wrong, without
// the file's name.
SceneDraft gltf_read(const std::string &path, SceneFolder &folder);
SceneDraft obj_read(const std::string &path, SceneFolder &folder);
