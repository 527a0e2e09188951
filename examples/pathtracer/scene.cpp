// SPDX-License-Identifier: Apache-2.0
// The scenes built in code, each there for a reason:
//
// cornell: the box measured at Cornell (Goral et al., "Modeling the Interaction of Light Between
// Diffuse Surfaces", 1984; dimensions, camera and materials as the programme of computer graphics
// published them, the spectra as linear RGB in common use). Soft shadows, colour bleeding, several
// bounces.
//
// furnace: a closed cube that emits what one of its bounces absorbs, so every picture of it is
// known without rendering: radiance 1 - 2^-(bounces + 1) in every pixel. A check, not a sight.
#include "scene.h"

#include "error.h"

namespace {

uint32_t add_material(Scene &scene, Vec3 albedo) {
    scene.materials.push_back({albedo});
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

// A quadrilateral, its corners counter-clockwise as seen from its front. It need not be flat.
void add_quad(Scene &scene, Surface surface, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.insert(scene.vertices.end(), {a, b, c, d});
    scene.triangles.push_back({{first, first + 1, first + 2}});
    scene.triangles.push_back({{first, first + 2, first + 3}});
    scene.surfaces.insert(scene.surfaces.end(), 2, surface);
}

void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    add_quad(scene, Surface{material, -1}, a, b, c, d);
}

// A parallelogram that shines to the side from which a, b, c run counter-clockwise.
void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 edge_u = b - a, edge_v = c - b;
    const Vec3 normal = cross(edge_u, edge_v);
    const auto light = static_cast<int32_t>(scene.lights.size());
    scene.lights.push_back({a, edge_u, edge_v, normalize(normal), length(normal), radiance});
    add_quad(scene, Surface{material, light}, a, b, c, a + edge_v);
}

// A block that stands on the floor: the four corners of its top in order around it. It has no
// bottom.
void add_block(Scene &scene, uint32_t material, float height, const Vec2 (&corners)[4]) {
    const auto at = [](Vec2 corner, float y) { return Vec3{corner.x, y, corner.y}; };
    add_quad(scene, material, at(corners[0], height), at(corners[1], height),
             at(corners[2], height), at(corners[3], height));
    for (int i = 0; i < 4; ++i) {
        const Vec2 p = corners[i], q = corners[(i + 1) % 4];
        add_quad(scene, material, at(p, 0), at(q, 0), at(q, height), at(p, height));
    }
}

// Lengths in millimetres as measured; y is up, the open side is at z = 0.
Scene build_cornell() {
    Scene scene;
    const float sensor_height = 0.025f, focal_length = 0.035f;
    scene.camera = camera_look_at({278, 273, -800}, {278, 273, 0}, {0, 1, 0},
                                  0.5f * sensor_height / focal_length);

    const uint32_t white = add_material(scene, {0.725f, 0.71f, 0.68f});
    const uint32_t red = add_material(scene, {0.63f, 0.065f, 0.05f});
    const uint32_t green = add_material(scene, {0.14f, 0.45f, 0.091f});
    const uint32_t lamp = add_material(scene, {0.78f, 0.78f, 0.78f});

    const float top = 548.8f, back = 559.2f;
    const float lamp_x0 = 213, lamp_x1 = 343, lamp_z0 = 227, lamp_z1 = 332;

    add_light(scene, lamp, {17, 12, 4}, {lamp_x0, top, lamp_z0}, {lamp_x1, top, lamp_z0},
              {lamp_x1, top, lamp_z1});
    // The lamp sits in a hole of the ceiling, so that no two surfaces lie in each other.
    const auto ceiling = [&](float x0, float x1, float z0, float z1) {
        add_quad(scene, white, {x0, top, z0}, {x1, top, z0}, {x1, top, z1}, {x0, top, z1});
    };
    ceiling(0, 556, 0, lamp_z0);
    ceiling(0, 556, lamp_z1, back);
    ceiling(0, lamp_x0, lamp_z0, lamp_z1);
    ceiling(lamp_x1, 556, lamp_z0, lamp_z1);

    add_quad(scene, white, {552.8f, 0, 0}, {0, 0, 0}, {0, 0, back}, {549.6f, 0, back});
    add_quad(scene, white, {549.6f, 0, back}, {0, 0, back}, {0, top, back}, {556, top, back});
    add_quad(scene, green, {0, 0, back}, {0, 0, 0}, {0, top, 0}, {0, top, back});
    add_quad(scene, red, {552.8f, 0, 0}, {549.6f, 0, back}, {556, top, back}, {556, top, 0});

    add_block(scene, white, 165, {{130, 65}, {82, 225}, {240, 272}, {290, 114}});
    add_block(scene, white, 330, {{423, 247}, {265, 296}, {314, 456}, {472, 406}});
    return scene;
}

Scene build_furnace() {
    Scene scene;
    scene.camera = camera_look_at({0.1f, 0.2f, -0.3f}, {1, 0.5f, 1}, {0, 1, 0}, 0.8f);
    const uint32_t wall = add_material(scene, {0.5f, 0.5f, 0.5f});
    const Vec3 glow = {0.5f, 0.5f, 0.5f};
    add_light(scene, wall, glow, {-1, -1, -1}, {-1, -1, 1}, {1, -1, 1});
    add_light(scene, wall, glow, {-1, 1, -1}, {1, 1, -1}, {1, 1, 1});
    add_light(scene, wall, glow, {-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1});
    add_light(scene, wall, glow, {1, -1, -1}, {1, -1, 1}, {1, 1, 1});
    add_light(scene, wall, glow, {-1, -1, -1}, {1, -1, -1}, {1, 1, -1});
    add_light(scene, wall, glow, {-1, -1, 1}, {-1, 1, 1}, {1, 1, 1});
    return scene;
}

} // namespace

const std::vector<SceneEntry> &scene_entries() {
    static const std::vector<SceneEntry> entries = {
        {"cornell", "the Cornell box: one area light, diffuse walls and blocks", build_cornell},
        {"furnace", "a closed glowing cube of known radiance: a check", build_furnace},
    };
    return entries;
}

Scene scene_build(const std::string &name) {
    std::string known;
    for (const SceneEntry &entry : scene_entries()) {
        if (name == entry.name) return entry.build();
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    throw Error("there is no scene '" + name + "'; the scenes are " + known);
}
