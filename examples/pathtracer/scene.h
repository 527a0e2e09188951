// SPDX-License-Identifier: Apache-2.0
// Scenes: plain arrays of surfaces, materials and lights, and the scenes built in code.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "camera.h"
#include "light.h"
#include "material.h"

// Counter-clockwise as seen from its front.
struct Triangle {
    uint32_t vertices[3];
};

struct Surface {
    uint32_t material;
    int32_t light; // index of the light the surface is, or -1
};

struct Scene {
    Camera camera;
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    std::vector<Surface> surfaces; // one for each triangle
    std::vector<Material> materials;
    std::vector<Light> lights;
};

struct SceneEntry {
    const char *name;
    const char *summary;
    Scene (*build)();
};

// The scenes built in code, in the order of --list.
const std::vector<SceneEntry> &scene_entries();

// Builds a scene by name. Throws Error naming the known ones.
Scene scene_build(const std::string &name);
