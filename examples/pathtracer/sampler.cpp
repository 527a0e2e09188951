// SPDX-License-Identifier: Apache-2.0
// Creates a sampler from its name on the command line, or from a shared library.
#include "sampler.h"

#include <dlfcn.h>

#include <cstdlib>
#include <mutex>

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

// ---- Plug-ins: loading them with dlopen(), and checking the numbers that they return

std::vector<std::string> plugin_files(const std::string &name) {
    if (name.find_first_of("./") == std::string::npos) return {};
    const size_t colon = std::min(name.find(':'), name.size());
    std::vector<std::string> files = {name.substr(0, colon)};
    std::error_code none;
    if (std::filesystem::is_regular_file(name.c_str() + colon + (colon < name.size()), none))
        files.push_back(name.substr(colon + 1));
    return files;
}

Plugin plugin_load(const std::string &name, uint64_t seed, uint32_t samples) {
    const std::filesystem::path file = std::filesystem::absolute(name.substr(0, name.find(':')));
    void *const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL); // stays open
    if (!library) throw Error("cannot load the sampler: ", without_controls(dlerror()));
    Plugin plugin{name, seed, nullptr, nullptr, nullptr, bn::Sampler(bn::Type::white, seed)};
    const auto find = [&](auto type, const char *symbol) { // null if there is none
        return reinterpret_cast<decltype(type)>(dlsym(library, symbol));
    };
    const auto version = find(decltype (&sampler_plugin_version)(), "sampler_plugin_version");
    const auto create = find(decltype (&sampler_plugin_create)(), "sampler_plugin_create");
    const auto destroy = find(decltype (&sampler_plugin_destroy)(), "sampler_plugin_destroy");
    plugin.draw = find(decltype (&sampler_plugin_draw)(), "sampler_plugin_draw");
    plugin.split = find(decltype (&sampler_plugin_split)(), "sampler_plugin_split");
    if (!version || !plugin.draw)
        throw Error(name, " does not export sampler_plugin_", version ? "draw" : "version",
                    "(); see sampler_plugin.h");
    if (version() != SAMPLER_PLUGIN_VERSION)
        throw Error(name, " is for version ", version(), " of sampler_plugin.h, not ",
                    SAMPLER_PLUGIN_VERSION, "; compile it again");
    const bool argued = name.find(':') != std::string::npos;
    if (create)
        plugin.state = {create(seed, samples, argued ? &name[name.find(':') + 1] : ""),
                        [=](void *state) {
                            if (destroy && state) destroy(state);
                        }};
    if (create ? !plugin.state : argued)
        throw Error(name, " refuses its argument or ", samples, " samples");
    return plugin;
}

void PluginPath::refuse(float number, uint32_t decision) const {
    static std::mutex first;
    first.lock(); // for good: only one thread reports
    say(joined(plugin_->name, " draws ", number, ", which is not in [0, 1), for seed ",
               plugin_->seed, ", pixel ", x_, ",", y_, ", sample ", index_, ", decision ",
               decision));
    std::_Exit(1);
}
