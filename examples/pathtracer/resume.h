// SPDX-License-Identifier: Apache-2.0
// Continuing a picture that was stopped.
#pragma once

#include "exr.h"
#include "options.h"

// Reads the header of the picture to continue, and takes all settings from it that are not on the
// command line. Without --spp or --time, only the sample counts of its pixels are made equal.
// Throws Error.
ExrHead resume_settings(Options &options);

// Throws Error, naming the difference, unless the picture can be continued to the one wanted.
void resume_check(const std::string &path, const ExrHead &picture, const ExrHead &wanted);

// Reads the samples of the picture. Throws Error if it has `spp` samples per pixel already, or
// more.
Film resume_film(const std::string &path, uint32_t spp);
