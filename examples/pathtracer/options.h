// SPDX-License-Identifier: Apache-2.0
// The command line.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "exr.h"
#include "scene.h"

struct Options : PictureSettings {
    CameraChoice camera;
    uint32_t spp = 16; // unless given: 1024 with --noise, the most with a time limit
    uint32_t first_sample = 0;
    int width = 512, height = 512;
    std::optional<Crop> crop;              // inside the picture
    std::optional<uint32_t> light_samples; // if given; see Scene
    bool allow_outside = false; // scenes and resumed pictures may name files outside their folder
    bool allow_changed = false; // mix pictures whose files have changed
    unsigned threads;           // default: one per core
    std::optional<double> max_memory; // GiB; default: half of the machine's; 0: no bound
    double time_limit = 0;            // seconds; 0: none
    std::optional<float> exposure;    // stops, if given
    bool auto_exposure = false;       // if neither is given: on for files; built-in scenes use 0
    std::string reference;
    std::string resume;             // a picture to continue, or empty
    std::set<std::string> given;    // options with a value that were given
    std::vector<std::string> merge; // parts to merge instead of rendering
    std::string output;
    bool quiet = false;
    bool list = false;
    bool list_cameras = false; // of the scene
    bool list_inputs = false;  // the files of the picture
    bool help = false;
};

// Throws Error. With --help or any --list..., checks nothing else.
Options parse_options(int argc, const char *const *argv);

// Checks options against each other; call it once a resumed picture's are known. Throws Error.
void check_options(const Options &options);

// The text of --help.
const char *options_help();
