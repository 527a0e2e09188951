// SPDX-License-Identifier: Apache-2.0
// How the path tracer uses libbn. Read this first when putting the library into a renderer.
//
// Every decision of a path has a domain, in the layout of bn/bn_path.h:
//
//     camera ray      (0,1) position in the pixel   (2,3) light where it ends, or lens
//     scattered ray   (0,1) direction               (2,3) light where it ends
//       choices       (0) lobe of rough glass       (1) roulette
//     camera          (0,1) first light, if the lens has taken its place or it is split
//                     (2) time, where things move
//     loops           four numbers, and then a generator: free flight, transmittance
//
// So one domain serves a ray: its direction, and the point on a light that is tried where it ends.
// The two multiply in a path's contribution, and pairs (0,1) and (2,3) of one domain are stratified
// together best. Every 2-D decision gets a whole pair, as the blue noise is in the pairs. Give a
// new decision a domain of its own, and no other draw changes. A 2-D draw is the first half of the
// 4-D draw, so the second half is drawn only where it is needed. Draws are pure functions of pixel,
// index and domain: nothing is stored, and threads, tiles and crops cannot change a picture.
// docs/paths.md and docs/sampling.md have the details.
//
// A renderer with libbn alone writes `bn::Path path(sampler, x, y, index)` and draws from that. Here
// other libraries draw, too, so the domains are kept apart from the draws.
#pragma once

#include <bn/bn_path.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "math.h"
#include "peer.h"

struct Sampler {
    bn_sampler library; // of kind WHITE if a peer draws
    std::vector<uint32_t>
        mask_ranks;   // of `library`, which borrows them; empty for the built-in mask
    PeerPointer peer; // null if `library` draws
};
using SamplerPointer = std::unique_ptr<const Sampler>;

struct SamplerEntry {
    const char *name;
    const char *summary;
    int32_t kind;                                 // BN_SAMPLER_..., for libbn's samplers
    PeerPointer (*peer)(uint64_t seed) = nullptr; // creates a sampler that is not libbn's
};

// libbn's samplers, sobol4d, then OpenQMC's if the build includes it, in the order of --list.
const std::vector<SamplerEntry> &sampler_entries();

// In openqmc.cpp; empty in a build without OpenQMC.
std::vector<SamplerEntry> openqmc_entries();

struct SamplerSettings {
    std::string name = "blue";
    uint64_t seed = 0;
    uint32_t declared_spp = 0; // 0: unknown
    std::string mask;          // "builtin", "neural" or a greyscale PNG; for sampler "mask" only
};

// Throws Error that lists the known samplers or says what is wrong with the mask.
SamplerPointer sampler_create(const SamplerSettings &settings);

// The domains of a path, as passed to draws: libbn's, or the keys of a peer, four for each.
//
// Ray 0 leaves the camera; ray b leaves the b-th surface.
inline uint32_t ray_domain(const Sampler &sampler, uint32_t ray) {
    return sampler.peer ? 4 * (ray < BN_PATH_CAMERA_KEY ? ray : ray + 1)
                        : bn_path_ray_domain(bn_path_start(0, 0, 0, 0), ray);
}
// Dimensions (0, 1) are for the first light where it is apart, (2) is for time.
inline uint32_t camera_domain(const Sampler &sampler) {
    return sampler.peer ? 4 * BN_PATH_CAMERA_KEY : bn_path_camera_domain(bn_path_start(0, 0, 0, 0));
}
// Two further numbers of a ray, from its domain.
inline uint32_t choices_domain(const Sampler &sampler, uint32_t ray) {
    return sampler.peer ? ray + 2 : bn_ray_1d_domain(ray, 0);
}

// Loop k of a ray, from its domain. Peers' keys of rays lie below 2^14.
inline uint32_t loop_domain(const Sampler &sampler, uint32_t ray, uint32_t k) {
    return sampler.peer ? ray + ((k + 1) << 14) : bn_ray_split_domain(ray, k);
}

// One sample of one pixel, with its sampler.
struct PixelSample {
    const Sampler *sampler;
    int32_t x, y;
    uint32_t index;
};

// Numbers in [0, 1); those not drawn are 0.
struct Draw {
    float u[4];
};

// The first `dimensions` numbers of a domain: 2 or 4.
inline Draw draw(const PixelSample &s, uint32_t domain, int dimensions) {
    Draw result{};
    const bn_sampler *library = &s.sampler->library;
    if (s.sampler->peer)
        s.sampler->peer->draw(s.x, s.y, s.index, domain, dimensions, result.u);
    else if (dimensions == 2)
        bn_sample_2d(library, s.x, s.y, s.index, domain, result.u);
    else
        bn_sample_4d(library, s.x, s.y, s.index, domain, result.u);
    return result;
}

// Two numbers that decide one thing each, in u[0] and u[1]: libbn's `blue` arranges them singly.
inline Draw draw_choices(const PixelSample &s, uint32_t domain) {
    if (s.sampler->peer) return draw(s, domain, 2);
    Draw result{};
    bn_sample_pair(&s.sampler->library, s.x, s.y, s.index, domain, 2, result.u);
    return result;
}

// The first two dimensions of part k when this sample is split into `count` parts.
inline Draw draw_split(const PixelSample &s, uint32_t domain, uint32_t count, uint32_t k) {
    if (count == 1 || !s.sampler->peer)
        return draw({s.sampler, s.x, s.y, s.index * count + k}, domain, 2);
    Draw result{};
    s.sampler->peer->draw_split(s.x, s.y, s.index, domain, count, k, result.u);
    return result;
}

// The numbers of a loop without bound, such as a walk through a medium: four from the sampler, which
// are stratified, and from then on libbn's generator. This is bn_ray_rng() for all samplers.
using LoopNumbers = bn_rng;

inline LoopNumbers loop_start(const PixelSample &s, uint32_t domain) {
    const Draw first = draw(s, domain, 4);
    return {{first.u[0], first.u[1], first.u[2], first.u[3]},
            bn_draw_white_counter(bn_draw_seed(&s.sampler->library), static_cast<uint32_t>(s.x),
                                  static_cast<uint32_t>(s.y), s.index, domain),
            0};
}

inline float loop_next(LoopNumbers &numbers) {
    return bn_rng_1d(&numbers);
}

inline Vec2 pair01(const Draw &d) {
    return {d.u[0], d.u[1]};
}
inline Vec2 pair23(const Draw &d) {
    return {d.u[2], d.u[3]};
}
