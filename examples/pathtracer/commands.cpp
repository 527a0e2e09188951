// SPDX-License-Identifier: Apache-2.0
// Rendering and merging, step by step. Everything that can fail early comes before the first ray.
#include "commands.h"

#include <unistd.h>

#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <optional>

#include "difference.h"
#include "error.h"
#include "exr.h"
#include "film.h"
#include "integrator.h"
#include "intersect.h"
#include "merge.h"
#include "outputs.h"
#include "render.h"
#include "resume.h"
#include "sampler.h"
#include "scene.h"

namespace {

// ---- Shared by rendering and merging

// The reference's pixels inside the crop; empty if there is no reference.
std::optional<Image> load_reference(const std::string &path, int full_width, int full_height,
                                    const Crop &crop) {
    if (path.empty()) return {};
    const Image image = exr_read(path);
    if (image.full_width != full_width || image.full_height != full_height)
        throw Error("the reference " + path + " has " + std::to_string(image.full_width) + "x" +
                    std::to_string(image.full_height) + " pixels, but the picture has " +
                    std::to_string(full_width) + "x" + std::to_string(full_height) +
                    "; set --size or choose another reference");
    if (crop.x0 < image.crop.x0 || crop.y0 < image.crop.y0 || crop.x1 > image.crop.x1 ||
        crop.y1 > image.crop.y1)
        throw Error("the reference " + path + " covers only a part of the picture");
    Image part = image_crop(image, crop);
    for (const float v : part.rgb)
        if (!std::isfinite(v))
            throw Error("the reference " + path + " has a value that is not finite");
    return part;
}

void print_error(const Image &image, const Image &reference) {
    std::printf("rmse %.6f  sigma 1.0 %.6f  sigma 2.1 %.6f\n", blurred_rmse(image, reference, 0),
                blurred_rmse(image, reference, 1.0), blurred_rmse(image, reference, 2.1));
}

// Prints even with --quiet. Partial pictures are exempt: they may well be empty.
void warn(const Film &film, float exposure, const std::string &extent) {
    if (pixel_count(film.crop) <
        static_cast<uint64_t>(film.full_width) * static_cast<uint64_t>(film.full_height))
        return;
    const std::string warning = film_warning(film, exposure, extent);
    if (!warning.empty()) say(warning);
}

// ---- Interrupts

// The signal of the first interrupt. A second one ends the program at once.
volatile std::sig_atomic_t interrupted = 0;

void interrupt(int signal) {
    interrupted = signal;
    std::signal(signal, end_without_temporary_files);
}

void listen_to_interrupts() {
    // If interrupts were ignored at start, as in a script's background jobs, keep ignoring them.
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (std::signal(signal, interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);
}

// ---- Before the first ray

// Everything that makes a picture, and what is known about it so far.
struct Picture {
    Options options; // with --resume, completed from that picture
    std::optional<ExrHead> resumed;
    Scene scene;
    SamplerPointer sampler;
    uint32_t spp; // target samples per pixel
    Crop crop;
    std::optional<Image> reference;
    ExrHead head;
    Film film;             // with --noise, of whole blocks around the crop
    Film own;              // the crop alone, if that is less
    double samples_before; // already in the resumed picture
    RenderTotals totals;
    std::vector<ConvergenceRow> convergence;
};

// Adds the files that are not read through the scene's folder.
void record_others(const Options &options, InputRecord &record) {
    for (const NamedFile &file : setting_files(options))
        if (file.role != "--scene") record.add_file(file.path);
}

Scene load_scene(const Options &options, InputRecord &record) {
    SceneOptions choices = scene_options(options);
    choices.record = &record;
    Scene scene = scene_build(options.scene, choices);
    if (!options.quiet)
        for (const std::string &note : scene.notes) say(note);
    if (options.light_samples) scene.light_samples = *options.light_samples;
    camera_fit(scene.camera, options.width, options.height);
    return scene;
}

// The target samples per pixel. A time limit may end rendering sooner.
uint32_t checked_spp(const Options &options, const Scene &scene, const Sampler &sampler) {
    const uint64_t last_sample = (uint64_t{1} << 32) / std::max(scene.light_samples, 1u);
    uint32_t spp = options.spp;
    if (options.time_limit > 0)
        spp = static_cast<uint32_t>(std::min<uint64_t>(
            spp, last_sample - std::min<uint64_t>(last_sample - 1, options.first_sample)));
    if (uint64_t{options.first_sample} + spp > last_sample)
        throw Error("--first-sample and --spp run past the last sample of " +
                    std::to_string(scene.light_samples) + " light samples each; take fewer");
    if (sampler.peer && uint64_t{options.first_sample} + spp > PeerSampler::INDEX_LIMIT)
        throw Error("--first-sample and --spp run past sample " +
                    std::to_string(PeerSampler::INDEX_LIMIT) + ", the last of '" +
                    options.sampler.name + "'; take fewer");
    return spp;
}

NoiseSettings noise_settings(const Options &options) {
    if (!(options.noise > 0)) return {};
    return {options.noise, options.min_spp, options.exposure.value_or(0)};
}

// The picture's header, as far as it is known before rendering. The camera must be fitted already.
ExrHead picture_settings(const Options &options, const Scene &scene, const Crop &crop) {
    ExrHead head{options.width, options.height, crop, {}};
    ExrAttributes &a = head.attributes;
    a.scene = options.scene;
    a.camera = camera_text(scene, scene.camera);
    a.matrices = camera_matrices(scene, options.width, options.height);
    a.environment = options.environment;
    a.sampler = options.sampler.name;
    a.draws = BN_DRAW_TABLE_VERSION;
    a.mask = options.sampler.mask;
    a.declared_spp = options.sampler.declared_spp;
    a.first_sample = options.first_sample;
    a.max_depth = options.max_depth;
    a.light_samples = scene.light_samples;
    a.single_scatter = options.single_scatter;
    a.photometric = options.photometric;
    a.noise = noise_settings(options);
    a.seed = options.sampler.seed;
    a.threads = options.threads;
    return head;
}

double sample_count(const Film &film) {
    double samples = 0;
    for (const FilmPixel &pixel : film.pixels) samples += pixel.count;
    return samples;
}

Picture prepare(const Options &options) {
    Picture p{};
    p.options = options;
    if (!options.resume.empty()) {
        p.resumed = resume_settings(p.options);
        check_options(p.options);
    }
    const Options &o = p.options;
    check_file_names(o);
    // Before and after: a file that changes meanwhile is an error.
    InputRecord record;
    record_others(o, record);
    p.scene = load_scene(o, record);
    check_file_names(o, record.files("--scene"));
    p.sampler = sampler_create(o.sampler);
    record_others(o, record);
    p.spp = checked_spp(o, p.scene, *p.sampler);
    p.crop = o.crop.value_or(Crop{0, 0, o.width, o.height});
    p.reference = load_reference(o.reference, o.width, o.height, p.crop);
    p.head = picture_settings(o, p.scene, p.crop);
    p.head.attributes.inputs = record.text();
    return p;
}

// An empty film, or the resumed picture's.
void prepare_film(Picture &p) {
    if (p.resumed) {
        resume_check(p.options.resume, *p.resumed, p.head, p.options.allow_changed);
        if (p.resumed->attributes.inputs != p.head.attributes.inputs)
            p.head.attributes.inputs.reset();
        p.film = resume_film(p.options.resume, p.spp);
    } else {
        p.film = film_create(p.options.width, p.options.height, p.crop);
    }
    const Crop blocks = whole_blocks(p.crop, p.options.width, p.options.height);
    if (p.options.noise > 0 && pixel_count(blocks) > pixel_count(p.crop))
        p.film = film_with_crop(p.film, blocks);
    p.samples_before = sample_count(p.film);
}

// The film of the crop.
const Film &own_pixels(Picture &p) {
    if (pixel_count(p.film.crop) == pixel_count(p.crop)) return p.film;
    p.own = film_with_crop(p.film, p.crop);
    return p.own;
}

// ---- Rendering

void print_progress(double fraction, const RenderTotals &totals) {
    const double rays_per_second =
        static_cast<double>(totals.counters.rays) / std::max(totals.seconds, 1e-9);
    std::fprintf(stderr, "\r%5.1f %%  %6.1f M rays/s", 100 * fraction, 1e-6 * rays_per_second);
    if (fraction > 0)
        std::fprintf(stderr, "  %.0f s left   ",
                     std::ceil(totals.seconds * (1 - fraction) / fraction));
    std::fflush(stderr);
}

// The header of the picture as rendered so far.
ExrAttributes current_attributes(const Picture &p, const Film &own, const Integrator &integrator,
                                 const RenderSettings &settings) {
    ExrAttributes a = p.head.attributes;
    a.spp = film_counts(own).most;
    a.end_sample = uint64_t{p.options.first_sample} + a.spp;
    a.seconds = p.totals.seconds;
    a.ray_count = p.totals.counters.rays;
    a.sampling_share = sampling_share(integrator, settings, p.film, p.totals);
    a.fireflies = film_fireflies(own);
    if (p.resumed) add_cost(a, p.resumed->attributes);
    return a;
}

struct Written {
    FrameEnd end;
    ExrAttributes attributes;
    float exposure; // of the preview
};

Written render(Picture &p, const Outputs &outputs) {
    const Options &o = p.options;
    const GeometryPointer geometry = geometry_build(p.scene);
    const Integrator integrator{&p.scene, geometry.get(), p.sampler.get(), o.max_depth};
    const FrameSettings settings = {
        {o.first_sample, o.threads, noise_settings(o)}, p.spp, o.time_limit, o.write_interval};
    const auto attributes = [&](const Film &own) {
        return current_attributes(p, own, integrator, settings.render);
    };

    const bool show_progress = !o.quiet && isatty(STDERR_FILENO);
    FrameEvents events;
    events.progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    events.pass_done = [&](uint32_t, const RenderTotals &so_far) {
        if (!outputs.wants_convergence()) return;
        const Film &own = own_pixels(p);
        p.convergence.push_back(
            convergence_row(film_image(own), *p.reference, film_mean_count(own), so_far.seconds));
    };
    events.write = [&](const RenderTotals &) {
        try {
            const Film &own = own_pixels(p);
            outputs.write(own, attributes(own), p.convergence);
        } catch (const Error &error) {
            // Hours of rendering may be at stake, and the disk may have room again by the end.
            say(std::string(error.what()) + "; rendering continues");
        }
    };
    listen_to_interrupts();
    const FrameEnd end = render_frame(integrator, settings, p.film, p.totals, events, interrupted);
    if (end != FrameEnd::INTERRUPTED) events.progress(1, p.totals);
    if (show_progress) std::fprintf(stderr, "\n");

    const Film &own = own_pixels(p);
    const ExrAttributes a = attributes(own);
    return {end, a, outputs.write(own, a, p.convergence)};
}

// ---- After the last ray

void report(Picture &p, const Written &written) {
    const Options &o = p.options;
    const PathCounters &counters = p.totals.counters;
    const Film &own = own_pixels(p);
    const SampleCounts counts = film_counts(own);
    if (written.end == FrameEnd::INTERRUPTED)
        say("interrupted; " + o.output + " has the picture so far, " +
            std::to_string(counts.least) + " to " + std::to_string(counts.most) + " spp");
    if (!o.quiet) {
        const double samples = sample_count(p.film) - p.samples_before;
        char mean[64] = "";
        if (o.noise > 0)
            std::snprintf(mean, sizeof mean, " to %u spp, %.6g on average", counts.most,
                          film_mean_count(own));
        std::printf("%s: %s, %s, %u%s, %.2f s, %" PRIu64 " rays, %.2f M rays/s, %.1f %% sampling, "
                    "%.2f %% cut off at depth %u, %" PRIu64 " fireflies\n",
                    without_controls(o.output).c_str(), without_controls(o.scene).c_str(),
                    o.sampler.name.c_str(), counts.least, o.noise > 0 ? mean : " spp",
                    p.totals.seconds, counters.rays,
                    1e-6 * static_cast<double>(counters.rays) / p.totals.seconds,
                    100 * written.attributes.sampling_share,
                    100 * counters.cut_off / std::max(samples, 1.0), o.max_depth,
                    written.attributes.fireflies);
    }
    warn(own, written.exposure, scene_extent_text(p.scene));
    if (counters.lost > 0)
        say(std::to_string(counters.lost) + " samples were not finite and count as black");
    if (p.reference) print_error(film_image(own), *p.reference);
}

} // namespace

SceneOptions scene_options(const Options &options) {
    SceneOptions result;
    result.camera = options.camera;
    if (!options.environment.empty())
        result.environment = std::make_shared<Environment>(environment_read(options.environment));
    result.single_scatter = options.single_scatter;
    result.photometric = options.photometric;
    result.allow_outside = options.allow_outside;
    return result;
}

std::string input_list(const Options &options) {
    InputRecord record;
    SceneOptions choices = scene_options(options);
    choices.record = &record;
    scene_build(options.scene, choices);
    record_others(options, record);
    return record.text();
}

int run_render(const Options &options) {
    Picture picture = prepare(options);
    const Outputs outputs(picture.options, picture.options.scene);
    prepare_film(picture);
    const Written written = render(picture, outputs);
    report(picture, written);
    return interrupted;
}

void run_merge(const Options &options) {
    check_file_names(options);
    const MergedPicture merged = merge_pictures(options.merge, options.allow_changed);
    const Film &film = merged.film;
    const std::optional<Image> reference =
        load_reference(options.reference, film.full_width, film.full_height, film.crop);
    const float exposure =
        Outputs(options, merged.attributes.scene).write(film, merged.attributes, {});
    warn(film, exposure, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (!options.quiet)
        std::printf("%s: %zu pictures merged, %u to %u spp, %" PRIu64 " fireflies\n",
                    without_controls(options.output).c_str(), options.merge.size(), counts.least,
                    counts.most, merged.attributes.fireflies);
    if (reference) print_error(film_image(film), *reference);
}
