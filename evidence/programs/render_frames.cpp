// SPDX-License-Identifier: Apache-2.0
// Renders the frames of a moving camera for scripts/bench realtime --motion, without building the scene anew for each:
//
//     render_frames SCENE WIDTHxHEIGHT MAX_DEPTH
//
// Each line of standard input is one frame and has 17 words:
//
//     SAMPLER SEED INDEX SPP  X0 Y0 X1 Y1  DX DY  EYE (3)  TARGET (3)  FOV
//
// Writes the float32 luminance of the crop's pixels for each frame. The sampler "depth" instead writes the depth along
// the camera's axis at each pixel's centre, or 0 where nothing is hit. Other words are as the path tracer's options.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "files.h"
#include "film.h"
#include "scene.h"

namespace {

struct Frame {
    std::string sampler;
    uint64_t seed;
    uint32_t index, spp;
    Crop crop;
    int dx, dy;
    Vec3 eye, target;
    float fov;
};

bool read_frame(Frame &f) {
    std::string line;
    if (!std::getline(std::cin, line)) return false;
    std::istringstream words(line);
    Vec3 &e = f.eye, &t = f.target;
    words >> f.sampler >> f.seed >> f.index >> f.spp >> f.crop.x0 >> f.crop.y0 >> f.crop.x1 >>
        f.crop.y1 >> f.dx >> f.dy >> e.x >> e.y >> e.z >> t.x >> t.y >> t.z >> f.fov;
    if (!words) throw Error("a frame has 17 words, not '", line, "'");
    return true;
}

float depth_at(const Scene &scene, const Geometry &geometry, int x, int y) {
    const Camera &camera = scene.camera;
    const Ray ray = camera_ray(camera, {float(x) + 0.5f, float(y) + 0.5f}, {0.5f, 0.5f});
    Hit hit;
    if (!intersect(geometry, ray, true, hit)) return 0;
    return hit.distance * dot(ray.direction, camera.forward);
}

// `sampler` is that of the frame before, or null.
void render(const Frame &f, Scene &scene, const Geometry &geometry, SamplerPointer &sampler,
            uint32_t depth, int width, int height) {
    scene.camera = camera_look_at(f.eye, f.target, {0, 1, 0}, std::tan(f.fov * PI / 360));
    camera_fit(scene.camera, width, height);
    std::vector<float> values;
    if (f.sampler == "depth") {
        each_pixel(f.crop,
                   [&](int x, int y) { values.push_back(depth_at(scene, geometry, x, y)); });
    } else {
        if (!sampler) sampler = sampler_create(f.sampler, f.seed);
        const Integrator integrator{&scene, &geometry, sampler.get(), depth, f.dx, f.dy};
        Film film = film_create(width, height, f.crop);
        RenderTotals totals;
        const std::sig_atomic_t never = 0;
        render_frame(
            integrator, {f.spp, f.index, 1, 0, 0, 2, 0}, film, totals,
            [](double, const RenderTotals &) {}, never);
        for (const FilmPixel &pixel : film.pixels)
            values.push_back(float(luminance(pixel.radiance)));
    }
    std::fwrite(values.data(), sizeof(float), values.size(), stdout);
}

int run(int argc, char **argv) {
    int width = 0, height = 0;
    if (argc != 4 || std::sscanf(argv[2], "%dx%d", &width, &height) != 2)
        throw Error("usage: render_frames SCENE WIDTHxHEIGHT MAX_DEPTH <frames");
    Scene scene = scene_build(argv[1], {});
    const GeometryPointer geometry = geometry_build(scene);
    geometry_thread_begin();
    SamplerPointer sampler;
    Frame last{};
    for (Frame frame; read_frame(frame); last = frame) {
        if (frame.sampler != last.sampler || frame.seed != last.seed) sampler.reset();
        render(frame, scene, *geometry, sampler, uint32_t(std::stoul(argv[3])), width, height);
    }
    return std::fflush(stdout) == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char **argv) {
    return run_or_say(run, argc, argv);
}
