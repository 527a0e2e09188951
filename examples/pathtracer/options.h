// SPDX-License-Identifier: Apache-2.0
// The options, in one table: the command line, --help, the attributes of an EXR and --resume follow
// from it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "film.h"
#include "sampler.h"
#include "scene.h"

struct Options {
    std::string scene = "cornell";
    CameraChoice camera;
    SamplerSettings sampler;
    uint32_t spp = 16; // unless given: 1024 with --noise
    uint32_t first_sample = 0;
    NoiseSettings noise;
    int width = 512, height = 512;
    std::optional<Crop> crop; // inside the picture
    uint32_t max_depth = 8;
    std::optional<uint32_t> light_samples; // if given; see Scene
    std::string environment;               // an EXR file, "sky", "none", or empty: the scene's own
    bool clamp = false, photometric = false, single_scatter = false;
    bool allow_outside = false; // scenes and resumed pictures may name files outside their folder
    bool allow_changed = false; // mix pictures whose files have changed
    unsigned threads = 1;       // default: one per core
    std::optional<double> max_memory; // GiB; default: half of the machine's; 0: no bound
    std::optional<float> exposure;    // stops, if given
    bool auto_exposure = false;       // if neither is given: on for files; built-in scenes use 0
    std::string reference, output;
    std::string resume;             // a picture to continue, or empty
    std::vector<std::string> merge; // parts to merge instead of rendering
    bool quiet = false, list = false, list_cameras = false, list_inputs = false, help = false;
    std::set<std::string> given; // names of options that were given
};

// An option, or several lines of --help.
struct OptionRow {
    std::string name, value, help;
    // Reads the value, refusing what it does not take by throwing a text that says what it takes.
    std::function<void(const std::string &)> read;
    const char *attribute = nullptr;        // under which pictures store it, if they do
    std::function<std::string()> text = {}; // the value as an attribute has it
};

std::vector<OptionRow> option_rows(Options &options);

// Reads the value of an option. Throws Error.
void option_read(const OptionRow &row, const std::string &value);

// Throws Error. With --help or any --list..., checks nothing else.
Options parse_options(int argc, const char *const *argv);

// Checks options against each other; call it once a resumed picture's are known. Throws Error.
void check_options(const Options &options);

// The text of --help.
std::string options_help();
