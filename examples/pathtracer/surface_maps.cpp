// SPDX-License-Identifier: Apache-2.0
// Looks up textures and vertex colours at a point on a surface.
#include "scene.h"

namespace {

// Interpolates a vertex attribute over a triangle.
template <typename Value>
Value interpolated(const std::vector<Value> &values, const Triangle &t, SurfacePoint p) {
    const Value a = values[t.vertices[0]], b = values[t.vertices[1]], c = values[t.vertices[2]];
    return (1 - p.u - p.v) * a + p.u * b + p.v * c;
}

Vec2 transformed(const TextureUse &use, Vec2 uv) {
    return use.transform * Vec3(uv, 1);
}

const SurfaceMaps &maps_of(const Scene &scene, SurfacePoint p) {
    const Material &material = material_of(scene, p.triangle);
    return scene.maps[material.maps];
}

glm::vec4 looked_up(const Scene &scene, const TextureUse &use, SurfacePoint p) {
    const std::vector<Vec2> &coordinates = scene.texture_coordinates[use.set];
    const Vec2 uv = coordinates.empty() ? Vec2{0, 0}
                                        : interpolated(coordinates, scene.triangles[p.triangle], p);
    return texture_at(scene.textures[use.texture], transformed(use, uv));
}

} // namespace

Material material_at(const Scene &scene, const Material &material, SurfacePoint p) {
    Material m = material;
    const SurfaceMaps &maps = maps_of(scene, p);
    if (maps.vertex_colours && !scene.colours.empty())
        m.albedo *= interpolated(scene.colours, scene.triangles[p.triangle], p);
    if (maps.colour.texture >= 0) m.albedo *= Vec3(looked_up(scene, maps.colour, p));
    if (maps.metallic_roughness.texture >= 0) {
        const glm::vec4 texel = looked_up(scene, maps.metallic_roughness, p);
        m.metallic *= texel.b;
        m.roughness *= texel.g;
    }
    if (maps.roughness.texture >= 0) m.roughness *= looked_up(scene, maps.roughness, p).r;
    if (maps.metallic.texture >= 0) m.metallic *= looked_up(scene, maps.metallic, p).r;
    return m;
}

Vec3 emission_at(const Scene &scene, SurfacePoint p) {
    const SurfaceMaps &maps = maps_of(scene, p);
    return maps.emission_factor * Vec3(looked_up(scene, maps.emission, p));
}

Vec3 mean_emission(const Scene &scene, const SurfaceMaps &maps) {
    const Texture &texture = scene.textures[maps.emission.texture];
    return maps.emission_factor * texture_mean(texture);
}

Vec3 mean_emission(const Scene &scene, uint32_t triangle, Vec3 whole_texture) {
    const int rows = 6;
    const float share_of_whole = 0.01f;
    Vec3 sum = {0, 0, 0};
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < rows; ++x) {
            const Vec2 at = square_to_triangle(
                {(static_cast<float>(x) + 0.5f) / rows, (static_cast<float>(y) + 0.5f) / rows});
            sum += emission_at(scene, {triangle, at.x, at.y});
        }
    return (1.0f / (rows * rows)) * sum + share_of_whole * whole_texture;
}

bool is_cut_out(const Scene &scene, SurfacePoint p) {
    if (material_of(scene, p.triangle).maps < 0) return false;
    const SurfaceMaps &maps = maps_of(scene, p);
    float alpha = maps.alpha;
    if (maps.cut_out.texture >= 0) {
        const glm::vec4 texel = looked_up(scene, maps.cut_out, p);
        const Texture &texture = scene.textures[maps.cut_out.texture];
        alpha *= texture.has_alpha ? texel.a : texel.r;
    }
    return alpha < maps.alpha_cutoff;
}

Vec3 mapped_normal(const Scene &scene, SurfacePoint p, Vec3 normal) {
    const int32_t index = material_of(scene, p.triangle).maps;
    if (index < 0 || scene.maps[index].normal.texture < 0) return normal;
    const SurfaceMaps &maps = scene.maps[index];
    const std::vector<Vec2> &coordinates = scene.texture_coordinates[maps.normal.set];
    if (coordinates.empty()) return normal;

    // The directions on the surface in which u and v increase.
    const auto &t = scene.triangles[p.triangle].vertices;
    const Vec3 edge1 = scene.vertices[t[1]] - scene.vertices[t[0]];
    const Vec3 edge2 = scene.vertices[t[2]] - scene.vertices[t[0]];
    const Vec2 uv0 = transformed(maps.normal, coordinates[t[0]]);
    const Vec2 uv1 = transformed(maps.normal, coordinates[t[1]]) - uv0;
    const Vec2 uv2 = transformed(maps.normal, coordinates[t[2]]) - uv0;
    const float turn = uv1.x * uv2.y - uv1.y * uv2.x > 0 ? 1.0f : -1.0f;
    const auto along_surface = [&](Vec3 v) {
        return normalize_or(v - dot(v, normal) * normal, {0, 0, 0});
    };
    const Vec3 along_u = along_surface(turn * (uv2.y * edge1 - uv1.y * edge2));
    const Vec3 along_v = along_surface(turn * (uv1.x * edge2 - uv2.x * edge1));

    // Green points up in the image, v down.
    const Vec3 n = looked_up(scene, maps.normal, p);
    const float x = maps.normal_scale * (2 * n.x - 1), y = maps.normal_scale * (2 * n.y - 1);
    return normalize_or(x * along_u - y * along_v + (2 * n.z - 1) * normal, normal);
}
