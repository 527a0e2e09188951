// SPDX-License-Identifier: Apache-2.0
// A pinhole camera.
#pragma once

#include "math.h"

// Rays have unit directions.
struct Ray {
    Vec3 origin, direction;
};

struct Camera {
    Vec3 position;
    Vec3 forward, up, right; // unit vectors; right is the direction of growing x in the picture
    float tan_half_height;   // tangent of half the vertical angle of view
    float pixel_size;        // of the picture at distance 1; camera_frame sets the rest
    float half_width, half_height; // of the picture, in pixels
};

// A camera at `position` that looks at `target`. `up` need not be perpendicular to the view.
Camera camera_look_at(Vec3 position, Vec3 target, Vec3 up, float tan_half_height);

// Fits a picture of width x height pixels into the camera: the vertical angle of view stays.
void camera_fit(Camera &camera, int width, int height);

// The ray through a point of the picture, in pixels from its top left corner.
inline Ray camera_ray(const Camera &c, Vec2 point) {
    const float x = (point.x - c.half_width) * c.pixel_size;
    const float y = (c.half_height - point.y) * c.pixel_size;
    return {c.position, normalize(c.forward + x * c.right + y * c.up)};
}
