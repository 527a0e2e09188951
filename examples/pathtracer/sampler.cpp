// SPDX-License-Identifier: Apache-2.0
// Creating a sampler from the command line's names.
#include "sampler.h"

#include "error.h"
#include "png_image.h"

#ifndef BN_NO_NEURAL
#include <bn/neural.h>
#endif

namespace {

std::vector<uint32_t> read_mask(const std::string &path, uint32_t &width, uint32_t &height) {
    const GreyImage image = png_read_grey(path);
    const std::vector<float> values(image.values.begin(), image.values.end());
    std::vector<uint32_t> ranks(values.size());
    const bn_result result = bn_ranks_from_values(values.data(), values.size(), ranks.data());
    if (result != BN_SUCCESS) throw Error("mask " + path + ": " + bn_result_string(result));
    width = image.width;
    height = image.height;
    return ranks;
}

constexpr uint32_t NEURAL_EXTENT = 128; // texels

// A mask of the built-in network, which runs in ONNX Runtime.
std::vector<uint32_t> make_neural_mask(const SamplerSettings &settings) {
#ifdef BN_NO_NEURAL
    (void)settings;
    throw Error("--mask neural: this program was built without the network; build it with "
                "-DBN_NEURAL=ON");
#else
    bn_neural *neural = nullptr;
    bn_result result = bn_neural_open(nullptr, &neural);
    std::vector<uint32_t> ranks(size_t{NEURAL_EXTENT} * NEURAL_EXTENT);
    if (result == BN_SUCCESS) {
        result = bn_neural_mask(neural, NEURAL_EXTENT, NEURAL_EXTENT, settings.seed, ranks.data(),
                                ranks.size());
    }
    bn_neural_close(neural);
    if (result == BN_ERROR_RUNTIME)
        throw Error("--mask neural needs ONNX Runtime; install it (for example with pip install "
                    "onnxruntime) and set BN_ONNXRUNTIME to its libonnxruntime.so");
    if (result != BN_SUCCESS)
        throw Error(std::string("--mask neural: ") + bn_result_string(result));
    return ranks;
#endif
}

} // namespace

const std::vector<SamplerEntry> &sampler_entries() {
    static const std::vector<SamplerEntry> entries = [] {
        std::vector<SamplerEntry> all = {
            {"blue", "progressive blue noise in both pairs of every domain", BN_SAMPLER_BLUE},
            {"sobol", "Owen-scrambled Sobol', independent in each pixel", BN_SAMPLER_SOBOL},
            {"white", "independent uniform numbers", BN_SAMPLER_WHITE},
            {"zorder", "Sobol' along a Morton curve, for a declared count", BN_SAMPLER_ZORDER},
            {"mask", "a blue-noise mask drives Sobol'", BN_SAMPLER_MASK},
        };
        for (const SamplerEntry &entry : openqmc_entries()) all.push_back(entry);
        return all;
    }();
    return entries;
}

SamplerPointer sampler_create(const SamplerSettings &settings) {
    const SamplerEntry *chosen = nullptr;
    std::string known;
    for (const SamplerEntry &entry : sampler_entries()) {
        if (settings.name == entry.name) chosen = &entry;
        known += (known.empty() ? "" : ", ") + std::string(entry.name);
    }
    if (!chosen)
        throw Error("there is no sampler '" + settings.name + "'; the samplers are " + known);

    if (chosen->peer) {
        for (const auto &[option, given] : {std::pair{"--declare", settings.declared_spp > 0},
                                            std::pair{"--mask", !settings.mask.empty()}})
            if (given)
                throw Error(std::string(option) + " is for the samplers of libbn, not for '" +
                            settings.name + "'; leave it out");
        return std::make_unique<Sampler>(Sampler{nullptr, chosen->peer(settings.seed)});
    }

    bn_sampler_options options = bn_sampler_options_default();
    options.kind = chosen->kind;
    options.samples_per_pixel = settings.declared_spp;
    options.seed = settings.seed;
    std::vector<uint32_t> ranks;
    if (!settings.mask.empty()) {
        if (chosen->kind != BN_SAMPLER_MASK)
            throw Error("--mask goes with --sampler mask, not with '" + settings.name + "'");
        if (settings.mask == "neural") {
            ranks = make_neural_mask(settings);
            options.mask_width = options.mask_height = NEURAL_EXTENT;
            options.mask_ranks = ranks.data();
        } else if (settings.mask != "builtin") {
            ranks = read_mask(settings.mask, options.mask_width, options.mask_height);
            options.mask_ranks = ranks.data();
        }
    }

    bn_sampler *sampler = nullptr;
    const bn_result result = bn_sampler_create(&options, &sampler);
    if (result != BN_SUCCESS)
        throw Error("the sampler '" + settings.name +
                    "' cannot be created: " + bn_result_string(result));
    return std::make_unique<Sampler>(Sampler{{sampler, {}}, nullptr});
}
