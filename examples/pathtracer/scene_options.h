// SPDX-License-Identifier: Apache-2.0
// Options for building or reading a scene.
#pragma once

#include "scene_camera.h"

class InputRecord;

struct SceneOptions {
    CameraChoice camera;
    std::shared_ptr<const Environment> environment; // replaces the scene's own; may be empty
    bool single_scatter = false;                    // rough materials without multiple scattering
    bool allow_outside = false;    // a scene file may read files outside its folder
    bool photometric = false;      // a file's punctual lights are in candela and lux
    InputRecord *record = nullptr; // gets the files of the scene
};
