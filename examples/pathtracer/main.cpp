// SPDX-License-Identifier: Apache-2.0
// The program: rendering and merging, step by step. Everything that can fail early comes before the
// first ray.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <optional>

#include "error.h"
#include "exr.h"
#include "film.h"
#include "integrator.h"
#include "intersect.h"
#include "options.h"
#include "outputs.h"
#include "render.h"
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
        throw Error("the reference ", path, " has ", image.full_width, "x", image.full_height,
                    " pixels, but the picture has ", full_width, "x", full_height,
                    "; set --size or choose another reference");
    if (crop.x0 < image.crop.x0 || crop.y0 < image.crop.y0 || crop.x1 > image.crop.x1 ||
        crop.y1 > image.crop.y1)
        throw Error("the reference ", path, " covers only a part of the picture");
    Image part = image_crop(image, crop);
    for (const Vec3 v : part.rgb)
        if (!is_finite(v)) throw Error("the reference ", path, " has a value that is not finite");
    return part;
}

void print_error(const Image &image, const Image &reference) {
    std::printf("rmse %.6f  sigma 1.0 %.6f  sigma 2.1 %.6f\n", blurred_rmse(image, reference, 0),
                blurred_rmse(image, reference, 1.0), blurred_rmse(image, reference, 2.1));
}

// Prints even with --quiet. Partial pictures are exempt: they may well be empty.
void warn(const Film &film, const std::string &extent) {
    if (pixel_count(film.crop) <
        static_cast<uint64_t>(film.full_width) * static_cast<uint64_t>(film.full_height))
        return;
    const std::string warning = film_warning(film, extent);
    if (!warning.empty()) say(warning);
}

// ---- Interrupts

// The signal of the first interrupt. A second one ends the program at once.
volatile std::sig_atomic_t interrupted = 0;

void interrupt(int signal) {
    interrupted = signal;
    std::signal(signal, SIG_DFL);
}

