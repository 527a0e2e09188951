// SPDX-License-Identifier: Apache-2.0
// The files of a picture: the EXR and its preview.
#pragma once

#include <string>
#include <vector>

#include "exr.h"
#include "input_file.h"
#include "options.h"

// The files that the settings of a picture name: scene, environment and mask, as far as they are
// files.
std::vector<NamedFile> setting_files(const Options &options);

// Throws Error if an output is also the other output, the reference, or one of `inputs`, under any
// name. Only the --resume picture may be replaced by -o.
void check_file_names(const Options &options, std::vector<NamedFile> inputs);

// Throws Error unless all files can be written. Call it before the first ray, so that a wrong name
// costs nothing.
void check_outputs(const Options &options);

// Replaces all files at once, with the exposure of the options; without one it is 0 for built-in scenes
// and automatic for files. Throws Error.
void write_outputs(const Options &options, const Film &film, ExrAttributes attributes);

// ---- parts.cpp: pictures in parts, and continuing a picture that was stopped

// Adds the rendering cost of a part to a picture that does not list its files any more if the part
// is made of other ones.
void add_part(ExrAttributes &to, const ExrAttributes &part);

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads and merges parts that this program wrote with the same settings, and of the same files
// unless `allow_changed`. Where parts overlap they must hold different samples, and each pixel's
// samples must be consecutive, starting at the first sample of all parts. Pixels outside all parts
// are black and have no samples. Holds only the result and one part in memory. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths, bool allow_changed);

// Reads the header of the picture to continue and takes from it all settings that are not on the
// command line. Without --spp or --time, rendering only evens out the sample counts of its pixels.
// Throws Error.
ExrHead resume_settings(Options &options);

// Reads the samples of the picture. Throws Error, naming the difference, unless it can be continued
// as `wanted`, or if it has `options.spp` samples in each pixel already.
Film resume_film(const Options &options, const ExrHead &picture, const ExrHead &wanted);
