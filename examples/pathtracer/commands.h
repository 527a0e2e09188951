// SPDX-License-Identifier: Apache-2.0
// The program's commands. All throw Error.
#pragma once

#include "options.h"
#include "scene_camera.h"

// Renders a picture and writes it. Returns the signal that interrupted it, or 0.
int run_render(const Options &options);

// Merges a picture from parts and writes it.
void run_merge(const Options &options);

// The options that affect the scene. Reads the environment.
SceneOptions scene_options(const Options &options);

// Reads all files of a picture. Returns their names and hashes.
std::string input_list(const Options &options);
