// SPDX-License-Identifier: Apache-2.0
// Functions that build scenes in code.
#pragma once

#include <functional>

#include "scene.h"

uint32_t add_diffuse(Scene &scene, Vec3 albedo);
uint32_t add_conductor(Scene &scene, Vec3 albedo, float roughness);
uint32_t add_dielectric(Scene &scene, float ior, float roughness, Vec3 passed = {1, 1, 1});

// A quadrilateral, its corners counter-clockwise as seen from its front. It need not be flat.
void add_quad(Scene &scene, Surface surface, Vec3 a, Vec3 b, Vec3 c, Vec3 d);
void add_quad(Scene &scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d);

// A parallelogram light. It emits to the side from which a, b, c are counter-clockwise.
void add_light(Scene &scene, uint32_t material, Vec3 radiance, Vec3 a, Vec3 b, Vec3 c);
// From its centre and a point that it faces; its upper edge is horizontal.
void add_light_towards(Scene &scene, uint32_t material, Vec3 radiance, Vec3 middle, Vec3 target,
                       float width, float height);

// A block on the floor, without a bottom, from the counter-clockwise corners of its top.
void add_block(Scene &scene, uint32_t material, float height, const Vec2 (&corners)[4]);

// From its centre and three right-handed half-axes.
void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 x, Vec3 y, Vec3 z);
void add_box(Scene &scene, uint32_t material, Vec3 middle, Vec3 half); // along the axes

// A smooth-shaded sphere with `around` meridians and half as many rings.
void add_sphere(Scene &scene, uint32_t material, Vec3 middle, float radius, int around = 96);

// A smooth-shaded cylinder between two points, without end caps.
void add_bar(Scene &scene, uint32_t material, Vec3 a, Vec3 b, float radius, int around = 16);

// A smooth-shaded sweep of a profile of (z, y) points, which faces up where z increases.
void add_profile(Scene &scene, uint32_t material, float x0, float x1,
                 const std::vector<Vec2> &profile);

// A sheet that curves up behind everything: from `top` along a quarter of a circle to `front`.
void add_backdrop(Scene &scene, uint32_t material, float half_width, Vec2 top, Vec2 centre,
                  float radius, Vec2 front);

// Lets everything added since vertex number `first` move: `end` is where a point ends.
void add_motion(Scene &scene, size_t first, const std::function<Vec3(Vec3)> &end);

// ---- The scenes listed in scene.cpp

Scene scene_cornell();
Scene scene_penumbra();
Scene scene_glossy();
Scene scene_lens();
Scene scene_motion();
Scene scene_glass();
Scene scene_interior();
Scene scene_fog();
Scene scene_furnace();
