// SPDX-License-Identifier: Apache-2.0
// Continuing a picture that was stopped.
#pragma once

#include "exr.h"
#include "options.h"

// Reads the header of the picture to continue and takes from it all settings that are not on the
// command line. Without --spp or --time, rendering only evens out the sample counts of its pixels.
// Throws Error.
ExrHead resume_settings(Options &options);

// Throws Error, naming the difference, unless `picture` can be continued as `wanted`; with
// `allow_changed` also where the files that it was rendered from have changed.
void resume_check(const std::string &path, const ExrHead &picture, const ExrHead &wanted,
                  bool allow_changed);

// Reads the picture's samples. Throws Error if it already has `spp` or more samples per pixel.
Film resume_film(const std::string &path, uint32_t spp);
