// SPDX-License-Identifier: Apache-2.0
// Samplers by their names on the command line: those of libbn, and plug-ins.
#include "sampler.h"

#include "files.h"

const std::vector<SamplerEntry> &sampler_entries() {
    static const std::vector<SamplerEntry> entries = {
        {"blue", "progressive blue noise in both pairs of every domain", BN_SAMPLER_BLUE},
        {"sobol", "padded Owen-scrambled Sobol', independent in each pixel", BN_SAMPLER_SOBOL},
        {"white", "independent uniform numbers", BN_SAMPLER_WHITE},
        {"zorder", "Sobol' along a Morton curve, for a declared count", BN_SAMPLER_ZORDER},
        {"mask", "a blue-noise mask drives padded Sobol'", BN_SAMPLER_MASK},
    };
    return entries;
}

SamplerPointer sampler_create(const std::string &name, uint64_t seed, uint32_t declared_spp) {
    if (!plugin_files(name).empty())
        return std::make_unique<Sampler>(Sampler{{}, plugin_load(name, seed, declared_spp)});
    std::string known;
    for (const SamplerEntry &entry : sampler_entries()) {
        if (name == entry.name)
            return std::make_unique<Sampler>(
                Sampler{entry.type == BN_SAMPLER_ZORDER
                            ? bn::Sampler::zorder(declared_spp, seed)
                            : bn::Sampler(static_cast<bn::Type>(entry.type), seed)});
        known += std::string(entry.name) + ", ";
    }
    throw Error("there is no sampler '", name, "'; the samplers are ", known,
                "and plug-ins, such as ./FILE.so");
}
