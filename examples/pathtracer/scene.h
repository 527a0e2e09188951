// SPDX-License-Identifier: Apache-2.0
// Scenes: plain arrays of surfaces, materials and lights, and the list of those built in code.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "camera.h"
#include "light.h"
#include "material.h"
#include "surface_maps.h"
#include "texture.h"

// Counter-clockwise as seen from its front.
struct Triangle {
    uint32_t vertices[3];
};

struct Surface {
    uint32_t material;
    int32_t light; // index of the light the surface is, or -1
};

struct NamedCamera {
    Camera camera;
    std::string name; // may be empty
};

struct Scene {
    Camera camera{};                  // to be rendered with
    std::vector<NamedCamera> cameras; // of its own; none when `camera` is made up
    Point3d origin = {0, 0, 0};       // of these coordinates, in those of the scene's file
    std::vector<Vec3> vertices;
    std::vector<Vec3> normals; // of vertices, for smooth shading: for each vertex, or none. A
                               // normal of length zero means the triangle's own
    std::vector<Vec2> texture_coordinates[2]; // two sets, each for every vertex, or for none
    std::vector<Vec3> colours;                // likewise; linear
    std::vector<Triangle> triangles;
    std::vector<Surface> surfaces; // one for each triangle
    std::vector<Material> materials;
    std::vector<SurfaceMaps> maps; // of materials that have any
    std::vector<Texture> textures;
    bool has_cut_outs = false;     // is_cut_out() is to be asked at each hit
    bool has_single_sided = false; // any material is
    std::vector<Light> lights;
    std::shared_ptr<const Environment> environment; // empty: rays that leave see black
    uint32_t light_samples = 1; // at the first surface a path meets; one at all others

    // What scene_finish adds.
    std::vector<float> light_limits; // how lights are chosen, see distribution.h
    int32_t environment_light =
        -1; // the light that the environment is, or -1 when it is not sampled
    uint32_t dropped_triangles = 0; // without area

    std::vector<std::string> notes; // what of a scene's file was left out, for the user
};

// Makes a scene ready to render, whoever built it: drops triangles without area and lights without
// power, turns the environment into a light, and prepares lights and materials. Throws Error when a
// vertex is not finite.
void scene_finish(Scene &scene);

// The float vertices of a scene whose points are known in double, as those of files are once their
// transformations are applied: the middle of their extent is taken off each, so that they keep
// their digits where they need them. Returns the middle, to be taken off cameras and lights as
// well.
Point3d recentre(const std::vector<Point3d> &points, std::vector<Vec3> &vertices);

// The normal to shade a hit with: `normal`, turned to the side of `wo`, or the one interpolated
// between vertices or bent by a map where there is such. Materials that reflect get one that
// mirrors `wo` above the surface, diffuse ones one that has `wo` on its front.
Vec3 shading_normal(const Scene &scene, uint32_t triangle, float u, float v, Vec3 normal, Vec3 wo);

// A normal to shade with, bent as little as it takes that `wo` is mirrored above the surface,
// whose normal is `geometric`: else mirrors under a normal map have black spots where they would
// show the inside of what they cover (Keller et al., "The Iray Light Transport Simulation and
// Rendering System", 2017, adapt shading normals in this way). `wo` is on the front of the
// surface.
Vec3 mirroring_normal(Vec3 normal, Vec3 geometric, Vec3 wo);

struct SceneEntry {
    const char *name;
    const char *summary;
    Scene (*build)();
};

// The scenes built in code, in the order of --list.
const std::vector<SceneEntry> &scene_entries();

// Builds a scene by name, or reads one from a file named .gltf, .glb or .obj, and finishes it; an
// environment given takes the place of the scene's own, a camera chosen that of its first. Throws
// Error, naming the known ones or what is wrong with the file or the camera.
struct SceneOptions; // scene_options.h
Scene scene_build(const std::string &name, const SceneOptions &options);
