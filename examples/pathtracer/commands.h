// SPDX-License-Identifier: Apache-2.0
// The commands of the program. All throw Error.
#pragma once

#include "options.h"
#include "scene_options.h"

// Renders a picture and writes it. Returns the number of the signal that interrupted it, or 0.
int run_render(const Options &options);

// Merges a picture from parts and writes it.
void run_merge(const Options &options);

// The options that concern the scene. Reads the environment.
SceneOptions scene_options(const Options &options);
