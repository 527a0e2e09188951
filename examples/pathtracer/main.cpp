// SPDX-License-Identifier: Apache-2.0
// The program: everything that can fail early is tried before the first ray.
#include <unistd.h>

#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>

#include "convergence.h"
#include "difference.h"
#include "error.h"
#include "exposure.h"
#include "exr.h"
#include "film.h"
#include "frame.h"
#include "integrator.h"
#include "intersect.h"
#include "merge.h"
#include "options.h"
#include "outputs.h"
#include "resume.h"
#include "sampler.h"
#include "scene.h"
#include "scene_file.h"

namespace {

void print_list() {
    std::printf("scenes:\n");
    for (const SceneEntry &entry : scene_entries())
        std::printf("  %-10s %s\n", entry.name, entry.summary);
    std::printf("samplers:\n");
    int width = 10;
    for (const SamplerEntry &entry : sampler_entries())
        width = std::max(width, static_cast<int>(std::strlen(entry.name)));
    for (const SamplerEntry &entry : sampler_entries())
        std::printf("  %-*s %s\n", width, entry.name, entry.summary);
}

void print_progress(double fraction, const RenderTotals &totals) {
    const double rays_per_second =
        static_cast<double>(totals.counters.rays) / std::max(totals.seconds, 1e-9);
    std::fprintf(stderr, "\r%5.1f %%  %6.1f M rays/s", 100 * fraction, 1e-6 * rays_per_second);
    if (fraction > 0)
        std::fprintf(stderr, "  %.0f s left   ",
                     std::ceil(totals.seconds * (1 - fraction) / fraction));
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

void print_error(const Image &image, const Image &reference) {
    std::printf("rmse %.6f  sigma 1.0 %.6f  sigma 2.1 %.6f\n", blurred_rmse(image, reference, 0),
                blurred_rmse(image, reference, 1.0), blurred_rmse(image, reference, 2.1));
}

// Loud enough for --quiet. Parts of a picture may well be empty.
void warn(const Film &film, float exposure, const std::string &extent) {
    if (pixel_count(film.crop) <
        static_cast<uint64_t>(film.full_width) * static_cast<uint64_t>(film.full_height))
        return;
    const std::string warning = film_warning(film, exposure, extent);
    if (!warning.empty()) std::fprintf(stderr, "pathtracer: %s\n", warning.c_str());
}

void run_merge(const Options &options) {
    check_file_names(options);
    const MergedPicture merged = merge_pictures(options.merge);
    const Film &film = merged.film;
    std::optional<Image> reference;
    if (!options.reference.empty())
        reference = load_reference(options.reference, film.full_width, film.full_height, film.crop);
    const float exposure =
        Outputs(options, merged.attributes.scene).write(film, merged.attributes, {});
    warn(film, exposure, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (!options.quiet)
        std::printf("%s: %zu pictures merged, %u to %u spp, %" PRIu64 " fireflies\n",
                    options.output.c_str(), options.merge.size(), counts.least, counts.most,
                    merged.attributes.fireflies);
    if (reference) print_error(film_image(film), *reference);
}

// Set by an interrupt. The second one ends the program at once.
volatile std::sig_atomic_t interrupted = 0;

void interrupt(int signal) {
    interrupted = signal;
    std::signal(signal, SIG_DFL);
}

void listen_to_interrupts() {
    // Those started with interrupts ignored, in the background of a script, go on ignoring them.
    for (const int signal : {SIGINT, SIGTERM})
        if (std::signal(signal, interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);
}

SceneOptions scene_options(const Options &options) {
    SceneOptions result;
    result.camera = options.camera;
    if (!options.environment.empty())
        result.environment = std::make_shared<Environment>(environment_read(options.environment));
    result.single_scatter = options.single_scatter;
    result.photometric = options.photometric;
    return result;
}

// What the picture's header says of it before it is rendered. The camera is fitted to it.
ExrHead picture_settings(const Options &options, const Scene &scene, const Crop &crop) {
    ExrHead head{options.width, options.height, crop, {}};
    ExrAttributes &a = head.attributes;
    a.scene = options.scene;
    a.camera = camera_text(scene, scene.camera);
    a.matrices = camera_matrices(scene, options.width, options.height);
    a.environment = options.environment;
    a.sampler = options.sampler.name;
    a.mask = options.sampler.mask;
    a.declared_spp = options.sampler.declared_spp;
    a.first_sample = options.first_sample;
    a.max_depth = options.max_depth;
    a.light_samples = scene.light_samples;
    a.single_scatter = options.single_scatter;
    a.photometric = options.photometric;
    a.seed = options.sampler.seed;
    a.threads = options.threads;
    return head;
}

double sample_count(const Film &film) {
    double samples = 0;
    for (const FilmPixel &pixel : film.pixels) samples += pixel.count;
    return samples;
}

void run_render(Options options) {
    // ---- Everything that may be wrong
    std::optional<ExrHead> resumed;
    if (!options.resume.empty()) {
        resumed = resume_settings(options);
        check_options(options);
    }
    check_file_names(options);
    Scene scene = scene_build(options.scene, scene_options(options));
    if (!options.quiet)
        for (const std::string &note : scene.notes)
            std::fprintf(stderr, "pathtracer: %s\n", note.c_str());
    if (options.light_samples > 0) scene.light_samples = options.light_samples;
    const uint64_t last_sample = (uint64_t{1} << 32) / scene.light_samples;
    uint32_t spp = options.spp;
    if (options.time_limit > 0)
        spp = static_cast<uint32_t>(std::min<uint64_t>(
            spp, last_sample - std::min<uint64_t>(last_sample - 1, options.first_sample)));
    if (uint64_t{options.first_sample} + spp > last_sample)
        throw Error("--first-sample and --spp run past the last sample of " +
                    std::to_string(scene.light_samples) + " light samples each; take fewer");
    camera_fit(scene.camera, options.width, options.height);
    const SamplerPointer sampler = sampler_create(options.sampler);
    if (sampler->peer && uint64_t{options.first_sample} + spp > PeerSampler::INDEX_LIMIT)
        throw Error("--first-sample and --spp run past sample " +
                    std::to_string(PeerSampler::INDEX_LIMIT) + ", the last of '" +
                    options.sampler.name + "'; take fewer");
    const Crop crop = options.crop.value_or(Crop{0, 0, options.width, options.height});
    std::optional<Image> reference;
    if (!options.reference.empty())
        reference = load_reference(options.reference, options.width, options.height, crop);
    const Outputs outputs(options, options.scene);
    const ExrHead wanted = picture_settings(options, scene, crop);
    Film film;
    if (resumed) {
        resume_check(options.resume, *resumed, wanted);
        film = resume_film(options.resume, spp);
    } else {
        film = film_create(options.width, options.height, crop);
    }

    const double samples_before = sample_count(film);

    // ---- Rendering
    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator =
        integrator_create(scene, *geometry, sampler.get(), options.max_depth);
    const FrameSettings settings = {
        {options.first_sample, options.threads}, spp, options.time_limit, options.write_interval};
    RenderTotals totals;
    std::vector<ConvergenceRow> rows;

    const auto attributes = [&] {
        ExrAttributes a = wanted.attributes;
        a.spp = film_counts(film).most;
        a.end_sample = uint64_t{options.first_sample} + a.spp;
        a.seconds = totals.seconds;
        a.ray_count = totals.counters.rays;
        a.sampling_share = sampling_share(integrator, settings.render, film, totals);
        a.fireflies = film_fireflies(film);
        if (resumed) add_cost(a, resumed->attributes);
        return a;
    };

    const bool show_progress = !options.quiet && isatty(STDERR_FILENO);
    FrameEvents events;
    events.progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    events.pass_done = [&](uint32_t count, const RenderTotals &so_far) {
        if (outputs.wants_convergence())
            rows.push_back(convergence_row(film_image(film), *reference, count, so_far.seconds));
    };
    events.write = [&](const RenderTotals &) {
        try {
            outputs.write(film, attributes(), rows);
        } catch (const Error &error) {
            // Hours of rendering may be at stake: the disk may have room again at the end.
            std::fprintf(stderr, "pathtracer: %s; rendering goes on\n", error.what());
        }
    };
    listen_to_interrupts();
    const FrameEnd end = render_frame(integrator, settings, film, totals, events, interrupted);
    if (end != FrameEnd::INTERRUPTED) events.progress(1, totals);
    if (show_progress) std::fprintf(stderr, "\n");

    // ---- Output
    const ExrAttributes a = attributes();
    const float exposure = outputs.write(film, a, rows);
    const PathCounters &counters = totals.counters;
    const SampleCounts counts = film_counts(film);
    if (end == FrameEnd::INTERRUPTED)
        std::fprintf(stderr, "pathtracer: interrupted; %s holds what there is, %u to %u spp\n",
                     options.output.c_str(), counts.least, counts.most);
    if (!options.quiet) {
        const double samples = sample_count(film) - samples_before;
        std::printf(
            "%s: %s, %s, %u spp, %.2f s, %" PRIu64 " rays, %.2f M rays/s, %.1f %% sampling, "
            "%.2f %% cut off at depth %u, %" PRIu64 " fireflies\n",
            options.output.c_str(), options.scene.c_str(), options.sampler.name.c_str(),
            counts.least, totals.seconds, counters.rays,
            1e-6 * static_cast<double>(counters.rays) / totals.seconds, 100 * a.sampling_share,
            100 * counters.cut_off / std::max(samples, 1.0), options.max_depth, a.fireflies);
    }
    warn(film, exposure, scene_extent_text(scene));
    if (counters.lost > 0)
        std::fprintf(stderr,
                     "pathtracer: %" PRIu64 " samples were no finite numbers and count as black\n",
                     counters.lost);
    if (reference) print_error(film_image(film), *reference);
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
        } else if (options.list_cameras) {
            const Scene scene = scene_build(options.scene, scene_options(options));
            std::fputs(camera_list(scene).c_str(), stdout);
        } else {
            if (options.merge.empty())
                run_render(options);
            else
                run_merge(options);
        }
        // As the shell has it: a script sees that the picture is not complete.
        return interrupted ? 128 + static_cast<int>(interrupted) : 0;
    } catch (const std::bad_alloc &) {
        std::fprintf(stderr,
                     "pathtracer: out of memory; render the picture in parts with --crop\n");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "pathtracer: %s\n", error.what());
    }
    return 1;
}
