// SPDX-License-Identifier: Apache-2.0
// How the path tracer uses libbn: the part to read first when putting the library into a renderer.
//
// Every decision of a path has a domain, and domains follow the call tree:
//
//     root - 0  camera ray        (0,1) position in the pixel   (2,3) light where it ends, or lens
//          - 1  scattered ray     (0,1) direction               (2,3) light where it ends
//               - 0  choices      (0) lobe of rough glass       (1) roulette
//          - 2  scattered ray     ...
//          - 3  first light       (0,1), where the lens has taken its place, or it is split
//          - 4  scattered ray     ...
//
// So a ray has one domain: where it goes, and which point of which light is tried where it ends.
// The two multiply in what a path is worth, and nothing is stratified together as closely as the
// pairs (0,1) and (2,3) of one domain. Rays are children of the root in their order: by the keys
// 0 to 3, 4 to 7 and so on they are families, the next best. Two-dimensional decisions stay on the
// pairs, where samples are blue. A new decision gets a domain of its own, and no other notices: a
// child of a child, like the choices, unless it multiplies with all that follows. A 2-D
// draw is the first half of the 4-D draw: where the second half is not needed, it is not drawn.
// Draws are pure functions of pixel, index and domain: nothing is stored, and threads, tiles and
// crops cannot change a picture. docs/sampling.md tells the whole story.
#pragma once

#include <bn/bn.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "math.h"

// A sampler of another library, for comparison. It has one key for every decision above, as the
// two halves of a 4-D draw are different decisions here: `key`, and `key + 1` for dimensions 2, 3.
class PeerSampler {
  public:
    static constexpr uint64_t INDEX_LIMIT = uint64_t{1} << 31;

    virtual ~PeerSampler() = default;
    // As draw() and draw_split() below; only the dimensions asked for are written.
    virtual void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
                      float *u) const = 0;
    virtual void draw_split(int32_t x, int32_t y, uint32_t index, uint32_t key, uint32_t count,
                            uint32_t k, float *u) const = 0;
};
using PeerPointer = std::unique_ptr<const PeerSampler>;

struct SamplerDelete {
    void operator()(bn_sampler *sampler) const { bn_sampler_destroy(sampler); }
};

struct Sampler {
    std::unique_ptr<bn_sampler, SamplerDelete> library;
    PeerPointer peer; // or null: then `library` draws

    // The domain of the root's child `key`, as draws take it, and that of its choices.
    uint32_t domain(uint32_t key) const {
        return peer ? 4 * key : bn_domain_child(BN_DOMAIN_ROOT, key);
    }
    uint32_t choices(uint32_t ray) const { return peer ? ray + 2 : bn_domain_child(ray, 0); }
};
using SamplerPointer = std::unique_ptr<const Sampler>;

struct SamplerEntry {
    const char *name;
    const char *summary;
    int32_t kind;                                 // BN_SAMPLER_..., of libbn's samplers
    PeerPointer (*peer)(uint64_t seed) = nullptr; // makes one of another library
};

// The samplers of libbn, then those of OpenQMC if the build has it: the order of --list.
const std::vector<SamplerEntry> &sampler_entries();

// Of openqmc.cpp: none in a build without it.
std::vector<SamplerEntry> openqmc_entries();

struct SamplerSettings {
    std::string name = "blue";
    uint64_t seed = 0;
    uint32_t declared_spp = 0; // 0: unknown
    std::string mask; // "builtin", "neural" or a greyscale PNG; only for the sampler "mask"
};

// Throws Error naming the known samplers, or saying what is wrong with the mask.
SamplerPointer sampler_create(const SamplerSettings &settings);

// Ray 0 is the camera's, ray b leaves the b-th surface.
inline uint32_t ray_domain(const Sampler &sampler, uint32_t ray) {
    return sampler.domain(ray < 3 ? ray : ray + 1);
}
inline uint32_t first_light_domain(const Sampler &sampler) {
    return sampler.domain(3);
}

// The sampler as one sample of one pixel sees it.
struct PixelSample {
    const Sampler *sampler;
    int32_t x, y;
    uint32_t index;
};

// Numbers in [0, 1); those not drawn are 0.
struct Draw {
    float u[4];
};

// The first `dimensions` of a domain: 2 or 4.
inline Draw draw(const PixelSample &s, uint32_t domain, int dimensions) {
    Draw result{};
    const bn_sampler *library = s.sampler->library.get();
    if (!library)
        s.sampler->peer->draw(s.x, s.y, s.index, domain, dimensions, result.u);
    else if (dimensions == 2)
        bn_sample_2d(library, s.x, s.y, s.index, domain, result.u);
    else
        bn_sample_4d(library, s.x, s.y, s.index, domain, result.u);
    return result;
}

// The first two dimensions of part k of the `count` that this sample is split into.
inline Draw draw_split(const PixelSample &s, uint32_t domain, uint32_t count, uint32_t k) {
    if (count == 1 || s.sampler->library)
        return draw({s.sampler, s.x, s.y, s.index * count + k}, domain, 2);
    Draw result{};
    s.sampler->peer->draw_split(s.x, s.y, s.index, domain, count, k, result.u);
    return result;
}

inline Vec2 pair01(const Draw &d) {
    return {d.u[0], d.u[1]};
}
inline Vec2 pair23(const Draw &d) {
    return {d.u[2], d.u[3]};
}
