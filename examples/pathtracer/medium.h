// SPDX-License-Identifier: Apache-2.0
// A medium such as fog: a box of particles whose density varies from place to place. They scatter
// and absorb light, the same at every wavelength but for the colour of what they scatter.
//
//
// Density is extinction: the mean number of particles that a ray meets per unit of length. A walk goes
// along the ray as if the density were a larger one that is constant in each block of cells, and sorts
// out what it met there. medium_free_flight decides by chance whether a meeting is real (Woodcock et
// al., "Techniques Used in the GEM Code for Monte Carlo Neutronics Calculations", 1965).
// medium_transmittance multiplies by the share that is not real (Novak, Selle and Jarosz, "Residual
// Ratio Tracking for Estimating Attenuation in Participating Media", 2014). Both are unbiased.
#pragma once

#include <bn/bn.hpp>

#include <functional>
#include <vector>

#include "camera.h"
#include "material.h"

struct Medium {
    static constexpr int BLOCK = 4; // cells, each way
    struct Range {
        float least, most; // density
    };
    Vec3 low, high;             // corners of the box
    glm::ivec3 size;            // in cells
    std::vector<float> density; // at the middle of each cell; x changes fastest, then y.
                                // Linear in between, constant in the outer halves of cells
    glm::ivec3 blocks;
    std::vector<Range> ranges; // of each block
    Material material;         // how particles scatter: PHASE
};

// A box of size.x x size.y x size.z cells of density(point) >= 0. `albedo` is the share of light that
// particles scatter, `anisotropy` in (-1, 1) the mean cosine by which they turn it.
Medium medium_create(Vec3 low, Vec3 high, glm::ivec3 size, Vec3 albedo, float anisotropy,
                     const std::function<float(Vec3)> &density);

float medium_density(const Medium &medium, Vec3 point);

// How far a ray flies to a particle, or infinity if it comes as far as `end` first.
float medium_free_flight(const Medium &medium, const Ray &ray, float end, bn::LoopSampler &numbers);

// An estimate of the share of light that passes along a ray as far as `end`.
float medium_transmittance(const Medium &medium, const Ray &ray, float end,
                           bn::LoopSampler &numbers);

// ---- The phase function of Henyey and Greenstein ("Diffuse Radiation in the Galaxy", 1941), for
// materials of kind PHASE: `wi` in a frame whose +z points back along the ray.

// Its value, which is also the density of phase_sample.
float phase_pdf(float anisotropy, Vec3 wi);

Vec3 phase_sample(float anisotropy, Vec2 u);
