// SPDX-License-Identifier: Apache-2.0
// How the path tracer uses libbn. Read this first when you integrate the library into a renderer.
//
// The integrator draws from a bn::PathSampler, which bn/bn_path.h documents. Its decisions use
//
//     ray 0            draw()     pixel position; light where the ray ends, or the lens
//     ray d            draw()     direction off surface d; light where the ray ends
//                      next_1d()  lobe of rough glass, and then Russian roulette
//                      draw_loop(0) free flight through a medium
//                      draw_loop(k + 1) transmittance towards light sample k where the ray ends
//     first_light()    in place of ray 0's, if the lens uses that or the sample is split
//     time_wavelength() for the whole path, if anything moves
//
// No state is kept between samples, so threads, tiles and crops cannot change an image. docs/paths.md gives
// the reasons.
#pragma once

#include <bn/bn.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "math.h"
#include "plugin.h"

struct Sampler {
    bn::Sampler library;
    std::optional<Plugin> plugin = {}; // draws in place of `library`
};
using SamplerPointer = std::unique_ptr<const Sampler>;

struct SamplerEntry {
    const char *name;
    const char *summary;
    int32_t type; // BN_SAMPLER_...
};
const std::vector<SamplerEntry> &sampler_entries();

// The sampler of this name, or the plug-in "FILE" or "FILE:ARGUMENT". `declared_spp` is for "zorder" and
// plug-ins; 0 means unknown. Throws std::runtime_error.
SamplerPointer sampler_create(const std::string &name, uint64_t seed = 0,
                              uint32_t declared_spp = 0);

// Returns visit(path) for sample `index` of a pixel. The path is a bn::PathSampler or a PluginPath.
template <typename Visit>
auto with_path(const Sampler &sampler, int32_t x, int32_t y, uint32_t index, Visit visit) {
    if (sampler.plugin) return visit(PluginPath(*sampler.plugin, x, y, index));
    return visit(bn::PathSampler(sampler.library, x, y, index));
}
