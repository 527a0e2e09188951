// SPDX-License-Identifier: Apache-2.0
// Building blocks for scenes built in code.
#include "scene_builder.h"

namespace {

uint32_t add_material(Scene &scene, Material::Kind kind, Vec3 albedo, float roughness = 0,
                      float ior = 1.5f) {
    Material material;
    material.kind = kind;
    material.albedo = albedo;
    material.roughness = roughness;
    material.ior = ior;
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

void add_vertex(Scene &scene, Vec3 position, Vec3 normal) {
    // Zero marks earlier vertices as having no normal.
    scene.normals.resize(scene.vertices.size(), {0, 0, 0});
    scene.vertices.push_back(position);
    scene.normals.push_back(normal);
}

void add_triangle(Scene &scene, Surface surface, uint32_t a, uint32_t b, uint32_t c) {
    scene.triangles.push_back({{a, b, c}});
    scene.surfaces.push_back(surface);
}

} // namespace

uint32_t add_diffuse(Scene &scene, Vec3 albedo) {
    return add_material(scene, Material::DIFFUSE, albedo);
}

uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness) {
    return add_material(scene, Material::CONDUCTOR, albedo, roughness);
}

uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed) {
    return add_material(scene, Material::DIELECTRIC, passed, roughness, ior);
}

void add_quad(Scene &scene, Surface surface, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    scene.vertices.insert(scene.vertices.end(), {a, b, c, d});
    add_triangle(scene, surface, first, first + 1, first + 2);
    add_triangle(scene, surface, first, first + 2, first + 3);
}

void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
    add_quad(scene, Surface{material, -1}, a, b, c, d);
}

void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c) {
    const auto number = static_cast<int32_t>(scene.lights.size());
    scene.lights.push_back(area_light(Light::PARALLELOGRAM, a, b - a, c - b, radiance));
    add_quad(scene, Surface{material, number}, a, b, c, a + (c - b));
}

void add_light_towards(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
                       float width, float height) {
    const Vec3 normal = normalize(target - middle);
    const Vec3 x = normalize_or(cross({0, 1, 0}, normal), {1, 0, 0});
    const Vec3 half_x = (0.5f * width) * x, half_y = (0.5f * height) * cross(normal, x);
    add_light(scene, material, radiance, middle - half_x - half_y, middle + half_x - half_y,
              middle + half_x + half_y);
}

void add_block(Scene &scene, uint32_t material, float height, const Vec2 (&corners)[4]) {
    const auto at = [](Vec2 corner, float y) { return Vec3{corner.x, y, corner.y}; };
    add_quad(scene, material, at(corners[0], height), at(corners[1], height),
             at(corners[2], height), at(corners[3], height));
    for (int i = 0; i < 4; ++i) {
        const Vec2 p = corners[i], q = corners[(i + 1) % 4];
        add_quad(scene, material, at(p, 0), at(q, 0), at(q, height), at(p, height));
    }
}

void add_box(Scene &scene, uint32_t material, Vec3 m, Vec3 x, Vec3 y, Vec3 z) {
    const auto face = [&](Vec3 out, Vec3 a, Vec3 b) { // a, b, out right-handed
        add_quad(scene, material, m + out - a - b, m + out + a - b, m + out + a + b,
                 m + out - a + b);
    };
    face(x, y, z), face(-x, z, y);
    face(y, z, x), face(-y, x, z);
    face(z, x, y), face(-z, y, x);
}

void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 half) {
    add_box(scene, material, middle, {half.x, 0, 0}, {0, half.y, 0}, {0, 0, half.z});
}

void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around) {
    const int rings = around / 2;
    const auto top = static_cast<uint32_t>(scene.vertices.size());
    for (int ring = 0; ring <= rings; ++ring)
        for (int column = 0; column < around; ++column) {
            const float theta = PI * static_cast<float>(ring) / static_cast<float>(rings);
            const float phi = 2 * PI * static_cast<float>(column) / static_cast<float>(around);
            const Vec3 n = {std::sin(theta) * std::cos(phi), std::cos(theta),
                            std::sin(theta) * std::sin(phi)};
            add_vertex(scene, middle + radius * n, n);
        }
    const auto index = [&](int ring, int column) {
        return top + static_cast<uint32_t>(ring * around + column % around);
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int column = 0; column < around; ++column) {
            const uint32_t a = index(ring, column), b = index(ring, column + 1);
            const uint32_t c = index(ring + 1, column), d = index(ring + 1, column + 1);
            if (ring > 0) add_triangle(scene, {material, -1}, a, b, c);
            if (ring + 1 < rings) add_triangle(scene, {material, -1}, b, d, c);
        }
}

void add_bar(Scene &scene, uint32_t material, Vec3 a, Vec3 b, float radius, int around) {
    const glm::mat3 frame = frame_around(normalize(b - a));
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    for (int i = 0; i < around; ++i) {
        const float phi = 2 * PI * static_cast<float>(i) / static_cast<float>(around);
        const Vec3 n = std::cos(phi) * frame[0] + std::sin(phi) * frame[1];
        add_vertex(scene, a + radius * n, n);
        add_vertex(scene, b + radius * n, n);
    }
    for (int i = 0; i < around; ++i) {
        const auto p = first + static_cast<uint32_t>(2 * i);
        const auto q = first + static_cast<uint32_t>(2 * ((i + 1) % around));
        add_triangle(scene, {material, -1}, p, q, q + 1);
        add_triangle(scene, {material, -1}, p, q + 1, p + 1);
    }
}

void add_profile(Scene &scene, uint32_t material, float x0, float x1,
                 const std::vector<Vec2> &profile) {
    const auto first = static_cast<uint32_t>(scene.vertices.size());
    for (size_t i = 0; i < profile.size(); ++i) {
        const Vec2 before = profile[i > 0 ? i - 1 : 0];
        const Vec2 after = profile[std::min(i + 1, profile.size() - 1)];
        const Vec3 n = normalize(Vec3{0, after.x - before.x, before.y - after.y});
        add_vertex(scene, {x0, profile[i].y, profile[i].x}, n);
        add_vertex(scene, {x1, profile[i].y, profile[i].x}, n);
    }
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const auto p = first + static_cast<uint32_t>(2 * i);
        add_triangle(scene, {material, -1}, p, p + 2, p + 3);
        add_triangle(scene, {material, -1}, p, p + 3, p + 1);
    }
}

void add_backdrop(Scene &scene, uint32_t material, float half_width, Vec2 top, Vec2 centre,
                  float radius, Vec2 front) {
    constexpr int PARTS = 24;
    std::vector<Vec2> sheet = {top};
    for (int i = 0; i <= PARTS; ++i) {
        const float angle = 0.5f * PI * static_cast<float>(i) / PARTS;
        sheet.push_back({centre.x - radius * std::cos(angle), centre.y - radius * std::sin(angle)});
    }
    sheet.push_back(front);
    add_profile(scene, material, -half_width, half_width, sheet);
}

void add_motion(Scene &scene, size_t first, const std::function<Vec3(Vec3)> &end) {
    scene.motions.resize(scene.vertices.size(), {0, 0, 0});
    for (size_t i = first; i < scene.vertices.size(); ++i)
        scene.motions[i] = end(scene.vertices[i]) - scene.vertices[i];
}
