// SPDX-License-Identifier: Apache-2.0
// What differs from place to place on a surface: textures and colours of vertices, looked up at
// each hit of a material that has any. All others cost one comparison.
#pragma once

#include <cstdint>

#include "material.h"
#include "math.h"

struct Scene;

// A texture as a material uses it.
struct TextureUse {
    int32_t texture = -1; // index into Scene::textures; -1: none
    uint32_t set = 0;     // of texture coordinates, 0 or 1
    // From the coordinates of the vertices to those of the texture: two rows of u, v, 1.
    float transform[2][3] = {{1, 0, 0}, {0, 1, 0}};
};

struct SurfaceMaps {
    TextureUse colour;              // times Material::albedo
    TextureUse metallic_roughness;  // blue times metallic, green times roughness
    TextureUse roughness, metallic; // the same from the red of two textures
    TextureUse emission;            // times emission_factor
    TextureUse normal;              // in the frame of the texture coordinates
    TextureUse cut_out;             // alpha, or red where the texture has none
    Vec3 emission_factor = {0, 0, 0};
    float normal_scale = 1;
    float alpha = 1, alpha_cutoff = 0; // cut out where alpha times the texture's is below
    bool vertex_colours = false;       // times Material::albedo
};

// A place on a triangle: the weights of its second and third vertex.
struct SurfacePoint {
    uint32_t triangle;
    float u, v;
};

// The material of a place. Its maps are not -1.
Material material_at(const Scene &scene, const Material &material, SurfacePoint point);

// What the material of a place with an emission map sends out.
Vec3 emission_at(const Scene &scene, SurfacePoint point);

// The mean of what an emission map makes of all of its texture.
Vec3 mean_emission(const Scene &scene, const SurfaceMaps &maps);

// The mean of emission_at() over a triangle, by a few points, and a little of the mean of its whole
// texture: so that it is zero only where no place of the texture shines.
Vec3 mean_emission(const Scene &scene, uint32_t triangle, Vec3 whole_texture);

// Whether the surface has a hole there.
bool is_cut_out(const Scene &scene, SurfacePoint point);

// A normal to shade with, bent by the normal map of the place's material if it has one.
Vec3 mapped_normal(const Scene &scene, SurfacePoint point, Vec3 normal);
