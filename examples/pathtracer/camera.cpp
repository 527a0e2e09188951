// SPDX-License-Identifier: Apache-2.0
// A camera with a thin lens or a pinhole.
#include "camera.h"

Camera camera_look_at(Vec3 position, Vec3 target, Vec3 up, float tan_half_height) {
    Camera camera{};
    camera.position = position;
    camera.target = target;
    camera.forward = normalize(target - position);
    camera.right = normalize(cross(camera.forward, up));
    camera.up = cross(camera.right, camera.forward);
    camera.tan_half_height = tan_half_height;
    return camera;
}

void camera_set_lens(Camera &camera, float radius, Vec3 focus) {
    camera.lens_radius = radius;
    camera.focus_distance = dot(focus - camera.position, camera.forward);
}

void camera_fit(Camera &camera, int width, int height) {
    camera.half_width = 0.5f * static_cast<float>(width);
    camera.half_height = 0.5f * static_cast<float>(height);
    camera.pixel_size = camera.tan_half_height / camera.half_height;
}
