// SPDX-License-Identifier: Apache-2.0
// The metallic-roughness material of glTF. Directions are as in material.h, above the surface.
#pragma once

#include "material.h"

// The BRDF times the cosine of `wi`, and the density with which mixture_sample() chooses it.
struct MixtureValue {
    Vec3 eval;
    float pdf;
};

MixtureValue mixture_value(const Material &material, Vec3 wo, Vec3 wi);

MaterialSample mixture_sample(const Material &material, Vec3 wo, Vec2 u);
