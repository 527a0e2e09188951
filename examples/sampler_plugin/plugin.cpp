// SPDX-License-Identifier: Apache-2.0
// Plug-ins: loading them with dlopen(), and refusing numbers that are not in [0, 1).
#include "plugin.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <stdexcept>

namespace fs = std::filesystem;

std::vector<std::string> plugin_files(const std::string &name) {
    if (name.find_first_of("./") == std::string::npos) return {};
    const size_t colon = std::min(name.find(':'), name.size());
    std::vector<std::string> files = {name.substr(0, colon)};
    std::error_code none;
    if (fs::is_regular_file(name.c_str() + colon + (colon < name.size()), none))
        files.push_back(name.substr(colon + 1));
    return files;
}

Plugin plugin_load(const std::string &name, uint64_t seed, uint32_t samples) {
    const size_t colon = name.find(':');
    const std::string argument = colon < name.size() ? name.substr(colon + 1) : "";
    // Stays open.
    void *const library = dlopen(fs::absolute(name.substr(0, colon)).c_str(), RTLD_NOW);
    if (!library) throw std::runtime_error(std::string("cannot load the sampler: ") + dlerror());
#define FIND(function) reinterpret_cast<decltype(&(function))>(dlsym(library, #function)) // or null
    const auto version = FIND(sampler_plugin_version);
    const auto create = FIND(sampler_plugin_create);
    const auto destroy = FIND(sampler_plugin_destroy);
    Plugin plugin{name,
                  seed,
                  FIND(sampler_plugin_draw),
                  FIND(sampler_plugin_split),
                  nullptr,
                  bn::Sampler(bn::Type::white, seed)};
#undef FIND
    if (!version || !plugin.draw)
        throw std::runtime_error(name + " does not export sampler_plugin_" +
                                 (version ? "draw" : "version") + "(); see sampler_plugin.h");
    if (version() != SAMPLER_PLUGIN_VERSION)
        throw std::runtime_error(name + " is for version " + std::to_string(version()) +
                                 " of sampler_plugin.h, not " +
                                 std::to_string(SAMPLER_PLUGIN_VERSION) + "; compile it again");
    if (create)
        plugin.state = {create(seed, samples, argument.c_str()), [=](void *state) {
                            if (destroy && state) destroy(state);
                        }};
    if (!create && !argument.empty())
        throw std::runtime_error(name.substr(0, colon) + " takes no argument");
    if (create && !plugin.state)
        throw std::runtime_error(
            name.substr(0, colon) +
            (argument.empty() ? " needs an argument" : " rejects the argument '" + argument + "'") +
            (samples > 0 ? ", or rejects " + std::to_string(samples) + " samples per pixel" : ""));
    return plugin;
}

void PluginPath::refuse(float number, uint32_t decision) const {
    std::ostringstream text;
    text << plugin_->name << " draws " << number << ", which is not in [0, 1), for seed "
         << plugin_->seed << ", pixel " << x_ << "," << y_ << ", sample " << index_ << ", decision "
         << decision;
    throw std::runtime_error(text.str());
}
