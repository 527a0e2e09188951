// SPDX-License-Identifier: Apache-2.0
// Scenes: plain arrays of surfaces, materials and lights, built in code or read from a file.
#pragma once

#include <optional>

#include <glm/mat3x2.hpp>

#include "camera.h"
#include "files.h"
#include "image.h"
#include "light.h"
#include "material.h"
#include "medium.h"

struct Triangle {
    uint32_t vertices[3]; // counter-clockwise as seen from its front
    uint32_t material;
    int32_t light = -1; // index of the light that it is, or -1
};

// How a material uses a texture.
struct TextureUse {
    int32_t texture = -1; // index into Scene::textures; -1: none
    uint32_t set = 0;     // texture coordinate set, 0 or 1
    // Maps vertex coordinates, as (u, v, 1), to texture coordinates.
    glm::mat3x2 transform{1};
};

// Material properties that vary over a surface, looked up at each hit on a material that has maps.
struct SurfaceMaps {
    TextureUse colour;             // times Material::albedo
    TextureUse metallic_roughness; // blue times metallic, green times roughness
    TextureUse emission;           // times emission_factor
    TextureUse normal;             // in tangent space
    TextureUse cut_out;            // alpha
    Vec3 emission_factor = {0, 0, 0};
    float normal_scale = 1;
    // Cut out where the product of alpha, texture alpha and vertex alpha is below the cut-off.
    float alpha = 1, alpha_cutoff = 0;
    bool vertex_colours = false; // times Material::albedo, and their fourth component times alpha
};

// A point on a triangle: the barycentric weights of its second and third vertices.
struct SurfacePoint {
    uint32_t triangle;
    float u, v;
};

// Arrays marked "per vertex" hold one element per vertex, or are empty.
struct Scene {
    Camera camera{};             // the one to render with
    std::vector<Camera> cameras; // defined by the scene; empty if `camera` is made up
    Point3d origin = {0, 0, 0};  // origin of the coordinates below, in scene file coordinates
    std::vector<Vec3> vertices;
    std::vector<Vec3> normals; // per vertex, for smooth shading; zero: the triangle's own
    std::vector<Vec3> motions; // per vertex, on a straight line while the shutter is open
    std::vector<Vec2> texture_coordinates[2]; // per vertex
    std::vector<glm::vec4> colours;           // per vertex, linear
    // One per triangle corner, or empty. w is the sign of the bitangent, w cross(normal, tangent). A zero
    // vector means no tangent.
    std::vector<glm::vec4> tangents;
    std::vector<Triangle> triangles;
    std::vector<Material> materials;
    std::vector<SurfaceMaps> maps; // for the materials that have any
    std::vector<Texture> textures;
    bool has_cut_outs = false;     // call is_cut_out() at each hit
    bool has_single_sided = false; // whether any material is
    std::vector<Light> lights;
    std::shared_ptr<const Environment> environment; // null: rays that escape see black
    std::shared_ptr<const Medium> medium;           // null: all of space is clear
    uint32_t light_samples = 1;                     // at a path's first surface; one at all others

    // Set by scene_finish.
    LightTree light_tree;           // for choosing lights
    int32_t environment_light = -1; // index of the environment's light, or -1 if it is not sampled

    std::vector<std::string> notes; // tell the user what was left out of a scene file
    InputRecord inputs;             // the files that were read
};

inline const Material &material_of(const Scene &scene, uint32_t triangle) {
    return scene.materials[scene.triangles[triangle].material];
}

struct Bounds {
    Vec3 low, high;
};

// The bounds of the vertices; from infinity to -infinity if there are none.
Bounds scene_bounds(const Scene &scene);

// Prepares any scene for rendering: drops triangles without area and lights without power, turns
// the environment into a light, and prepares lights and materials. All vertices must be finite.
void scene_finish(Scene &scene);

// ---- At a hit

// Normals on the side of `wo`: the geometric normal, and the shading normal, interpolated from vertex
// normals and perturbed by a normal map if the scene has these. For reflecting materials, the shading
// normal reflects `wo` above the surface; for diffuse materials, `wo` is on its front. Vertex normals that
// point to the triangle's back define the front of a two-sided surface; others keep theirs.
struct ShadingNormals {
    Vec3 geometric, shading;
    bool front; // `wo` is on the front
};
ShadingNormals shading_normals(const Scene &scene, SurfacePoint point, Vec3 normal, Vec3 wo);

// The material at a point; material.maps must not be -1.
Material material_at(const Scene &scene, const Material &material, SurfacePoint point);

// The emission at a point of a material with maps: zero where it is cut out.
Vec3 emission_at(const Scene &scene, SurfacePoint point);

bool is_cut_out(const Scene &scene, SurfacePoint point);

// ---- Building and reading

struct SceneEntry {
    const char *name;
    const char *summary;
    Scene (*build)();
};

// The built-in scenes, in the order of --list, with what each one tests.
const std::vector<SceneEntry> &scene_entries();

struct SceneOptions {
    // The camera to render with. Points are in the scene file's coordinates. Unset fields keep the values of
    // the scene's camera.
    std::optional<uint32_t> camera; // which of the scene's cameras; the first by default
    std::optional<Point3d> eye, target;
    std::optional<double> fov;        // the vertical angle of view, in degrees
    std::optional<float> lens, focus; // the lens radius and the focus distance

    std::shared_ptr<const Environment> environment = {}; // replaces the scene's own; may be empty
    bool photometric = false; // a file's punctual lights are in candela and lux
};

// Builds a scene by name, or reads it from a .gltf or .glb file, and finishes it. Throws Error with a list
// of the known scenes, or with the problem in the file or the camera.
Scene scene_build(const std::string &name, const SceneOptions &options);

// In gltf.cpp: whether a name ends in .gltf or .glb, in upper or lower case, and a reader for these files.
// Call scene_finish after it. Throws Error.
bool is_scene_file(const std::string &name);
Scene scene_file_read(const std::string &path, const SceneOptions &options);

// ---- scenes.cpp: building scenes in code

uint32_t add_diffuse(Scene &scene, Vec3 albedo);
uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness);
uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed = {1, 1, 1});

// A quadrilateral with its corners counter-clockwise as seen from its front. It need not be flat.
void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d, int32_t light = -1);

// A parallelogram light that emits to the side from which a, b, c are counter-clockwise.
void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);
// The same, from its centre and a point it faces; its upper edge is horizontal.
void add_panel(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
               float width, float height);

// A box, from its centre and three right-handed half-axes.
void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 x, Vec3 y, Vec3 z);

// A smooth-shaded sphere with `around` meridians and half as many rings.
void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around = 96);

// Animates everything added since vertex `first`: `end` maps a point to its final position.
void add_motion(Scene &scene, size_t first, const std::function<Vec3(Vec3)> &end);

// ---- Text about a scene

// The options that reproduce a camera: "--eye 0,1,5 --target 0,0,0 --fov 40".
std::string camera_text(const Scene &scene, const Camera &camera);

// One line per camera of the scene.
std::string camera_list(const Scene &scene);

// The bounds of the vertices: "reaches from -1,0,-1 to 1,2,1".
std::string scene_extent_text(const Scene &scene);