void listen_to_interrupts() {
    // If interrupts were ignored at start, as in a script's background jobs, keep ignoring them.
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (std::signal(signal, interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);
}

// ---- Before the first ray

// Adds the files that are not read through the scene's folder.
void record_others(const Options &options, InputRecord &record) {
    for (const NamedFile &file : setting_files(options))
        if (file.role != "--scene") record.add_file(file.path);
}

// The options that affect the scene. Reads the environment.
SceneOptions scene_options(const Options &options, InputRecord *record = nullptr) {
    std::shared_ptr<const Environment> environment;
    if (!options.environment.empty())
        environment =
            std::make_shared<Environment>(environment_read(options.environment, options.clamp));
    return {options.camera,        environment,         options.single_scatter,
            options.allow_outside, options.photometric, record};
}

Scene load_scene(const Options &options, InputRecord &record) {
    Scene scene = scene_build(options.scene, scene_options(options, &record));
    if (!options.quiet)
        for (const std::string &note : scene.notes) say(note);
    if (options.light_samples) scene.light_samples = *options.light_samples;
    camera_fit(scene.camera, options.width, options.height);
    return scene;
}

void check_samples(const Options &options, const Scene &scene, const Sampler &sampler) {
    const uint64_t end = uint64_t{options.first_sample} + options.spp;
    if (end > (uint64_t{1} << 32) / std::max(scene.light_samples, 1u))
        throw Error("--first-sample and --spp run past the last sample of ", scene.light_samples,
                    " light samples each; take fewer");
    if (sampler.peer && end > PeerSampler::INDEX_LIMIT)
        throw Error("--first-sample and --spp run past sample ", PeerSampler::INDEX_LIMIT,
                    ", the last of '", options.sampler.name, "'; take fewer");
}

// What is known of the picture before rendering. The camera must be fitted already.
ExrAttributes picture_settings(const Options &options, const Scene &scene) {
    ExrAttributes a{};
    static_cast<PictureSettings &>(a) = options;
    if (!scene.cameras.empty())
        a.camera = "--camera " + std::to_string(options.camera.number.value_or(0)) + " ";
    a.camera += camera_text(scene, scene.camera);
    a.draws = BN_DRAW_TABLE_VERSION;
    a.first_sample = options.first_sample;
    a.light_samples = scene.light_samples;
    if (options.noise.level > 0)
        a.noise.exposure = options.exposure.value_or(0);
    else
        a.noise = {};
    a.threads = options.threads;
    return a;
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

// What a run without --quiet prints about its picture. Takes the samples of the whole film.
void print_summary(const Options &o, const ExrAttributes &a, const RenderTotals &totals,
                   const SampleCounts &counts, double mean_count, double samples) {
    char mean[64] = "";
    if (o.noise.level > 0)
        std::snprintf(mean, sizeof mean, " to %u spp, %.6g on average", counts.most, mean_count);
    std::printf("%s: %s, %s, %u%s, %.2f s, %" PRIu64 " rays, %.2f M rays/s, %.1f %% sampling, "
                "%.2f %% cut off at depth %u\n",
                without_controls(o.output).c_str(), without_controls(o.scene).c_str(),
                o.sampler.name.c_str(), counts.least, o.noise.level > 0 ? mean : " spp",
                totals.seconds, totals.counters.rays,
                1e-6 * static_cast<double>(totals.counters.rays) / totals.seconds,
                100 * a.sampling_share, 100 * totals.counters.cut_off / std::max(samples, 1.0),
                o.max_depth);
}

// Reads all files of a picture. Returns their names and hashes.
std::string input_list(const Options &options) {
    InputRecord record;
    scene_build(options.scene, scene_options(options, &record));
    record_others(options, record);
    return record.text();
}

// Renders a picture and writes it. Returns the signal that interrupted it, or 0.
int run_render(const Options &given) {
    Options o = given;
    std::optional<ExrHead> resumed;
    if (!o.resume.empty()) resumed = resume_settings(o);
    check_file_names(o, setting_files(o));
    // Before and after: a file that changes meanwhile is an error.
    InputRecord record;
    record_others(o, record);
    const Scene scene = load_scene(o, record);
    check_file_names(o, record.files("--scene"));
    const SamplerPointer sampler = sampler_create(o.sampler);
    record_others(o, record);
    check_samples(o, scene, *sampler);
    const Crop crop = o.crop.value_or(Crop{0, 0, o.width, o.height});
    const std::optional<Image> reference = load_reference(o.reference, o.width, o.height, crop);
    ExrAttributes attributes = picture_settings(o, scene);
    attributes.inputs = record.text();
    check_outputs(o);
    Film film = resumed ? resume_film(o, *resumed, {o.width, o.height, crop, attributes})
                        : film_create(o.width, o.height, crop);
    if (o.noise.level > 0) film = film_with_crop(film, whole_blocks(crop, o.width, o.height));
    const double samples_before = film_samples(film);

    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), o.max_depth};
    const RenderSettings settings = {o.spp, o.first_sample, o.threads, attributes.noise,
                                     o.time_limit};
    RenderTotals totals;
    const bool show_progress = !o.quiet && isatty(STDERR_FILENO);
    const auto progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    listen_to_interrupts();
    const bool complete = render_frame(integrator, settings, film, totals, progress, interrupted);
    if (complete) progress(1, totals);
    if (show_progress) std::fprintf(stderr, "\n");

    attributes.sampling_share = sampling_share(integrator, settings, film, totals);
    const double samples = film_samples(film) - samples_before; // also of blocks beyond the crop
    if (o.noise.level > 0) film = film_with_crop(film, crop);
    const SampleCounts counts = film_counts(film);
    attributes.spp = counts.most;
    attributes.end_sample = uint64_t{o.first_sample} + counts.most;
    attributes.seconds = totals.seconds;
    attributes.ray_count = totals.counters.rays;
    if (resumed) add_part(attributes, resumed->attributes);
    write_outputs(o, film, attributes);

    if (!complete)
        say("interrupted; " + o.output + " has the picture so far, " +
            std::to_string(counts.least) + " to " + std::to_string(counts.most) + " spp");
    if (!o.quiet)
        print_summary(o, attributes, totals, counts,
                      film_samples(film) / static_cast<double>(film.pixels.size()), samples);
    warn(film, scene_extent_text(scene));
    if (totals.counters.lost > 0)
        say(std::to_string(totals.counters.lost) + " samples were not finite and count as black");
    if (reference) print_error(film_image(film), *reference);
    return interrupted;
}

