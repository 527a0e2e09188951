// SPDX-License-Identifier: Apache-2.0
// Chooses the camera of a scene.
#include "scene.h"

#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdio>

#include "error.h"

namespace {

constexpr double DEGREE = 3.14159265358979323846 / 180;

// The fewest digits, of `least` or more, that read_back() accepts the number of.
template <typename ReadBack>
std::string digits(double value, int least, const ReadBack &read_back) {
    char text[32];
    for (int precision = least;; ++precision) {
        const auto end =
            std::to_chars(text, text + sizeof text, value, std::chars_format::general, precision);
        double back = 0;
        std::from_chars(text, end.ptr, back);
        if (precision == 17 || read_back(back)) return {text, end.ptr};
    }
}

// Of `value` + `origin`, such that less the origin it is the value again.
std::string digits(float value, double origin) {
    return digits(double{value} + origin, 6,
                  [&](double sum) { return static_cast<float>(sum - origin) == value; });
}

std::string digits(Vec3 v, Point3d origin) {
    return digits(v.x, origin.x) + "," + digits(v.y, origin.y) + "," + digits(v.z, origin.z);
}

float tan_half(double fov) {
    return static_cast<float>(std::tan(0.5 * fov * DEGREE));
}

// The angle in degrees.
std::string fov_text(float tan_half_height) {
    return digits(2 * std::atan(double{tan_half_height}) / DEGREE, 3,
                  [&](double fov) { return tan_half(fov) == tan_half_height; });
}

std::string numbered_names(const Scene &scene) {
    std::string list;
    for (size_t i = 0; i < scene.cameras.size(); ++i)
        list += (i == 0 ? "" : ", ") + std::to_string(i) +
                (scene.cameras[i].name.empty() ? "" : " '" + scene.cameras[i].name + "'");
    return list;
}

void aim(Scene &scene, Point3d eye, Point3d target) {
    const double distance = length(target - eye);
    if (!(distance > 0) || !std::isfinite(distance))
        throw Error("the camera has no direction: --eye and --target are both ",
                    digits(Vec3(eye - scene.origin), scene.origin), "; move one of them");
    const Vec3 forward = Vec3((target - eye) / distance);
    Vec3 up = {0, 1, 0};
    if (!(max_magnitude(cross(forward, up)) > 1e-6f)) up = {0, 0, forward.y < 0 ? -1.0f : 1.0f};
    Camera &camera = scene.camera;
    camera.position = Vec3(eye - scene.origin);
    camera.target = Vec3(target - scene.origin);
    camera_turn(camera, forward, up);
}

} // namespace

CameraChoice camera_parse(const std::string &text) {
    CameraChoice choice;
    uint32_t number = 0;
    int read = 0;
    if (std::sscanf(text.c_str(), "--camera %" SCNu32 " %n", &number, &read) == 1)
        choice.number = number;
    Point3d eye, target;
    double fov = 0;
    if (std::sscanf(text.c_str() + read, "--eye %lf,%lf,%lf --target %lf,%lf,%lf --fov %lf", &eye.x,
                    &eye.y, &eye.z, &target.x, &target.y, &target.z, &fov) != 7 ||
        !(fov > 0 && fov < 180))
        throw Error("the picture's camera is '", text, "', which cannot be read; give the camera");
    choice.eye = eye;
    choice.target = target;
    choice.fov = fov;
    return choice;
}

void scene_choose_camera(Scene &scene, const CameraChoice &choice) {
    if (choice.number) {
        if (*choice.number >= scene.cameras.size())
            throw Error("there is no camera " + std::to_string(*choice.number) +
                        ": the scene has " +
                        (scene.cameras.empty() ? "none of its own; leave out --camera, or set --eye"
                                               : std::string("cameras ") + numbered_names(scene)));
        scene.camera = scene.cameras[*choice.number].camera;
    }
    const Point3d eye = choice.eye.value_or(Point3d(scene.camera.position) + scene.origin);
    const Point3d target = choice.target.value_or(Point3d(scene.camera.target) + scene.origin);
    // Re-aiming at the same target would change the last bits of the scene's own camera.
    if (Vec3(eye - scene.origin) != scene.camera.position ||
        Vec3(target - scene.origin) != scene.camera.target)
        aim(scene, eye, target);
    if (choice.fov) scene.camera.tan_half_height = tan_half(*choice.fov);
}

std::string camera_text(const Scene &scene, const Camera &camera) {
    return "--eye " + digits(camera.position, scene.origin) + " --target " +
           digits(camera.target, scene.origin) + " --fov " + fov_text(camera.tan_half_height);
}

std::string camera_list(const Scene &scene) {
    if (scene.cameras.empty())
        return "none of its own; everything is framed by " + camera_text(scene, scene.camera) +
               "\n";
    std::string list;
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        const NamedCamera &named = scene.cameras[i];
        list += std::to_string(i) + "  " + camera_text(scene, named.camera) +
                (named.name.empty() ? "" : "  '" + named.name + "'") + "\n";
    }
    return list;
}

std::string scene_extent_text(const Scene &scene) {
    if (scene.vertices.empty()) return "is empty";
    const auto [low, high] = scene_bounds(scene);
    const Point3d from = Point3d(low) + scene.origin, to = Point3d(high) + scene.origin;
    char text[256];
    std::snprintf(text, sizeof text, "reaches from %.4g,%.4g,%.4g to %.4g,%.4g,%.4g", from.x,
                  from.y, from.z, to.x, to.y, to.z);
    return text;
}
