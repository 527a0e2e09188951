// SPDX-License-Identifier: Apache-2.0
// The command line.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "image.h"
#include "sampler.h"
#include "scene_options.h"

struct Options {
    std::string scene = "cornell";
    CameraChoice camera;
    SamplerSettings sampler;
    uint32_t spp = 16; // with a time limit: unlimited, unless given
    uint32_t first_sample = 0;
    int width = 512, height = 512;
    std::optional<Crop> crop; // inside the picture
    uint32_t max_depth = 8;
    uint32_t light_samples = 0; // at the first surface of a path; 0: as the scene has it
    bool single_scatter = false;
    bool photometric = false;
    bool allow_outside = false;    // a scene's file may read others outside of its folder
    std::string environment;       // an EXR file, or empty: the scene's own
    unsigned threads;              // default: one per core
    double time_limit = 0;         // seconds; 0: none
    double write_interval = 0;     // seconds between partial pictures; 0: none are written
    std::optional<float> exposure; // given in stops
    bool auto_exposure = false;    // asked for; without either, files get it, built-in scenes 0
    std::string reference;
    std::string convergence;        // a CSV file, or empty
    std::string resume;             // a picture to continue, or empty
    std::set<std::string> given;    // the options that take a value
    std::vector<std::string> merge; // parts to merge; then nothing is rendered
    std::string output;
    bool quiet = false;
    bool list = false;
    bool list_cameras = false; // of the scene
    bool help = false;
};

// Throws Error. With --help, --list or --list-cameras, nothing else is checked.
Options parse_options(int argc, const char *const *argv);

// Checks options against each other, once those of a resumed picture are known. Throws Error.
void check_options(const Options &options);

// The text of --help.
const char *options_help();
