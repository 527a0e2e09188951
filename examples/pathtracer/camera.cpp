// SPDX-License-Identifier: Apache-2.0
// A pinhole camera.
#include "camera.h"

Camera camera_look_at(Vec3 position, Vec3 target, Vec3 up, float tan_half_height) {
    Camera camera{};
    camera.position = position;
    camera.forward = normalize(target - position);
    camera.right = normalize(cross(camera.forward, up));
    camera.up = cross(camera.right, camera.forward);
    camera.tan_half_height = tan_half_height;
    return camera;
}

void camera_fit(Camera &camera, int width, int height) {
    camera.half_width = 0.5f * static_cast<float>(width);
    camera.half_height = 0.5f * static_cast<float>(height);
    camera.pixel_size = camera.tan_half_height / camera.half_height;
}
