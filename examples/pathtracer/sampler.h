// SPDX-License-Identifier: Apache-2.0
// How the path tracer uses libbn: the part to read first when putting the library into a renderer.
//
// Every decision of a path has a domain, and domains follow the call tree:
//
//     root - 0          pixel      (0,1) position in the pixel     (2,3) position on the lens
//          - 1 + 2 b    light      (0,1) which light, and where on it, at bounce b
//          - 2 + 2 b    scatter    (0,1) direction    (2) roulette    (3) which lobe
//
// The four dimensions of a domain serve what belongs together; two-dimensional decisions stay on
// the pairs (0,1) and (2,3), where samples are blue and stratified. Along a path effects multiply:
// the pixel's with the light's, the direction's with that of the next light. So the decisions of a
// path are children of one domain, numbered in their order: neighbours are stratified together.
// A new decision gets a domain of its own, a child of a child, and none of the others notices. A
// 2-D draw is the first half of the 4-D draw: where the second half is not needed, it is not drawn.
// Draws are pure functions of pixel, index and domain: nothing is stored, and threads, tiles and
// crops cannot change a picture. docs/sampling.md tells the whole story.
#pragma once

#include <bn/bn.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "math.h"

struct SamplerDelete {
    void operator()(bn_sampler *sampler) const { bn_sampler_destroy(sampler); }
};
using SamplerPointer = std::unique_ptr<bn_sampler, SamplerDelete>;

struct SamplerEntry {
    const char *name;
    const char *summary;
    int32_t kind; // BN_SAMPLER_...
};

// The samplers of libbn, in the order of --list.
const std::vector<SamplerEntry> &sampler_entries();

struct SamplerSettings {
    std::string name = "blue";
    uint64_t seed = 0;
    uint32_t declared_spp = 0; // 0: unknown
    std::string mask; // "builtin", "neural" or a greyscale PNG; only for the sampler "mask"
};

// Throws Error naming the known samplers, or saying what is wrong with the mask.
SamplerPointer sampler_create(const SamplerSettings &settings);

inline uint32_t pixel_domain() {
    return bn_domain_child(BN_DOMAIN_ROOT, 0);
}
inline uint32_t light_domain(uint32_t bounce) {
    return bn_domain_child(BN_DOMAIN_ROOT, 1 + 2 * bounce);
}
inline uint32_t scatter_domain(uint32_t bounce) {
    return bn_domain_child(BN_DOMAIN_ROOT, 2 + 2 * bounce);
}

// The sampler as one sample of one pixel sees it.
struct PixelSample {
    const bn_sampler *sampler;
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
    if (dimensions == 2)
        bn_sample_2d(s.sampler, s.x, s.y, s.index, domain, result.u);
    else
        bn_sample_4d(s.sampler, s.x, s.y, s.index, domain, result.u);
    return result;
}

inline Vec2 pair01(const Draw &d) {
    return {d.u[0], d.u[1]};
}
inline Vec2 pair23(const Draw &d) {
    return {d.u[2], d.u[3]};
}
