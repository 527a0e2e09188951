// SPDX-License-Identifier: Apache-2.0
// Choosing the camera of a scene: one of its own, and then another place, direction or angle.
// Places are those of the scene's file, in double, however far from its origin.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "scene.h"

// What is not given stays as the scene's camera has it.
struct CameraChoice {
    std::optional<uint32_t> number; // of the scene's cameras; the first unless given
    std::optional<Point3d> eye, target;
    std::optional<double> fov; // the vertical angle of view, in degrees
    std::string listed;        // or else a camera as camera_text() has it; may be empty
};

// Sets the scene's camera; to be called before scene_finish. +y is up in the picture, or -z when
// the camera looks straight down and +z when it looks straight up. A lens keeps its radius and the
// distance of its focus. Throws Error.
void scene_choose_camera(Scene &scene, const CameraChoice &choice);

// The camera in the options that give it again: "--eye 0,1,5 --target 0,0,0 --fov 40".
std::string camera_text(const Scene &scene, const Camera &camera);

// Where its vertices lie: "reaches from -1,0,-1 to 1,2,1".
std::string scene_extent_text(const Scene &scene);

// What a standard EXR header says of a camera, for points (x, y, z, 1) as rows that are multiplied
// from the left; row by row. In camera space x is to the right, y up and z ahead. In NDC, after the
// division by w, (0, 0) is the top left corner of the picture and (1, 1) the bottom right one.
// Points are in the coordinates of the scene's file. The lens counts as a pinhole at its middle.
struct CameraMatrices {
    std::array<float, 16> world_to_camera, world_to_ndc;
};
CameraMatrices camera_matrices(const Scene &scene, int width, int height);

// A line for each camera of the scene.
std::string camera_list(const Scene &scene);
