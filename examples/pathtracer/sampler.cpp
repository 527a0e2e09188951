// SPDX-License-Identifier: Apache-2.0
// Creates a sampler from its name on the command line.
#include "sampler.h"

#include "files.h"

const std::vector<SamplerEntry> &sampler_entries() {
    static const std::vector<SamplerEntry> entries = [] {
        std::vector<SamplerEntry> all = {
            {"blue", "progressive blue noise in both pairs of every domain", BN_SAMPLER_BLUE},
            {"sobol", "padded Owen-scrambled Sobol', independent in each pixel", BN_SAMPLER_SOBOL},
            {"white", "independent uniform numbers", BN_SAMPLER_WHITE},
            {"zorder", "Sobol' along a Morton curve, for a declared count", BN_SAMPLER_ZORDER},
            {"mask", "a blue-noise mask drives padded Sobol'", BN_SAMPLER_MASK},
        };
#ifdef BN_WITH_PEERS
        for (const SamplerEntry &entry : peer_entries()) all.push_back(entry);
#endif
        return all;
    }();
    return entries;
}

SamplerPointer sampler_create(const std::string &name, uint64_t seed, uint32_t declared_spp) {
#ifdef BN_WITH_PEERS
    if (const size_t colon = name.find(':'); colon != std::string::npos)
        return std::make_unique<Sampler>(
            Sampler{{}, peer_from_file(name.substr(0, colon), name.substr(colon + 1), seed)});
#endif
    const SamplerEntry *chosen = nullptr;
    std::string known;
    for (const SamplerEntry &entry : sampler_entries()) {
        if (name == entry.name) chosen = &entry;
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    if (!chosen) throw Error("there is no sampler '", name, "'; the samplers are ", known);
    if (chosen->peer && declared_spp > 0)
        throw Error("--declare is for the samplers of libbn, not for '", name, "'; leave it out");
    bn::Sampler library = chosen->type == BN_SAMPLER_ZORDER
                              ? bn::Sampler::zorder(declared_spp, seed)
                              : bn::Sampler(static_cast<bn::Type>(chosen->type), seed);
    return std::make_unique<Sampler>(Sampler{library, chosen->peer ? chosen->peer(seed) : nullptr});
}
