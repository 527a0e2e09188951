// SPDX-License-Identifier: Apache-2.0
// Loads a plug-in with dlopen(), and checks the numbers that it returns.
#include "plugin.h"

#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <mutex>
#include <type_traits>

#include "files.h"

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
    decltype(&sampler_plugin_version) version;
    decltype(&sampler_plugin_create) create;
    decltype(&sampler_plugin_destroy) destroy;
    const auto find = [&](auto *&function, const char *symbol) { // null if there is none
        function =
            reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, symbol));
    };
    find(version, "sampler_plugin_version");
    find(plugin.draw, "sampler_plugin_draw");
    find(plugin.split, "sampler_plugin_split");
    find(create, "sampler_plugin_create");
    find(destroy, "sampler_plugin_destroy");
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
