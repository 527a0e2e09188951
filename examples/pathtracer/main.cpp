// SPDX-License-Identifier: Apache-2.0
// The program: rendering and merging, step by step. Everything that can fail early comes before the
// first ray. Each pixel of a picture that was stopped holds its first samples, some pixels more than
// others: the counts alone say which samples are missing, so no other state is kept.
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

#include "exr.h"
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

// A file, and the option that names it.
struct NamedFile {
    std::string role;
    fs::path path;
};

// The files that options name, but the scene's own.
std::vector<NamedFile> setting_files(const Options &o) {
    std::vector<NamedFile> files;
    const auto add = [&](const char *role, const std::string &name, bool is_file) {
        if (is_file && !name.empty()) files.push_back({role, name});
    };
    const std::string &mask = o.sampler.mask;
    add("--scene", o.scene, is_scene_file(o.scene));
    add("--env", o.environment, o.environment != "sky" && o.environment != "none");
    add("--mask", mask, mask != "builtin" && mask != "neural");
    return files;
}

fs::path preview_path(const Options &o) {
    return fs::path(o.output).replace_extension(".png");
}

// Throws Error if an output is also the other output, the reference, or one of `inputs`, under any
// name. Only the --resume picture may be replaced by -o.
void check_file_names(const Options &o, std::vector<NamedFile> inputs) {
    inputs.push_back({"--resume", o.resume});
    inputs.push_back({"--reference", o.reference});
    const fs::path exr = o.output, png = preview_path(o);
    const auto as = [](const fs::path &one, const fs::path &other) {
        return one == other ? "" : " (as " + other.string() + ")";
    };
    if (is_same_file(exr, png))
        throw Error("-o and the preview of -o would both write ", exr.string(), as(exr, png),
                    "; give another name");
    for (const NamedFile &output : {NamedFile{"-o", exr}, NamedFile{"the preview of -o", png}})
        for (const NamedFile &input : inputs)
            if (!input.path.empty() && !(output.role == "-o" && input.role == "--resume") &&
                is_same_file(output.path, input.path))
                throw Error(output.role, " would overwrite ", output.path.string(), ", which ",
                            input.role, " reads", as(output.path, input.path),
                            "; give the output another name");
}

// Before the first ray, so that a wrong name costs nothing.
void check_outputs(const Options &o) {
    check_writable(o.output);
    check_writable(preview_path(o));
}

void write_outputs(const Options &o, const Film &film, ExrHead head) {
    const bool automatic = o.auto_exposure || is_scene_file(head.settings["scene"]);
    float &exposure = head.statistics.exposure;
    exposure = o.exposure ? *o.exposure : automatic ? auto_exposure(film) : 0;
    write_files({{o.output, exr_encode(film, head)},
                 {preview_path(o), png_encode_preview(film_image(film), exposure)}});
}

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
ExrHead picture_head(Options &o, const Scene &scene, const Crop &crop, const InputRecord &record) {
    ExrHead head{o.width, o.height, crop, {}, {}};
    if (!(o.noise.level > 0)) o.noise = {};
    for (const OptionRow &row : option_rows(o))
        if (row.attribute) head.settings[row.attribute] = row.text();
    std::string &camera = head.settings["camera"];
    if (!scene.cameras.empty())
        camera = "--camera " + std::to_string(o.camera.number.value_or(0)) + " ";
    camera += camera_text(scene, scene.camera);
    head.settings["draws"] = std::to_string(BN_DRAW_TABLE_VERSION);
    head.settings["inputs"] = record.text(); // the rest may follow from what is in them
    head.settings["lightSamples"] = std::to_string(scene.light_samples);
    o.noise.exposure = o.noise.level > 0 ? o.exposure.value_or(0) : 0;
    std::ostringstream exposure;
    exposure << o.noise.exposure;
    head.settings["noiseExposure"] = exposure.str();
    head.statistics.first_sample = o.first_sample;
    head.statistics.threads = o.threads;
    return head;
}

// ---- Pictures in parts

