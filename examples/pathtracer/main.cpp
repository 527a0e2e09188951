// SPDX-License-Identifier: Apache-2.0
// The program: rendering and merging, step by step. Everything that can fail early is done before the
// first ray. In an interrupted image, each pixel holds its first samples, some pixels more than others.
// The counts tell which samples are missing, so no other state is needed.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
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

bool is_environment_file(const std::string &name) {
    return !name.empty() && name != "sky" && name != "none";
}

// Throws Error unless both outputs can be written, and are none of the files that are read, under
// any name. Only the image of --resume may be replaced by -o.
void check_outputs(const Options &o, const std::vector<fs::path> &inputs) {
    const fs::path exr = o.text("-o"), png = preview_path(o), resumed = o.text("--resume");
    const auto check = [&](const char *role, const fs::path &output, const fs::path &input) {
        if (!input.empty() && is_same_file(output, input))
            throw Error(role, " would overwrite ", output.string(), ", which is read as ",
                        input.string(), "; give the output another name");
    };
    for (const fs::path &input : inputs) {
        check("-o", exr, input);
        check("the preview of -o", png, input);
    }
    check("the preview of -o", png, resumed);
    if (is_same_file(exr, png))
        throw Error("-o and its preview ", png.string(), " are the same file; give another name");
    check_writable(exr);
    check_writable(png);
}

void write_outputs(const Options &o, const Film &film, ExrHead head) {
    const std::string &exposure = o.text("--exposure");
    const bool automatic =
        exposure == "auto" || (exposure.empty() && is_scene_file(head.settings["scene"]));
    head.statistics.exposure = automatic ? auto_exposure(film) : o.number<float>("--exposure");
    write_files(
        {{o.text("-o"), exr_encode(film, head)},
         {preview_path(o), png_encode_preview(film_image(film), head.statistics.exposure)}});
}

