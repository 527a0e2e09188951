// SPDX-License-Identifier: Apache-2.0
// The program: rendering and merging, step by step. Everything that can fail early is done before the
// first ray. In an interrupted image, each pixel holds its first samples, and some hold more than
// others. The counts tell which samples are missing, so no other state is needed.
#include <sys/resource.h>
#include <unistd.h>

#include <cinttypes>
#include <cstdio>
#include <exception>
#include <fstream>
#include <new>

#include "files.h"
#include "film.h"
#include "integrator.h"
#include "intersect.h"
#include "options.h"
#include "sampler.h"
#include "scene.h"

namespace fs = std::filesystem;

namespace {

// ---- Files

fs::path preview_path(const Options &o) {
    return fs::path(o.text("-o")).replace_extension(".png");
}

// Throws Error unless both outputs can be written and differ from all files that are read.
void check_outputs(const Options &o, std::vector<std::string> inputs) {
    const fs::path exr = o.text("-o"), png = preview_path(o);
    if (is_same_file(exr, png)) throw Error("-o and its preview ", png.string(), " are one file");
    for (const fs::path &output : {exr, png}) {
        for (const std::string &input : inputs)
            if (is_same_file(output, input))
                throw Error(output == exr ? "-o" : "the preview of -o", " would overwrite ",
                            output.string(), ", which is read as ", input,
                            "; give the output another name");
        check_writable(output);
        // -o may replace this one, but the preview may not.
        if (!o.text("--resume").empty()) inputs.push_back(o.text("--resume"));
    }
}

// Warns even with --quiet if the image is empty; `extent` describes the scene's bounds.
void write_outputs(const Options &o, const Film &film, ExrHead head, const std::string &extent) {
    float &exposure = head.statistics.exposure;
    const bool automatic = o.has_auto_exposure(head.settings["scene"]);
    exposure = automatic ? auto_exposure(film) : o.number<float>("--exposure");
    write_files({{o.text("-o"), exr_encode(film, head)},
                 {preview_path(o), png_encode_preview(film_image(film), exposure)}});
    if (automatic && !o.flag("--quiet"))
        std::printf("automatic exposure: %g stops\n", double(exposure));
    if (const std::string warning = film_warning(film, extent); !warning.empty()) say(warning);
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

// Builds or reads the scene, and prints what it lacks. Its inputs include the environment and the sampler's file.
Scene load_scene(const Options &o) {
    SceneOptions options = {o.optional<uint32_t>("--camera"),
                            o.point("--eye"),
                            o.point("--target"),
                            o.optional<double>("--fov"),
                            o.optional<float>("--lens"),
                            o.optional<float>("--focus")};
    options.photometric = o.flag("--photometric");
    std::vector<std::string> files = plugin_files(o.text("--sampler"));
    if (const std::string &sky = o.text("--env"); !sky.empty()) {
        if (sky != "sky" && sky != "none") files.push_back(sky);
        options.environment =
            std::make_shared<Environment>(environment_read(sky, o.flag("--clamp")));
    }
    Scene scene = scene_build(o.text("--scene"), options);
    for (const std::string &file : files)
        named("cannot read " + file, [&] { scene.inputs.read(file); });
    for (const std::string &note : scene.notes) say(note);
    return scene;
}

void check_samples(const Options &o, const Scene &scene, const Sampler &sampler) {
    const auto end = o.number<uint64_t>("--first-sample") + o.number<uint64_t>("--spp");
    const uint64_t limit = std::min((uint64_t{1} << 32) / scene.light_samples,
                                    sampler.plugin ? PLUGIN_INDEX_LIMIT : UINT64_MAX);
    if (end > limit)
        throw Error("--first-sample and --spp run past sample ", limit - 1, ", the last of '",
                    o.text("--sampler"), "' with --light-samples ", scene.light_samples);
}

// The header, as far as it is known before rendering. The camera must already be fitted.
ExrHead image_head(const Options &o, const Scene &scene) {
    const std::vector<int> size = o.integers("--size");
    ExrHead head{{size[0], size[1], o.crop()}};
    for (const std::string &name : Options::settings())
        head.settings[name.substr(2)] = o.text(name);
    std::string &camera = head.settings["camera"];
    if (!scene.cameras.empty())
        camera = "--camera " + std::to_string(o.number<uint32_t>("--camera")) + " ";
    camera += camera_text(scene, scene.camera);
    head.settings["draws"] = std::to_string(BN_DRAW_TABLE_VERSION);
    head.settings["inputs"] = scene.inputs.text(); // the rest may depend on their contents
    head.settings["light-samples"] = std::to_string(scene.light_samples);
    head.settings["noise-exposure"] =
        o.is_adaptive() ? shortest(o.number<double>("--exposure")) : "";
    head.statistics.first_sample = o.number<uint64_t>("--first-sample");
    head.statistics.threads = o.number<unsigned>("--threads");
    return head;
}

// ---- Images in parts

using Settings = std::map<std::string, std::string>;

// The settings that all parts of an image share and, if `own` is set, the part's position.
Settings settings_of(const ExrHead &head, bool own) {
    Settings all = head.settings;
    all["size"] = joined(head.full_width, "x", head.full_height);
    if (!own) return all;
    const Crop &c = head.crop;
    all["crop"] = joined(c.x0, ",", c.y0, ",", c.x1, ",", c.y1);
    all["first-sample"] = std::to_string(head.statistics.first_sample);
    return all;
}

// The first line that differs, such as "seed: '1' and '2'"; empty if there is none.
std::string difference(Settings one, Settings other) {
    Settings all = one;
    all.insert(other.begin(), other.end());
    for (const auto &[name, unused] : all) {
        const std::string &a = one[name], &b = other[name];
        if (a == b) continue;
        const auto [end, unused_too] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
        const size_t start = std::string(a.begin(), end).rfind('\n') + 1;
        const auto line = [&](const std::string &text) {
            return text.substr(start, text.find('\n', start) - start);
        };
        return joined(name, ": '", line(a), "' and '", line(b), "'");
    }
    return "";
}

// Adds the cost of a part, as if one machine had rendered everything.
void add_part(ImageStatistics &to, const ImageStatistics &part) {
    to.seconds += part.seconds;
    to.ray_count += part.ray_count;
    to.threads = std::max(to.threads, part.threads);
}

// Adds a part's samples to a pixel that lacks samples from `next` on.
void add_samples(FilmPixel &to, const FilmPixel &from, int x, int y, uint64_t next, uint64_t begin,
                 const std::string &path) {
    if (from.count == 0) return;
    if (begin < next)
        throw Error(path, " contains the same samples of pixel ", x, ",", y, " as another part");
    if (begin > next)
        throw Error("samples ", next, " to ", begin - 1, " of pixel ", x, ",", y,
                    " are missing before ", path, "; add --first-sample ", next, " --spp ",
                    begin - next, ", or --resume it");
    film_merge(to, from);
}

// Merges parts of the same settings and files. Where they overlap they must hold different samples, and
// each pixel's samples must be consecutive. Holds only the result and one part in memory. Throws Error.
Film merge_images(const std::vector<std::string> &paths, ExrHead &merged) {
    merged = exr_read_head(paths[0]);
    ImageStatistics &all = merged.statistics;
    Crop &crop = merged.crop;
    std::multimap<uint64_t, std::string> order; // by first sample: pixels fill up without gaps
    for (const std::string &path : paths) {
        const ExrHead head = exr_read_head(path);
        const std::string differs =
            difference(settings_of(head, false), settings_of(merged, false));
        if (!differs.empty())
            throw Error(path, " and ", paths[0], " are not parts of one image: they differ in ",
                        differs);
        const Crop &c = head.crop;
        crop = {std::min(crop.x0, c.x0), std::min(crop.y0, c.y0), std::max(crop.x1, c.x1),
                std::max(crop.y1, c.y1)};
        all.first_sample = std::min(all.first_sample, head.statistics.first_sample);
        all.end_sample = std::max(all.end_sample, head.statistics.end_sample);
        if (!order.empty()) add_part(all, head.statistics);
        order.emplace(head.statistics.first_sample, path);
    }
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("the parts span more than ", MAX_PIXELS, " pixels; merge fewer of them");
    Film film = film_create(merged.full_width, merged.full_height, crop);
    for (const auto &[first, path] : order) {
        const Film part = exr_read_film(path);
        each_pixel(part.crop, [&](int x, int y) {
            FilmPixel &to = film_pixel(film, x, y);
            add_samples(to, film_pixel(part, x, y), x, y, all.first_sample + to.count, first, path);
        });
    }
    all.spp = film_counts(film).most;
    return film;
}

// Takes all settings that are not on the command line from the image to continue. Throws Error.
ExrHead resume_settings(Options &o) {
    const std::string &resumed = o.text("--resume");
    const ExrHead head = exr_read_head(resumed);
    Settings values = settings_of(head, true);
    values["spp"] = std::to_string(std::max(head.statistics.spp, 1u));
    values["exposure"] = values["noise-exposure"];
    const auto take = [&](const std::string &name, const std::string &value) {
        try {
            if (!o.given(name) && !value.empty()) o.set(name, value);
        } catch (const Error &error) {
            throw Error(resumed, " cannot be continued: ", error.what());
        }
    };
    std::vector<std::string> names = Options::settings();
    names.insert(names.end(), {"--size", "--crop", "--first-sample", "--spp", "--exposure"});
    if (!plugin_files(values["sampler"]).empty() && !o.given("--sampler"))
        throw Error(resumed, " was rendered with a plug-in, which must be named again: --sampler ",
                    without_controls(values["sampler"]));
    for (const std::string &name : names) take(name, values[name.substr(2)]);
    const std::string camera[] = {"--camera", "--eye", "--target", "--fov"};
    const auto given = [&](const std::string &name) { return o.given(name); };
    std::istringstream words(values["camera"]);
    for (std::string name, value; words >> name >> value;)
        if (std::none_of(std::begin(camera), std::end(camera), given) &&
            std::count(std::begin(camera), std::end(camera), name) > 0)
            take(name, value);
    o.check();
    return head;
}

// Reads the samples. Throws Error with the difference unless they can be continued as `wanted`.
Film resume_film(const Options &o, const ExrHead &image, const ExrHead &wanted) {
    const std::string &path = o.text("--resume");
    const std::string differs = difference(settings_of(image, true), settings_of(wanted, true));
    if (!differs.empty())
        throw Error(path, " is not an earlier state of this image: they differ in ", differs,
                    "; options that you leave out are taken from it");
    Film film = exr_read_film(path);
    const SampleCounts counts = film_counts(film);
    const auto spp = o.number<uint32_t>("--spp");
    if (counts.most > spp || counts.least >= spp)
        throw Error(path, " has ", counts.least, " to ", counts.most,
                    " samples in each pixel already; give a larger --spp");
    return film;
}

void print_noise(const Film &film) {
    if (const double noise = film_noise(film); noise != UNMEASURED)
        std::printf("95%% of the image is below %.2f steps of visible noise\n", noise);
}

// ---- Rendering

void print_progress(double fraction, const RenderTotals &totals) {
    std::fprintf(stderr, "\r%5.1f%%  %6.1f M rays/s", 100 * fraction,
                 1e-6 * double(totals.rays) / std::max(totals.seconds, 1e-9));
    if (fraction > 0)
        std::fprintf(stderr, "  %.0f s left   ",
                     std::ceil(totals.seconds * (1 - fraction) / fraction));
    std::fflush(stderr);
}

void print_summary(const Options &o, const Film &film, const RenderTotals &totals) {
    const SampleCounts counts = film_counts(film);
    std::string spp = std::to_string(counts.least) + " spp";
    if (o.is_adaptive())
        spp = joined(counts.least, " to ", counts.most, " spp, ", counts.mean, " on average");
    const auto rays = double(totals.rays);
    std::printf("%s: %s, %s, %s, %.2f s, %.0f rays, %.2f M rays/s, %.2f%% cut off at depth %s\n",
                without_controls(o.text("-o")).c_str(), without_controls(o.text("--scene")).c_str(),
                o.text("--sampler").c_str(), spp.c_str(), totals.seconds, rays,
                1e-6 * rays / totals.seconds,
                100 * totals.cut_off / std::max(double(totals.paths), 1.0),
                o.text("--max-depth").c_str());
    print_noise(film);
}

// Renders an image and writes it. Returns the signal that interrupted it, or 0.
int run_render(Options o) {
    const bool resumes = !o.text("--resume").empty();
    const ExrHead resumed = resumes ? resume_settings(o) : ExrHead{};
    Scene scene = load_scene(o);
    if (scene.cameras.size() > 1 && o.text("--camera").empty() && o.text("--eye").empty() &&
        !o.flag("--quiet"))
        say(joined(o.text("--scene"), ": shows the first of ", scene.cameras.size(),
                   " cameras; see --list-cameras and --camera"));
    std::vector<std::string> inputs;
    for (const auto &file : scene.inputs.files) inputs.push_back(file.first);
    check_outputs(o, inputs);
    if (!o.text("--light-samples").empty())
        scene.light_samples = o.number<uint32_t>("--light-samples");
    const std::vector<int> size = o.integers("--size");
    camera_fit(scene.camera, size[0], size[1]);
    const SamplerPointer sampler = sampler_create(o.text("--sampler"), o.number<uint64_t>("--seed"),
                                                  o.number<uint32_t>("--declare"));
    check_samples(o, scene, *sampler);
    ExrHead head = image_head(o, scene);
    Film film = resumes ? resume_film(o, resumed, head) : film_create(size[0], size[1], o.crop());
    const RenderSettings settings = {
        o.number<uint32_t>("--spp"),        o.number<uint32_t>("--first-sample"),
        o.number<unsigned>("--threads"),    o.number<float>("--noise"),
        o.number<float>("--visible-noise"), o.number<uint32_t>("--min-spp"),
        o.number<float>("--exposure")};
    const GeometryPointer geometry = geometry_build(scene);
    std::vector<int> offset = o.integers("--draw-offset");
    offset.resize(2);
    const auto max_depth = o.number<uint32_t>("--max-depth");
    const bool gaussian = o.text("--filter") == "gaussian";
    const Integrator integrator{&scene,    geometry.get(), sampler.get(), max_depth,
                                offset[0], offset[1],      gaussian};
    RenderTotals totals;
    const bool show_progress = !o.flag("--quiet") && isatty(STDERR_FILENO);
    const auto progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    listen_to_interrupts();
    const bool complete = render_frame(integrator, settings, film, totals, progress, interrupted);
    if (show_progress) std::fprintf(stderr, "\n");

    const SampleCounts counts = film_counts(film);
    head.statistics.spp = counts.most;
    head.statistics.end_sample = head.statistics.first_sample + counts.most;
    head.statistics.seconds = totals.seconds;
    head.statistics.ray_count = totals.rays;
    if (resumes) add_part(head.statistics, resumed.statistics);
    write_outputs(o, film, head, scene_extent_text(scene));

    if (!complete)
        say(joined("interrupted; ", o.text("-o"), " has the image so far, ", counts.least, " to ",
                   counts.most, " spp"));
    if (!o.flag("--quiet")) print_summary(o, film, totals);
    if (totals.lost > 0) say(joined(totals.lost, " samples were not finite and count as black"));
    return interrupted;
}

void run_merge(const Options &o) {
    check_outputs(o, o.merge);
    ExrHead head;
    const Film film = merge_images(o.merge, head);
    write_outputs(o, film, head, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (o.flag("--quiet")) return;
    std::printf("%s: %zu images merged, %u to %u spp\n", without_controls(o.text("-o")).c_str(),
                o.merge.size(), counts.least, counts.most);
    print_noise(film);
}

// ---- The process

// If memory runs out inside a library's noexcept function, prints one line and exits with code 1.
void exit_where_it_would_abort() {
    std::set_terminate([] {
        std::fprintf(stderr, "pathtracer: out of memory, or an internal error; --max-memory allows "
                             "more, where there is more\n");
        std::_Exit(1);
    });
}

// Bytes of private memory already reserved; sanitizers reserve terabytes they never touch.
double taken() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int field = 0; field < 6; ++field) file >> pages; // the sixth: data and stack
    return file ? pages * double(sysconf(_SC_PAGESIZE)) : 0;
}

// From here on, allocations beyond --max-memory fail, also in libraries, so a scene that wastes memory ends
// with a one-line error. Works on Linux 4.7 and later; some other systems lack this limit.
void limit_memory(const Options &o) {
    const double bytes = o.number<double>("--max-memory") * 1024 * 1024 * 1024;
    rlimit limit;
    if (!(bytes > 0) || getrlimit(RLIMIT_DATA, &limit) != 0) return;
    limit.rlim_cur =
        std::min({static_cast<rlim_t>(taken() + bytes), limit.rlim_cur, limit.rlim_max});
    setrlimit(RLIMIT_DATA, &limit);
}

template <typename Entry>
void print_entries(const char *what, const std::vector<Entry> &entries) {
    std::printf("%s:\n", what);
    for (const Entry &entry : entries) std::printf("  %-12s %s\n", entry.name, entry.summary);
}

} // namespace

int main(int argc, char **argv) {
    exit_where_it_would_abort();
    try {
        const Options options(argc, argv);
        limit_memory(options);
        if (options.flag("--help")) {
            std::fputs(Options::help().c_str(), stdout);
        } else if (options.flag("--list")) {
            print_entries("scenes", scene_entries());
            print_entries("samplers", sampler_entries());
        } else if (options.flag("--list-cameras")) {
            std::fputs(camera_list(load_scene(options)).c_str(), stdout);
        } else if (options.flag("--list-inputs")) {
            std::fputs(load_scene(options).inputs.text().c_str(), stdout);
        } else if (!options.merge.empty()) {
            run_merge(options);
        } else if (const int signal = run_render(options)) {
            return 128 + signal; // as shells do, so that a script sees that the image is incomplete
        }
        return 0;
    } catch (const std::bad_alloc &) {
        say("out of memory; render parts of the image with --crop, or raise --max-memory");
    } catch (const std::exception &error) {
        say(error.what());
    }
    return 1;
}
