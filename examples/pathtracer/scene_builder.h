// SPDX-License-Identifier: Apache-2.0
// Functions that build scenes in code.
#pragma once

#include "scene.h"

uint32_t add_diffuse(Scene &scene, Vec3 albedo);
uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness, Vec3 edge = {1, 1, 1});
uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed = {1, 1, 1});

// A quadrilateral, its corners counter-clockwise as seen from its front. It need not be flat.
void add_quad(Scene &scene, Surface surface, Vec3 a, Vec3 b, Vec3 c, Vec3 d);
void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// A parallelogram light. It emits to the side from which a, b, c are counter-clockwise.
void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);
// The same, given by its centre and a point that it faces; its upper edge is level.
void add_light_towards(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
                       float width, float height);

// A triangle light that emits from its front.
void add_triangle_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);

// A block that stands on the floor: the four corners of its top in order around it,
// counter-clockwise as seen from above. It has no bottom.
void add_block(Scene &scene, uint32_t material, float height, const Vec2 (&corners)[4]);

// A box given by its centre and three half-extents; its front is outside if x, y, z are
// right-handed.
void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 x, Vec3 y, Vec3 z);

// A sphere of `around` meridians and half as many rings, shaded smoothly.
void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around = 96);

// A cylinder between two points, shaded smoothly, without end caps.
void add_bar(Scene &scene, uint32_t material, Vec3 a, Vec3 b, float radius, int around = 16);

// A profile of (z, y) points swept from x0 to x1 > x0, shaded smoothly. Its front is on top where z
// increases along the profile.
void add_profile(Scene &scene, uint32_t material, float x0, float x1,
                 const std::vector<Vec2> &profile);
