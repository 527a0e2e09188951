// SPDX-License-Identifier: Apache-2.0
// The program: everything that can fail early is tried before the first ray.
#include <unistd.h>

#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>

#include "difference.h"
#include "error.h"
#include "exr.h"
#include "integrator.h"
#include "intersect.h"
#include "options.h"
#include "output_file.h"
#include "png_image.h"
#include "render.h"
#include "sampler.h"
#include "scene.h"

namespace {

void print_list() {
    std::printf("scenes:\n");
    for (const SceneEntry &entry : scene_entries())
        std::printf("  %-10s %s\n", entry.name, entry.summary);
    std::printf("samplers:\n");
    for (const SamplerEntry &entry : sampler_entries())
        std::printf("  %-10s %s\n", entry.name, entry.summary);
}

void print_progress(const RenderProgress &p) {
    const double rays_per_second = static_cast<double>(p.ray_count) / std::max(p.seconds, 1e-9);
    std::fprintf(stderr, "\r%5.1f %%  %6.1f M rays/s", 100 * p.fraction, 1e-6 * rays_per_second);
    if (p.fraction > 0)
        std::fprintf(stderr, "  %.0f s left   ",
                     std::ceil(p.seconds * (1 - p.fraction) / p.fraction));
    std::fflush(stderr);
}

// The reference's pixels inside the crop.
Image load_reference(const std::string &path, int full_width, int full_height, const Crop &crop) {
    const Image image = exr_read(path);
    if (image.full_width != full_width || image.full_height != full_height)
        throw Error("the reference " + path + " has " + std::to_string(image.full_width) + "x" +
                    std::to_string(image.full_height) + " pixels, the picture " +
                    std::to_string(full_width) + "x" + std::to_string(full_height) +
                    "; set --size or take another reference");
    if (crop.x0 < image.crop.x0 || crop.y0 < image.crop.y0 || crop.x1 > image.crop.x1 ||
        crop.y1 > image.crop.y1)
        throw Error("the reference " + path + " holds only a part of the pixels to compare with");
    return image_crop(image, crop);
}

void run(const Options &options) {
    // ---- Everything that may be wrong
    std::shared_ptr<const Environment> environment;
    if (!options.environment.empty())
        environment = std::make_shared<Environment>(environment_read(options.environment));
    Scene scene = scene_build(options.scene, environment);
    if (options.light_samples > 0) scene.light_samples = options.light_samples;
    if (uint64_t{options.first_sample} + options.spp > (uint64_t{1} << 32) / scene.light_samples)
        throw Error("--first-sample and --spp run past the last sample of " +
                    std::to_string(scene.light_samples) + " light samples each; take fewer");
    camera_fit(scene.camera, options.width, options.height);
    const SamplerPointer sampler = sampler_create(options.sampler);
    const Crop crop = options.crop.value_or(Crop{0, 0, options.width, options.height});
    std::optional<Image> reference;
    if (!options.reference.empty())
        reference = load_reference(options.reference, options.width, options.height, crop);
    const std::filesystem::path exr_path = options.output;
    const std::filesystem::path png_path =
        std::filesystem::path(exr_path).replace_extension(".png");
    check_writable(exr_path);
    check_writable(png_path);

    // ---- Rendering
    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator =
        integrator_create(scene, *geometry, sampler.get(), options.max_depth);
    const RenderSettings settings = {crop, options.first_sample, options.spp, options.threads};
    const bool show_progress = !options.quiet && isatty(STDERR_FILENO);
    const auto report = [&](const RenderProgress &progress) {
        if (show_progress) print_progress(progress);
    };
    RenderProgress done{};
    const Image image = render(integrator, settings, report, done);
    if (show_progress) std::fprintf(stderr, "\n");

    // ---- Output
    const ExrAttributes attributes = {options.scene,        options.sampler.name,
                                      options.spp,          options.sampler.declared_spp,
                                      options.first_sample, options.max_depth,
                                      options.sampler.seed, done.seconds,
                                      done.ray_count,       options.threads};
    write_files({{exr_path, exr_encode(image, attributes)},
                 {png_path, png_encode_preview(image, options.exposure)}});
    if (!options.quiet)
        std::printf("%s: %s, %s, %u spp, %.2f s, %" PRIu64
                    " rays, %.2f M rays/s, %.2f %% cut off at depth %u\n",
                    options.output.c_str(), options.scene.c_str(), options.sampler.name.c_str(),
                    options.spp, done.seconds, done.ray_count,
                    1e-6 * static_cast<double>(done.ray_count) / done.seconds, 100 * done.cut_off,
                    options.max_depth);
    if (reference)
        std::printf("rmse %.6f  sigma 1.0 %.6f  sigma 2.1 %.6f\n",
                    blurred_rmse(image, *reference, 0), blurred_rmse(image, *reference, 1.0),
                    blurred_rmse(image, *reference, 2.1));
}

} // namespace

int main(int argc, char **argv) {
#ifdef SIGXFSZ
    // A file size limit is an error like a full disk, not a reason to die with half a file.
    std::signal(SIGXFSZ, SIG_IGN);
#endif
    try {
        const Options options = parse_options(argc, argv);
        if (options.help) {
            std::fputs(options_help(), stdout);
        } else if (options.list) {
            print_list();
        } else {
            run(options);
        }
        return 0;
    } catch (const std::bad_alloc &) {
        std::fprintf(stderr,
                     "pathtracer: out of memory; render the picture in parts with --crop\n");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "pathtracer: %s\n", error.what());
    }
    return 1;
}
