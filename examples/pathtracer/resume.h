// SPDX-License-Identifier: Apache-2.0
// Going on with a picture that was stopped.
#pragma once

#include "exr.h"
#include "options.h"

// Reads the head of the picture to go on with, and takes from it all settings that were not given
// on the command line. Without --spp or --time the picture is only made even. Throws Error.
ExrHead resume_settings(Options &options);

// Throws Error, saying what differs, unless the picture is a beginning of the one to be rendered.
void resume_check(const std::string &path, const ExrHead &picture, const ExrHead &wanted);

// The samples of the picture. Throws Error when it has as many as it should, or more.
Film resume_film(const std::string &path, uint32_t spp);
