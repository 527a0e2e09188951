// SPDX-License-Identifier: Apache-2.0
// Chooses the camera of a scene: one of its own, optionally with another position, target or angle.
// Points are in the coordinates of the scene's file, in double precision.
#pragma once

#include <optional>
#include <string>

#include "scene.h"

// Unset fields keep the values of the scene's camera.
struct CameraChoice {
    std::optional<uint32_t> number; // of the scene's cameras; the first unless given
    std::optional<Point3d> eye, target;
    std::optional<double> fov; // the vertical angle of view, in degrees
};

class InputRecord;

// Options for building or reading a scene.
struct SceneOptions {
    CameraChoice camera;
    std::shared_ptr<const Environment> environment; // replaces the scene's own; may be empty
    bool single_scatter = false;                    // rough materials without multiple scattering
    bool allow_outside = false;    // a scene file may read files outside its folder
    bool photometric = false;      // a file's punctual lights are in candela and lux
    InputRecord *record = nullptr; // gets the files of the scene
};

// Sets the scene's camera; call this before scene_finish. Up in the picture is +y, or -z if the
// camera looks straight down, or +z if it looks straight up. A lens keeps its radius and focus
// distance. Throws Error.
void scene_choose_camera(Scene &scene, const CameraChoice &choice);

// The choice that a text of options names, with or without a number. Throws Error.
CameraChoice camera_parse(const std::string &text);

// The options that reproduce a camera: "--eye 0,1,5 --target 0,0,0 --fov 40".
std::string camera_text(const Scene &scene, const Camera &camera);

// The bounds of the vertices: "reaches from -1,0,-1 to 1,2,1".
std::string scene_extent_text(const Scene &scene);

// One line per camera of the scene.
std::string camera_list(const Scene &scene);