// Prints even with --quiet. Parts of an image are exempt: they may well be empty.
void warn(const Film &film, const std::string &extent) {
    const Crop &c = film.crop;
    if (width(c) < film.full_width || height(c) < film.full_height) return;
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

// Builds or reads the scene. `record` gets every file that is read.
Scene load_scene(const Options &o, InputRecord &record) {
    SceneOptions options;
    if (!o.text("--camera").empty()) options.camera.number = o.number<uint32_t>("--camera");
    if (!o.text("--fov").empty()) options.camera.fov = o.number<double>("--fov");
    options.camera.eye = o.point("--eye");
    options.camera.target = o.point("--target");
    options.allow_outside = o.flag("--allow-outside");
    options.photometric = o.flag("--photometric");
    options.record = &record;
    const std::string &environment = o.text("--env");
    if (is_environment_file(environment)) record.add_file(environment);
    if (!environment.empty())
        options.environment =
            std::make_shared<Environment>(environment_read(environment, o.flag("--clamp")));
    if (is_environment_file(environment)) record.add_file(environment); // it may have changed
    return scene_build(o.text("--scene"), options);
}

void check_samples(const Options &o, const Scene &scene, const Sampler &sampler) {
    const auto end = o.number<uint64_t>("--first-sample") + o.number<uint64_t>("--spp");
    if (end > (uint64_t{1} << 32) / scene.light_samples)
        throw Error("--first-sample and --spp run past the last sample of ", scene.light_samples,
                    " light samples each; take fewer");
    if (sampler.peer && end > PeerSampler::INDEX_LIMIT)
        throw Error("--first-sample and --spp run past sample ", PeerSampler::INDEX_LIMIT,
                    ", the last of '", o.text("--sampler"), "'; take fewer");
}

// What is known of the image before rendering. The camera must be fitted already.
ExrHead image_head(const Options &o, const Scene &scene, const Crop &crop,
                   const InputRecord &record) {
    const std::vector<int> size = o.integers("--size");
    ExrHead head{size[0], size[1], crop, {}, {}};
    for (const std::string &name : Options::settings())
        head.settings[name.substr(2)] = o.text(name);
    std::string &camera = head.settings["camera"];
    if (!scene.cameras.empty())
        camera = "--camera " + std::to_string(o.number<uint32_t>("--camera")) + " ";
    camera += camera_text(scene, scene.camera);
    head.settings["draws"] = std::to_string(BN_DRAW_TABLE_VERSION);
    head.settings["inputs"] = record.text(); // the rest may follow from what is in them
    head.settings["light-samples"] = std::to_string(scene.light_samples);
    const bool adaptive = o.number<double>("--noise") > 0;
    head.settings["noise-exposure"] = adaptive ? shortest(o.number<double>("--exposure")) : "";
    head.statistics.first_sample = o.number<uint64_t>("--first-sample");
    head.statistics.threads = o.number<unsigned>("--threads");
    return head;
}

// ---- Images in parts

bool overlap(const Crop &a, const Crop &b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

// The first line that differs between the settings of two images, such as "seed: '1' and '2'", or of the
// files they are made of; empty if they can be parts of one image.
std::string settings_difference(ExrHead one, ExrHead other) {
    for (ExrHead *head : {&one, &other})
        head->settings["size"] = joined(head->full_width, "x", head->full_height);
    std::map<std::string, std::string> all = one.settings;
    all.insert(other.settings.begin(), other.settings.end());
    for (const auto &[name, unused] : all) {
        const std::string &a = one.settings[name], &b = other.settings[name];
        if (a == b) continue;
        std::istringstream lines_a(a), lines_b(b);
        std::string line_a, line_b;
        while (line_a == line_b && (lines_a || lines_b)) {
            line_a.clear(), line_b.clear();
            std::getline(lines_a, line_a);
            std::getline(lines_b, line_b);
        }
        return joined(name, ": '", printable(line_a), "' and '", printable(line_b), "'");
    }
    return "";
}

// Adds the cost of a part, as if one machine had rendered everything.
void add_part(ImageStatistics &to, const ImageStatistics &part) {
    to.seconds += part.seconds;
    to.ray_count += part.ray_count;
    to.threads = std::max(to.threads, part.threads);
}

// Adds a part's samples to a pixel of the image, which starts at sample `first`.
void add_samples(FilmPixel &to, const FilmPixel &from, int x, int y, uint64_t first, uint64_t begin,
                 const std::string &path) {
    if (from.count == 0) return;
    const uint64_t next = first + to.count;
    if (begin > next)
        throw Error("samples ", next, " to ", begin - 1, " of pixel ", x, ",", y,
                    " are missing before ", path, "; render them with --first-sample ", next,
                    " --spp ", begin - next, ", or --resume the image that was stopped");
    film_merge(to, from);
}

// Merges parts of the same settings and files. Where they overlap they must hold different samples, and
// each pixel's samples must be consecutive. Holds only the result and one part in memory. Throws Error.
Film merge_images(const std::vector<std::string> &paths, ExrHead &merged) {
    std::vector<ExrHead> heads;
    for (const std::string &path : paths) {
        const ExrHead head = exr_read_head(path);
        const std::string difference = settings_difference(head, heads.empty() ? head : heads[0]);
        if (!difference.empty())
            throw Error(path, " and ", paths[0], " are not parts of one image: they differ in ",
                        difference);
        for (size_t i = 0; i < heads.size(); ++i) {
            const ImageStatistics &a = heads[i].statistics, &b = head.statistics;
            if (a.first_sample < b.end_sample && b.first_sample < a.end_sample &&
                overlap(heads[i].crop, head.crop))
                throw Error(path, " and ", paths[i],
                            " contain the same samples of the same pixels");
        }
        heads.push_back(head);
    }
    merged = heads[0];
    ImageStatistics &all = merged.statistics;
    Crop &crop = merged.crop;
    std::multimap<uint64_t, size_t> order; // of samples, so that each pixel fills up without gaps
    for (size_t i = 0; i < heads.size(); ++i) {
        const Crop &c = heads[i].crop;
        const ImageStatistics &part = heads[i].statistics;
        order.emplace(part.first_sample, i);
        if (i == 0) continue;
        crop = {std::min(crop.x0, c.x0), std::min(crop.y0, c.y0), std::max(crop.x1, c.x1),
                std::max(crop.y1, c.y1)};
        all.first_sample = std::min(all.first_sample, part.first_sample);
        all.end_sample = std::max(all.end_sample, part.end_sample);
        add_part(all, part);
    }
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("the parts span more than ", MAX_PIXELS, " pixels; merge fewer of them");
    Film film = film_create(merged.full_width, merged.full_height, crop);
    for (const auto &[first, i] : order) {
        const Film part = exr_read_film(paths[i]);
        for (int y = part.crop.y0; y < part.crop.y1; ++y)
            for (int x = part.crop.x0; x < part.crop.x1; ++x)
                add_samples(film_pixel(film, x, y), film_pixel(part, x, y), x, y, all.first_sample,
                            first, paths[i]);
    }
    all.spp = film_counts(film).most;
    return film;
}

// An image may come from anybody: it names files below its own folder only, or the user names them.
void check_inside(const Options &o, const std::string &name) {
    const std::string &file = o.text(name);
    const bool is_file = name == "--scene" ? is_scene_file(file) : is_environment_file(file);
    if (!is_file || o.given(name)) return;
    try {
        SceneFolder(o.text("--resume"), o.flag("--allow-outside"))
            .resolve(fs::absolute(file).string());
    } catch (const std::exception &) {
        throw Error(o.text("--resume"), " names the file ", printable(file),
                    ", which is outside the image's folder; name it with ", name,
                    ", or use --allow-outside");
    }
}

// Takes from the image to continue all settings that are not on the command line. Throws Error.
ExrHead resume_settings(Options &o) {
    const std::string &resumed = o.text("--resume");
    ExrHead head = exr_read_head(resumed);
    const auto take = [&](const std::string &name, const std::string &value) {
        try {
            if (!o.given(name) && !value.empty()) o.set(name, value);
        } catch (const Error &error) {
            throw Error(resumed, " cannot be continued: ", error.what());
        }
    };
    const Crop &c = head.crop;
    const ImageStatistics &s = head.statistics;
    for (const std::string &name : Options::settings()) take(name, head.settings[name.substr(2)]);
    take("--size", joined(head.full_width, "x", head.full_height));
    take("--crop", joined(c.x0, ",", c.y0, ",", c.x1, ",", c.y1));
    take("--first-sample", std::to_string(s.first_sample));
    take("--spp", std::to_string(std::max(s.spp, 1u)));
    take("--exposure", head.settings["noise-exposure"]);
    const std::string camera[] = {"--camera", "--eye", "--target", "--fov"};
    const auto given = [&](const std::string &name) { return o.given(name); };
    std::istringstream words(head.settings["camera"]);
    for (std::string name, value; words >> name >> value;)
        if (std::none_of(std::begin(camera), std::end(camera), given) &&
            std::count(std::begin(camera), std::end(camera), name) > 0)
            take(name, value);
    for (const char *name : {"--scene", "--env"}) check_inside(o, name);
    o.check();
    return head;
}

// Reads the samples. Throws Error, naming the difference, unless they can be continued as `wanted`.
Film resume_film(const Options &o, const ExrHead &image, const ExrHead &wanted) {
    std::string difference = settings_difference(image, wanted);
    const Crop &had = image.crop, &now = wanted.crop;
    if (difference.empty() && image.statistics.first_sample != wanted.statistics.first_sample)
        difference = "first sample";
    if (difference.empty() &&
        (had.x0 != now.x0 || had.y0 != now.y0 || had.x1 != now.x1 || had.y1 != now.y1))
        difference = "crop";
    if (!difference.empty())
        throw Error(o.text("--resume"), " is not an earlier state of this image: they differ in ",
                    difference, "; options that you leave out are taken from it");
    Film film = exr_read_film(o.text("--resume"));
    const SampleCounts counts = film_counts(film);
    const auto spp = o.number<uint32_t>("--spp");
    if (counts.most > spp || counts.least >= spp)
        throw Error(o.text("--resume"), " has ", counts.least, " to ", counts.most,
                    " samples in each pixel already; give a larger --spp");
    return film;
}

// ---- Rendering

void print_progress(double fraction, const RenderTotals &totals) {
    const double rays = double(totals.counters.rays);
    std::fprintf(stderr, "\r%5.1f %%  %6.1f M rays/s", 100 * fraction,
                 1e-6 * rays / std::max(totals.seconds, 1e-9));
    if (fraction > 0)
        std::fprintf(stderr, "  %.0f s left   ",
                     std::ceil(totals.seconds * (1 - fraction) / fraction));
    std::fflush(stderr);
}

// What a run without --quiet prints about its image.
void print_summary(const Options &o, const Film &film, const RenderTotals &totals, double samples) {
    const SampleCounts counts = film_counts(film);
    std::string spp = std::to_string(counts.least);
    if (o.number<double>("--noise") > 0) {
        const double pixels = double(film.pixels.size());
        spp += joined(" to ", counts.most, " spp, ", film_samples(film) / pixels, " on average");
    } else {
        spp += " spp";
    }
    const double rays = double(totals.counters.rays);
    std::printf("%s: %s, %s, %s, %.2f s, %.0f rays, %.2f M rays/s, %.2f %% cut off at depth %s\n",
                without_controls(o.text("-o")).c_str(), without_controls(o.text("--scene")).c_str(),
                o.text("--sampler").c_str(), spp.c_str(), totals.seconds, rays,
                1e-6 * rays / totals.seconds,
                100 * totals.counters.cut_off / std::max(samples, 1.0),
                o.text("--max-depth").c_str());
}

// Renders an image and writes it. Returns the signal that interrupted it, or 0.
int run_render(Options o) {
    const bool resumes = !o.text("--resume").empty();
    const ExrHead resumed = resumes ? resume_settings(o) : ExrHead{};
    InputRecord record;
    Scene scene = load_scene(o, record);
    if (!o.flag("--quiet"))
        for (const std::string &note : scene.notes) say(note);
    std::vector<fs::path> inputs;
    for (const auto &file : record.files) inputs.push_back(file.first);
    check_outputs(o, inputs);
    if (!o.text("--light-samples").empty())
        scene.light_samples = o.number<uint32_t>("--light-samples");
    const std::vector<int> size = o.integers("--size"), c = o.integers("--crop");
    const Crop crop = c.empty() ? Crop{0, 0, size[0], size[1]} : Crop{c[0], c[1], c[2], c[3]};
    camera_fit(scene.camera, size[0], size[1]);
    const SamplerPointer sampler = sampler_create(o.text("--sampler"), o.number<uint64_t>("--seed"),
                                                  o.number<uint32_t>("--declare"));
    check_samples(o, scene, *sampler);
    ExrHead head = image_head(o, scene, crop, record);
    Film film = resumes ? resume_film(o, resumed, head) : film_create(size[0], size[1], crop);
    const RenderSettings settings = {o.number<uint32_t>("--spp"),
                                     o.number<uint32_t>("--first-sample"),
                                     o.number<unsigned>("--threads"),
                                     {o.number<float>("--noise"), o.number<uint32_t>("--min-spp"),
                                      o.number<float>("--exposure")}};
    const bool adaptive = settings.noise.level > 0;
    if (adaptive) film = film_with_crop(film, whole_blocks(crop, size[0], size[1]));
    const double samples_before = film_samples(film);

    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator{&scene, geometry.get(), sampler.get(),
                                o.number<uint32_t>("--max-depth")};
    RenderTotals totals;
    const bool show_progress = !o.flag("--quiet") && isatty(STDERR_FILENO);
    const auto progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    listen_to_interrupts();
    const bool complete = render_frame(integrator, settings, film, totals, progress, interrupted);
    if (show_progress) std::fprintf(stderr, "\n");

    const double samples = film_samples(film) - samples_before; // also of blocks beyond the crop
    if (adaptive) film = film_with_crop(film, crop);
    const SampleCounts counts = film_counts(film);
    head.statistics.spp = counts.most;
    head.statistics.end_sample = head.statistics.first_sample + counts.most;
    head.statistics.seconds = totals.seconds;
    head.statistics.ray_count = totals.counters.rays;
    if (resumes) add_part(head.statistics, resumed.statistics);
    write_outputs(o, film, head);

    if (!complete)
        say(joined("interrupted; ", o.text("-o"), " has the image so far, ", counts.least, " to ",
                   counts.most, " spp"));
    if (!o.flag("--quiet")) print_summary(o, film, totals, samples);
    warn(film, scene_extent_text(scene));
    if (totals.counters.lost > 0)
        say(joined(totals.counters.lost, " samples were not finite and count as black"));
    return interrupted;
}

// Merges an image from parts and writes it.
void run_merge(const Options &o) {
    check_outputs(o, {o.merge.begin(), o.merge.end()});
    ExrHead head;
    const Film film = merge_images(o.merge, head);
    write_outputs(o, film, head);
    warn(film, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (!o.flag("--quiet"))
        std::printf("%s: %zu images merged, %u to %u spp\n", without_controls(o.text("-o")).c_str(),
                    o.merge.size(), counts.least, counts.most);
}

// ---- The process

// Otherwise an image could get the number of a closed stream, and then its text too.
void occupy_closed_streams() {
    for (int descriptor = 0; descriptor < 3; ++descriptor)
        if (fcntl(descriptor, F_GETFD) < 0) open("/dev/null", O_RDONLY);
}

// Bytes of private memory already taken, which under sanitizers is terabytes that are never touched.
double taken() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int field = 0; field < 6; ++field) file >> pages; // the sixth: data and stack
    return file ? pages * double(sysconf(_SC_PAGESIZE)) : 0;
}

// From here on, allocations beyond --max-memory fail, those of libraries too: a scene made to waste
// memory ends in one line. Works on Linux from 4.7 on; elsewhere some systems do without.
void limit_memory(const Options &o) {
    const double half = 0.5 * double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    const double bytes =
        o.given("--max-memory") ? o.number<double>("--max-memory") * 1024 * 1024 * 1024 : half;
    rlimit limit;
    if (!(bytes > 0) || getrlimit(RLIMIT_DATA, &limit) != 0) return;
    limit.rlim_cur =
        std::min({static_cast<rlim_t>(taken() + bytes), limit.rlim_cur, limit.rlim_max});
    setrlimit(RLIMIT_DATA, &limit);
}

// The exit status of a run that went well, if all that it printed has arrived.
int status_of_output() {
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return 0;
    say(std::string("cannot write to standard output: ") + std::strerror(errno));
    return 1;
}

template <typename Entry>
void print_entries(const char *what, const std::vector<Entry> &entries) {
    std::printf("%s:\n", what);
    for (const Entry &entry : entries) std::printf("  %-12s %s\n", entry.name, entry.summary);
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
        const Options options(argc, argv);
        limit_memory(options);
        InputRecord record;
        if (options.flag("--help")) {
            std::fputs(Options::help().c_str(), stdout);
        } else if (options.flag("--list")) {
            print_entries("scenes", scene_entries());
            print_entries("samplers", sampler_entries());
        } else if (options.flag("--list-cameras")) {
            std::fputs(camera_list(load_scene(options, record)).c_str(), stdout);
        } else if (options.flag("--list-inputs")) {
            load_scene(options, record);
            std::fputs(record.text().c_str(), stdout);
        } else if (!options.merge.empty()) {
            run_merge(options);
        } else if (const int signal = run_render(options)) {
            return 128 +
                   signal; // the shell's convention: a script sees that the image is incomplete
        }
        return status_of_output();
    } catch (const std::bad_alloc &) {
        say("out of memory; render the image in parts with --crop, or allow more with "
            "--max-memory");
    } catch (const std::exception &error) {
        say(error.what());
    }
    return 1;
}
