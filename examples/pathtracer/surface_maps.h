// SPDX-License-Identifier: Apache-2.0
// Material properties that vary over a surface: textures and vertex colours, looked up at each hit
// on a material that has any. Other materials cost one comparison.
#pragma once

#include <cstdint>

#include <glm/mat3x2.hpp>

#include "material.h"
#include "math.h"

struct Scene;

// How a material uses a texture.
struct TextureUse {
    int32_t texture = -1; // index into Scene::textures; -1: none
    uint32_t set = 0;     // of texture coordinates, 0 or 1
    // From vertex coordinates to texture coordinates, times (u, v, 1).
    glm::mat3x2 transform{1};
};

struct SurfaceMaps {
    TextureUse colour;              // times Material::albedo
    TextureUse metallic_roughness;  // blue times metallic, green times roughness
    TextureUse roughness, metallic; // the same, each from red
    TextureUse emission;            // times emission_factor
    TextureUse normal;              // in tangent space
    TextureUse cut_out;             // alpha, or red where the texture has none
    Vec3 emission_factor = {0, 0, 0};
    float normal_scale = 1;
    float alpha = 1, alpha_cutoff = 0; // cut out if alpha times the texture's is below
    bool vertex_colours = false;       // times Material::albedo
};

// A point on a triangle: the barycentric weights of its second and third vertex.
struct SurfacePoint {
    uint32_t triangle;
    float u, v;
};

// The material at a point; material.maps must not be -1.
Material material_at(const Scene &scene, const Material &material, SurfacePoint point);

// The emission at a point of a material with an emission map.
Vec3 emission_at(const Scene &scene, SurfacePoint point);

// The mean emission over the whole texture of an emission map.
Vec3 mean_emission(const Scene &scene, const SurfaceMaps &maps);

// The mean of emission_at() over a few points of a triangle, plus a small share of the mean of the
// whole texture, so that it is zero only if the texture is black everywhere.
Vec3 mean_emission(const Scene &scene, uint32_t triangle, Vec3 whole_texture);

// Whether the surface is cut out at this point.
bool is_cut_out(const Scene &scene, SurfacePoint point);

// The shading normal, bent by the material's normal map if it has one.
Vec3 mapped_normal(const Scene &scene, SurfacePoint point, Vec3 normal);