bool overlap(const Crop &a, const Crop &b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

// The first difference between the settings of two pictures, or between the files they are made of
// unless --allow-changed, such as "seed '1' and '2'"; empty if they can be parts of one picture.
// Regions and sample ranges are not compared.
std::string settings_difference(ExrHead one, ExrHead other, bool allow_changed) {
    for (ExrHead *head : {&one, &other})
        head->settings["size"] =
            std::to_string(head->full_width) + "x" + std::to_string(head->full_height);
    std::map<std::string, std::string> all = one.settings;
    all.insert(other.settings.begin(), other.settings.end());
    for (const auto &[name, unused] : all) {
        const std::string &a = one.settings[name], &b = other.settings[name];
        if (a == b || (name == "inputs" && allow_changed)) continue;
        if (name != "inputs") return name + " '" + a + "' and '" + b + "'";
        return inputs_difference(a, b) + " (--allow-changed mixes them all the same)";
    }
    return "";
}

// Adds the cost of a part to a picture, which does not list its files any more if the part is made of
// other ones.
void add_part(ExrHead &to, const ExrHead &part) {
    PictureStatistics &a = to.statistics;
    const PictureStatistics &b = part.statistics;
    // Weighted by time, as if one machine had rendered everything.
    const double seconds = a.seconds + b.seconds;
    if (seconds > 0)
        a.sampling_share = (a.sampling_share * a.seconds + b.sampling_share * b.seconds) / seconds;
    a.seconds = seconds;
    a.ray_count += b.ray_count;
    a.threads = std::max(a.threads, b.threads);
    std::string &inputs = to.settings["inputs"];
    if (const auto other = part.settings.find("inputs");
        other == part.settings.end() || other->second != inputs)
        inputs.clear();
}

// Adds a part's samples to a pixel of the picture, which starts at sample `first`.
void add_samples(FilmPixel &to, const FilmPixel &from, int x, int y, uint64_t first, uint64_t begin,
                 const std::string &path) {
    if (from.count == 0) return;
    const uint64_t next = first + to.count;
    if (begin > next)
        throw Error("samples ", next, " to ", begin - 1, " of pixel ", x, ",", y,
                    " are missing before ", path, "; render them with --first-sample ", next,
                    " --spp ", begin - next, ", or --resume the picture that was stopped");
    film_merge(to, from);
}

// Reads and merges parts that this program wrote with the same settings, and of the same files
// unless --allow-changed. Where parts overlap they must hold different samples, and each pixel's
// samples must be consecutive, starting at the first sample of all parts. Pixels outside all parts
// are black and have no samples. Holds only the result and one part in memory. Throws Error.
Film merge_pictures(const Options &o, ExrHead &merged) {
    std::vector<ExrHead> heads;
    for (const std::string &path : o.merge) {
        const ExrHead head = exr_read_head(path);
        if (!heads.empty()) {
            const std::string difference = settings_difference(head, heads[0], o.allow_changed);
            if (!difference.empty())
                throw Error(path, " and ", o.merge[0],
                            " are not parts of one picture: they differ in ", difference);
        }
        for (size_t i = 0; i < heads.size(); ++i) {
            const PictureStatistics &a = heads[i].statistics, &b = head.statistics;
            if (a.first_sample < b.end_sample && b.first_sample < a.end_sample &&
                overlap(heads[i].crop, head.crop))
                throw Error(path, " and ", o.merge[i],
                            " contain the same samples of the same pixels");
        }
        heads.push_back(head);
    }
    merged = heads[0];
    PictureStatistics &all = merged.statistics;
    Crop &crop = merged.crop;
    std::multimap<uint64_t, size_t> order; // of samples, so that each pixel fills up without gaps
    for (size_t i = 0; i < heads.size(); ++i) {
        const Crop &c = heads[i].crop;
        order.emplace(heads[i].statistics.first_sample, i);
        if (i == 0) continue;
        crop = {std::min(crop.x0, c.x0), std::min(crop.y0, c.y0), std::max(crop.x1, c.x1),
                std::max(crop.y1, c.y1)};
        all.first_sample = std::min(all.first_sample, heads[i].statistics.first_sample);
        all.end_sample = std::max(all.end_sample, heads[i].statistics.end_sample);
        add_part(merged, heads[i]);
    }
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("the parts span more than ", MAX_PIXELS, " pixels; merge fewer of them");
    Film film = film_create(merged.full_width, merged.full_height, crop);
    for (const auto &[first, i] : order) {
        const Film part = exr_read_film(o.merge[i]);
        for (int y = part.crop.y0; y < part.crop.y1; ++y)
            for (int x = part.crop.x0; x < part.crop.x1; ++x)
                add_samples(film_pixel(film, x, y), film_pixel(part, x, y), x, y, all.first_sample,
                            first, o.merge[i]);
    }
    all.spp = film_counts(film).most;
    return film;
}

// A picture may come from anybody: the files it names are read below its own folder only, unless
// the user names them too.
void check_inside(const Options &o, const NamedFile &file) {
    if (o.given.count(file.role) > 0) return;
    const auto refuse = [&](const std::string &why) {
        throw Error(o.resume, " names the file ", printable(file.path.string()), ", which ", why,
                    "; name it with ", file.role, ", or use --allow-outside");
    };
    try {
        SceneFolder(o.resume, o.allow_outside).resolve(fs::absolute(file.path).string());
    } catch (const Error &) {
        refuse("is outside the picture's folder");
    } catch (const fs::filesystem_error &) {
        refuse("is no path");
    }
}

// Reads the header of the picture to continue and takes from it all settings that are not on the
// command line. Without --spp, rendering only evens out the sample counts of its pixels.
// Throws Error.
ExrHead resume_settings(Options &o) {
    ExrHead head = exr_read_head(o.resume);
    const auto given = [&](const char *name) { return o.given.count(name) > 0; };
    const PictureStatistics &s = head.statistics;
    if (!given("--size")) o.width = head.full_width, o.height = head.full_height;
    if (o.width != head.full_width || o.height != head.full_height || head.crop.x0 < 0 ||
        head.crop.y0 < 0)
        throw Error(o.resume, " is of a picture of ", head.full_width, "x", head.full_height,
                    " pixels; leave out --size, or give that size");
    if (!given("--crop")) o.crop = head.crop;
    if (!given("--camera") && !given("--eye") && !given("--target") && !given("--fov"))
        o.camera = camera_parse(head.settings["camera"]);
    const auto take = [&](const OptionRow &row, const std::string &attribute) {
        const auto found = head.settings.find(attribute);
        try {
            if (found == head.settings.end()) throw Error("it has no ", attribute);
            option_read(row, found->second);
        } catch (const Error &error) {
            throw Error(o.resume, " cannot be continued: ", error.what());
        }
    };
    for (const OptionRow &row : option_rows(o)) {
        const std::string &name = row.name;
        if (given(name.c_str())) continue;
        if (row.attribute) take(row, row.attribute);
        if (name == "--light-samples" && !given("--lights")) {
            if (head.settings["lightSamples"] == "0")
                o.light_samples = 0;
            else
                take(row, "lightSamples");
        }
    }
    if (!given("--first-sample")) o.first_sample = static_cast<uint32_t>(s.first_sample);
    if (!given("--exposure") && o.noise.level > 0 && head.settings["noise"] != "0")
        for (const OptionRow &row : option_rows(o))
            if (row.name == "--exposure") take(row, "noiseExposure");
    if (!given("--spp")) o.spp = std::max(s.spp, 1u);
    for (const NamedFile &file : setting_files(o)) check_inside(o, file);
    check_options(o);
    return head;
}

// Whether a picture of `spp` samples that was rendered with settings `before` is an earlier state of
// one with `now`: no block may have more samples than it would get.
bool noise_continues(const ExrHead &before, const Options &now, uint32_t spp) {
    const auto number = [&](const char *name) {
        const auto found = before.settings.find(name);
        return found == before.settings.end() ? 0 : std::strtof(found->second.c_str(), nullptr);
    };
    if (!(now.noise.level > 0)) return true;
    if (!(number("noise") > 0)) return spp <= next_look(now.noise, 0);
    const float exposure = now.exposure.value_or(0);
    return now.noise.level <= number("noise") &&
           static_cast<float>(now.noise.min_spp) >= number("minSpp") &&
           !(exposure < number("noiseExposure") || exposure > number("noiseExposure"));
}

// Reads the samples of the picture. Throws Error, naming the difference, unless it can be continued
// as `wanted`, or if it has --spp samples in each pixel already.
Film resume_film(const Options &o, ExrHead picture, const ExrHead &wanted) {
    if (noise_continues(picture, o, picture.statistics.spp))
        for (const char *name : {"noise", "minSpp", "noiseExposure"})
            picture.settings[name] = wanted.settings.at(name);
    std::string difference = settings_difference(picture, wanted, o.allow_changed);
    const Crop &had = picture.crop, &now = wanted.crop;
    if (difference.empty() && picture.statistics.first_sample != wanted.statistics.first_sample)
        difference = "first sample";
    if (difference.empty() &&
        (had.x0 != now.x0 || had.y0 != now.y0 || had.x1 != now.x1 || had.y1 != now.y1))
        difference = "crop";
    if (!difference.empty())
        throw Error(o.resume, " is not an earlier state of this picture: they differ in ",
                    difference, "; options that you leave out are taken from it");
    Film film = exr_read_film(o.resume);
    const SampleCounts counts = film_counts(film);
    if (counts.most > o.spp || counts.least >= o.spp)
        throw Error(o.resume, " has ", counts.least, " to ", counts.most,
                    " samples in each pixel already; give a larger --spp");
    return film;
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
void print_summary(const Options &o, const PictureStatistics &a, const RenderTotals &totals,
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
    std::vector<NamedFile> read;
    for (const auto &file : record.files) read.push_back({"--scene", file.first});
    check_file_names(o, read);
    const SamplerPointer sampler = sampler_create(o.sampler);
    record_others(o, record);
    check_samples(o, scene, *sampler);
    const Crop crop = o.crop.value_or(Crop{0, 0, o.width, o.height});
    const std::optional<Image> reference = load_reference(o.reference, o.width, o.height, crop);
    ExrHead head = picture_head(o, scene, crop, record);
    check_outputs(o);
    Film film = resumed ? resume_film(o, *resumed, head) : film_create(o.width, o.height, crop);
    if (o.noise.level > 0) film = film_with_crop(film, whole_blocks(crop, o.width, o.height));
    const double samples_before = film_samples(film);

    const GeometryPointer geometry = geometry_build(scene);
    const Integrator integrator{&scene, geometry.get(), sampler.get(), o.max_depth};
    const RenderSettings settings = {o.spp, o.first_sample, o.threads, o.noise};
    RenderTotals totals;
    const bool show_progress = !o.quiet && isatty(STDERR_FILENO);
    const auto progress = [&](double fraction, const RenderTotals &so_far) {
        if (show_progress) print_progress(fraction, so_far);
    };
    listen_to_interrupts();
    const bool complete = render_frame(integrator, settings, film, totals, progress, interrupted);
    if (complete) progress(1, totals);
    if (show_progress) std::fprintf(stderr, "\n");

    PictureStatistics &statistics = head.statistics;
    statistics.sampling_share = sampling_share(integrator, settings, film, totals);
    const double samples = film_samples(film) - samples_before; // also of blocks beyond the crop
    if (o.noise.level > 0) film = film_with_crop(film, crop);
    const SampleCounts counts = film_counts(film);
    statistics.spp = counts.most;
    statistics.end_sample = uint64_t{o.first_sample} + counts.most;
    statistics.seconds = totals.seconds;
    statistics.ray_count = totals.counters.rays;
    if (resumed) add_part(head, *resumed);
    write_outputs(o, film, head);

    if (!complete)
        say("interrupted; " + o.output + " has the picture so far, " +
            std::to_string(counts.least) + " to " + std::to_string(counts.most) + " spp");
    if (!o.quiet)
        print_summary(o, statistics, totals, counts,
                      film_samples(film) / static_cast<double>(film.pixels.size()), samples);
    warn(film, scene_extent_text(scene));
    if (totals.counters.lost > 0)
        say(std::to_string(totals.counters.lost) + " samples were not finite and count as black");
    if (reference) print_error(film_image(film), *reference);
    return interrupted;
}

// Merges a picture from parts and writes it.
void run_merge(const Options &o) {
    std::vector<NamedFile> parts;
    for (const std::string &part : o.merge) parts.push_back({"--merge", part});
    check_file_names(o, parts);
    ExrHead head;
    const Film film = merge_pictures(o, head);
    const std::optional<Image> reference =
        load_reference(o.reference, film.full_width, film.full_height, film.crop);
    check_outputs(o);
    write_outputs(o, film, head);
    warn(film, "lies elsewhere");
    const SampleCounts counts = film_counts(film);
    if (!o.quiet)
        std::printf("%s: %zu pictures merged, %u to %u spp\n", without_controls(o.output).c_str(),
                    o.merge.size(), counts.least, counts.most);
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
            std::fputs(options_help().c_str(), stdout);
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
