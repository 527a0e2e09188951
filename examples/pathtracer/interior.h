// SPDX-License-Identifier: Apache-2.0
// A view for files of rooms that have no camera.
#pragma once

#include <string>

#include "scene.h"

// Moves the camera of a file that has none of its own into the scene, if the view from outside is
// black and one from inside is not, and adds a note. Scenes with an environment are left alone.
// `name` is the scene's. Call this after scene_build, unless the user chose a view.
void frame_from_inside_if_black(Scene &scene, const std::string &name);
