// SPDX-License-Identifier: Apache-2.0
// A heterogeneous medium such as fog: a box of particles that scatter and absorb light. Density is the
// same at every wavelength; only the colour of the scattered light varies.
//
// Density is extinction: a ray's mean number of collisions per unit length. Tracking uses a majorant
// that is constant in each block of cells. medium_free_flight is delta tracking, which accepts or
// rejects each collision at random (Woodcock et al., "Techniques Used in the GEM Code for Monte Carlo
// Neutronics Calculations", 1965). medium_transmittance is ratio tracking, which multiplies by the
// probability of rejection (Novak, Selle and Jarosz, "Residual Ratio Tracking for Estimating
// Attenuation in Participating Media", 2014). Both are unbiased.
#pragma once

#include <bn/bn.hpp>

#include <functional>
#include <vector>

#include "camera.h"
#include "material.h"

struct Medium {
    static constexpr int BLOCK = 4; // cells per axis
    struct Range {
        float least, most; // density
    };
    Vec3 low, high;             // corners of the box
    glm::ivec3 size;            // in cells
    std::vector<float> density; // at the middle of each cell; x changes fastest, then y.
                                // Linear in between, constant in the outer halves of cells
    glm::ivec3 blocks;
    std::vector<Range> ranges; // one per block
    Material material;         // how particles scatter: PHASE
};

// A box of size.x x size.y x size.z cells with density(point) >= 0. `albedo` is the single-scattering
// albedo, `anisotropy` in (-1, 1) the mean cosine of the scattering angle.
Medium medium_create(Vec3 low, Vec3 high, glm::ivec3 size, Vec3 albedo, float anisotropy,
                     const std::function<float(Vec3)> &density);

float medium_density(const Medium &medium, Vec3 point);

// The distance to a ray's next collision, or infinity if it reaches `end` first.
float medium_free_flight(const Medium &medium, const Ray &ray, float end, bn::LoopSampler &numbers);

// An estimate of the transmittance along a ray up to `end`.
float medium_transmittance(const Medium &medium, const Ray &ray, float end,
                           bn::LoopSampler &numbers);

// ---- The phase function of Henyey and Greenstein ("Diffuse Radiation in the Galaxy", 1941), for
// materials of type PHASE; `wi` is in a frame whose +z points back along the ray.

// The phase function's value, which is also the density of phase_sample.
float phase_pdf(float anisotropy, Vec3 wi);

Vec3 phase_sample(float anisotropy, Vec2 u);