// Merges a picture from parts and writes it.
void run_merge(const Options &options) {
    std::vector<NamedFile> parts;
    for (const std::string &part : options.merge) parts.push_back({"--merge", part});
    check_file_names(options, parts);
    const MergedPicture merged = merge_pictures(options.merge, options.allow_changed);
    const Film &film = merged.film;
    const std::optional<Image> reference =
        load_reference(options.reference, film.full_width, film.full_height, film.crop);
    check_outputs(options);
    write_outputs(options, film, merged.attributes);
    warn(film, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (!options.quiet)
        std::printf("%s: %zu pictures merged, %u to %u spp\n",
                    without_controls(options.output).c_str(), options.merge.size(), counts.least,
                    counts.most);
    if (reference) print_error(film_image(film), *reference);
}

// ---- The process

// Opens /dev/null for each standard stream that is closed. Otherwise a picture could get the
// stream's number, and then its text too.
void occupy_closed_streams() {
    for (int descriptor = 0; descriptor < 3; ++descriptor)
        if (fcntl(descriptor, F_GETFD) < 0) open("/dev/null", O_RDONLY);
}

constexpr double GIB = 1024.0 * 1024 * 1024;

// Bytes of such memory already taken, which under sanitizers is terabytes that are never touched.
double taken() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int field = 0; field < 6; ++field) file >> pages; // the sixth: data and stack
    return file ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

// From here on, allocations beyond this many GiB, by default half of the machine's, fail, those of
// libraries and threads too: a scene made to waste memory ends in one line and not with the
// machine's. 0 is no bound. Works on Linux from 4.7 on; elsewhere some systems do without.
void limit_memory(std::optional<double> chosen) {
    const double half = 0.5 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
                        static_cast<double>(sysconf(_SC_PAGESIZE)) / GIB;
    const double gib = chosen.value_or(half);
    if (!(gib > 0)) return;
    rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit) != 0) return;
    const double bytes = taken() + gib * GIB;
    // A bound that is lower already stays.
    if (limit.rlim_cur != RLIM_INFINITY && static_cast<double>(limit.rlim_cur) <= bytes) return;
    limit.rlim_cur = static_cast<rlim_t>(bytes);
    if (limit.rlim_max != RLIM_INFINITY) limit.rlim_cur = std::min(limit.rlim_cur, limit.rlim_max);
    setrlimit(RLIMIT_DATA, &limit);
}

// The exit status of a run that went well, if all that it printed has arrived.
int status_of_output() {
    const bool failed = std::ferror(stdout) != 0;
    if (std::fflush(stdout) == 0 && !failed) return 0;
    say(std::string("cannot write to standard output: ") +
        (failed ? "not all of it arrived" : std::strerror(errno)));
    return 1;
}

template <typename Entry>
void print_entries(const char *what, const std::vector<Entry> &entries) {
    size_t width = 10;
    for (const Entry &entry : entries) width = std::max(width, std::strlen(entry.name));
    std::printf("%s:\n", what);
    for (const Entry &entry : entries)
        std::printf("  %-*s %s\n", static_cast<int>(width), entry.name, entry.summary);
}

} // namespace

int main(int argc, char **argv) {
    occupy_closed_streams();
    exit_where_it_would_abort();
#ifdef SIGXFSZ
    // Treat a file size limit as an error, like a full disk, instead of dying with half a file.
    std::signal(SIGXFSZ, SIG_IGN);
#endif
    try {
        const Options options = parse_options(argc, argv);
        limit_memory(options.max_memory);
        if (options.help) {
            std::fputs(options_help(), stdout);
        } else if (options.list) {
            print_entries("scenes", scene_entries());
            print_entries("samplers", sampler_entries());
        } else if (options.list_cameras) {
            const Scene scene = scene_build(options.scene, scene_options(options));
            std::fputs(camera_list(scene).c_str(), stdout);
        } else if (options.list_inputs) {
            std::fputs(input_list(options).c_str(), stdout);
        } else if (!options.merge.empty()) {
            run_merge(options);
        } else {
            const int signal = run_render(options);
            // The shell's convention: a script sees that the picture is incomplete.
            if (signal) return 128 + signal;
        }
        return status_of_output();
    } catch (const std::bad_alloc &) {
        say("out of memory; render the picture in parts with --crop, or allow more with "
            "--max-memory");
    } catch (const std::exception &error) {
        say(error.what());
    }
    return 1;
}
