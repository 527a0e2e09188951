// SPDX-License-Identifier: Apache-2.0
// Continuing a picture that was stopped.
#pragma once

#include "exr.h"
#include "options.h"

// Reads the header of the picture to continue and takes from it all settings that are not on the
// command line. Without --spp or --time, rendering only evens out the sample counts of its pixels.
// Throws Error.
ExrHead resume_settings(Options &options);

// Reads the samples of the picture. Throws Error, naming the difference, unless it can be continued
// as `wanted`, or if it has `options.spp` samples in each pixel already.
Film resume_film(const Options &options, const ExrHead &picture, const ExrHead &wanted);
