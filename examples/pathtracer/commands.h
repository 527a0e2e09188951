// SPDX-License-Identifier: Apache-2.0
// What the program does with the options it was given. All throw Error.
#pragma once

#include "options.h"
#include "scene_options.h"

// Renders a picture and writes it. Returns the number of the signal that interrupted it, or 0.
int run_render(const Options &options);

// Puts a picture together from parts and writes it.
void run_merge(const Options &options);

// What the options ask of the scene; reads the environment.
SceneOptions scene_options(const Options &options);
