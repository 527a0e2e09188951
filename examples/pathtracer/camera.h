// SPDX-License-Identifier: Apache-2.0
// A camera with a thin lens, or a pinhole if the lens radius is 0.
#pragma once

#include <string>

#include "math.h"

struct Ray {
    Vec3 origin, direction;
    float time = 0; // within the shutter interval, in [0, 1)
};

struct Camera {
    Vec3 position;
    Vec3 target;                   // a point ahead, to report what the camera looks at
    Vec3 forward, up, right;       // unit vectors; x grows to the right in the image
    float tan_half_height;         // tangent of half the vertical angle of view
    float pixel_size;              // at distance 1; camera_fit sets it and the half sizes
    float half_width, half_height; // half the image size, in pixels
    float lens_radius;             // 0: a pinhole
    float focus_distance;          // along `forward`, to the plane in focus
    bool frames_square;            // narrow images, too, show all that a square one does
    std::string name;              // may be empty
};

// `up` need not be perpendicular to `forward`, a unit vector.
inline void camera_turn(Camera &camera, Vec3 forward, Vec3 up) {
    camera.forward = forward;
    camera.right = normalize(cross(forward, up));
    camera.up = cross(camera.right, forward);
}

// Looks from `position` at `target`.
inline Camera camera_look_at(Vec3 position, Vec3 target, Vec3 up, float tan_half_height) {
    Camera camera{};
    camera.position = position;
    camera.target = target;
    camera_turn(camera, normalize(target - position), up);
    camera.tan_half_height = tan_half_height;
    return camera;
}

// Gives the camera a lens of this radius, focused on the plane through `focus`.
inline void camera_set_lens(Camera &camera, float radius, Vec3 focus) {
    camera.lens_radius = radius;
    camera.focus_distance = dot(focus - camera.position, camera.forward);
}

// Fits the camera to an image of width x height pixels. The vertical angle of view stays the same, unless
// the camera frames a square and the image is narrower.
inline void camera_fit(Camera &camera, int width, int height) {
    if (camera.frames_square && width < height)
        camera.tan_half_height *= float(height) / float(width);
    camera.half_width = 0.5f * float(width);
    camera.half_height = 0.5f * float(height);
    camera.pixel_size = camera.tan_half_height / camera.half_height;
}

// The position within a pixel, and up to 1 pixel outside it, for a Gaussian pixel filter with a standard
// deviation of half a pixel and a radius of 1.5 pixels: the inverse of its cumulative distribution. Starts from
// Winitzki's inverse error function ("A handy approximation for the error function and its inverse", 2008)
// and takes a Newton step.
inline float gaussian_position(float u) {
    const float x = 0.9973002f * (2 * u - 1); // erf(3 / sqrt(2)): three deviations
    const float l = 0.5f * std::log(1 - x * x), a = 0.147f, t = 2 / (PI * a) + l;
    float z = std::copysign(std::sqrt(std::max(std::sqrt(t * t - 2 * l / a) - t, 0.0f)), x);
    z -= (std::erf(z) - x) * 0.8862269f * std::exp(z * z); // sqrt(pi) / 2
    return 0.5f + 0.70710678f * z;
}

// The ray through a point of the image, in pixels from its top-left corner, and through a point on
// the lens, in the unit square.
inline Ray camera_ray(const Camera &c, Vec2 point, Vec2 lens) {
    const float x = (point.x - c.half_width) * c.pixel_size;
    const float y = (c.half_height - point.y) * c.pixel_size;
    const Vec3 through_middle = c.forward + x * c.right + y * c.up;
    if (!(c.lens_radius > 0)) return {c.position, normalize(through_middle)};
    const Vec2 disc = square_to_disc(lens);
    const Vec3 offset = c.lens_radius * (disc.x * c.right + disc.y * c.up);
    return {c.position + offset, normalize(c.focus_distance * through_middle - offset)};
}
