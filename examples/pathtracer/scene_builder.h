// SPDX-License-Identifier: Apache-2.0
// The bricks of scenes built in code.
#pragma once

#include "scene.h"

uint32_t add_diffuse(Scene &scene, Vec3 albedo);
uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness, Vec3 edge = {1, 1, 1});
uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed = {1, 1, 1});

// A quadrilateral, its corners counter-clockwise as seen from its front. It need not be flat.
void add_quad(Scene &scene, Surface surface, Vec3 a, Vec3 b, Vec3 c, Vec3 d);
void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// A parallelogram that shines to the side from which a, b, c run counter-clockwise.
void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);
// The same around its middle, to shine towards a point; its upper edge is kept level.
void add_light_towards(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
                       float width, float height);

// A triangle that shines from its front.
void add_triangle_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);

// A block that stands on the floor: the four corners of its top in order around it,
// counter-clockwise as seen from above. It has no bottom.
void add_block(Scene &scene, uint32_t material, float height, const Vec2 (&corners)[4]);

// A box around three edges from its middle, which are half its extents; its front is outside when
// x, y, z are right-handed.
void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 x, Vec3 y, Vec3 z);

// A sphere of `around` meridians and half as many rings, shaded smoothly.
void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around = 96);

// A round bar between two points, shaded smoothly, without ends.
void add_bar(Scene &scene, uint32_t material, Vec3 a, Vec3 b, float radius, int around = 16);

// A profile of (z, y) points swept from x0 to x1 > x0, shaded smoothly. Its front is on top where z
// grows along the profile.
void add_profile(Scene &scene, uint32_t material, float x0, float x1,
                 const std::vector<Vec2> &profile);
