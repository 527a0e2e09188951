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
// the reasons; README.md lists what else the path tracer does to keep noise blue.
#pragma once

#include <bn/bn.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "math.h"
#ifdef BN_WITH_PEERS
#include "path_tracer_peers.h"
#endif

// Other projects' samplers, for comparison: evidence/programs adds them to builds with tests.
class PeerSampler;
using PeerPointer = std::shared_ptr<const PeerSampler>;
constexpr uint64_t PEER_INDEX_LIMIT = uint64_t{1} << 31;

struct Sampler {
    bn::Sampler library;
    PeerPointer peer; // draws in place of `library`, unless null
};
using SamplerPointer = std::unique_ptr<const Sampler>;

struct SamplerEntry {
    const char *name;
    const char *summary;
    int32_t type;                                 // BN_SAMPLER_..., for libbn's samplers
    PeerPointer (*peer)(uint64_t seed) = nullptr; // creates a sampler that is not libbn's
};

// libbn's samplers, then those of peer_entries().
const std::vector<SamplerEntry> &sampler_entries();

std::vector<SamplerEntry> peer_entries();
// For the name "NAME:PATH". Throws Error.
PeerPointer peer_from_file(const std::string &name, const std::string &path, uint64_t seed);

// The sampler of this name. `declared_spp` is for "zorder"; 0 means unknown. Throws Error that
// lists the known samplers.
SamplerPointer sampler_create(const std::string &name, uint64_t seed = 0,
                              uint32_t declared_spp = 0);

// Returns visit(path) for sample `index` of a pixel. The path is a bn::PathSampler or PeerPath.
template <typename Visit>
auto with_path(const Sampler &sampler, int32_t x, int32_t y, uint32_t index, Visit visit) {
#ifdef BN_WITH_PEERS
    if (sampler.peer) return visit(PeerPath{*sampler.peer, x, y, index});
#endif
    return visit(bn::PathSampler(sampler.library, x, y, index));
}
