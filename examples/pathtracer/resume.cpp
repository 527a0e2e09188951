// SPDX-License-Identifier: Apache-2.0
// Continuing a picture that was stopped. Each pixel holds its first samples, some pixels more than
// others. The counts alone say which samples are missing, so no other state is kept.
#include "resume.h"

#include <filesystem>

#include "error.h"
#include "input_file.h"
#include "merge.h"
#include "outputs.h"

namespace {

// A picture may come from anybody: the files it names are read below its own folder only, unless
// the user names them too.
void check_inside(const Options &options, const NamedFile &file) {
    if (options.given.count(file.role) > 0) return;
    const auto refuse = [&](const std::string &why) {
        throw Error(options.resume + " names the file " + printable(file.path.string()) +
                    ", which " + why + "; name it with " + file.role + ", or use --allow-outside");
    };
    try {
        SceneFolder(options.resume, options.allow_outside)
            .resolve(std::filesystem::absolute(file.path).string());
    } catch (const Error &) {
        refuse("is outside the picture's folder");
    } catch (const std::filesystem::filesystem_error &) {
        refuse("is no path");
    }
}

// Whether a picture that was rendered with `before` is an earlier state of one with `now`: no block
// may have more samples than it would get.
bool noise_continues(const NoiseSettings &before, const NoiseSettings &now, uint32_t spp) {
    if (!(now.level > 0)) return true;
    if (!(before.level > 0)) return spp <= next_look(now, 0);
    return now.level <= before.level && now.min_spp >= before.min_spp &&
           !(now.exposure < before.exposure || now.exposure > before.exposure);
}

} // namespace

ExrHead resume_settings(Options &options) {
    const ExrHead head = exr_read_head(options.resume);
    const ExrAttributes &a = head.attributes;
    const auto unless_given = [&](const char *name, auto &option, const auto &value) {
        if (options.given.count(name) == 0) option = value;
    };
    unless_given("--size", options.width, head.full_width);
    unless_given("--size", options.height, head.full_height);
    if (options.width != head.full_width || options.height != head.full_height ||
        head.crop.x0 < 0 || head.crop.y0 < 0)
        throw Error(options.resume + " is of a picture of " + std::to_string(head.full_width) +
                    "x" + std::to_string(head.full_height) +
                    " pixels; leave out --size, or give that size");
    unless_given("--crop", options.crop, head.crop);
    unless_given("--scene", options.scene, a.scene);
    const auto given = [&](const char *name) { return options.given.count(name) > 0; };
    if (!given("--camera") && !given("--eye") && !given("--target") && !given("--fov"))
        options.camera = camera_parse(a.camera);
    unless_given("--env", options.environment, a.environment);
    unless_given("--sampler", options.sampler.name, a.sampler);
    unless_given("--mask", options.sampler.mask, a.mask);
    unless_given("--declare", options.sampler.declared_spp, static_cast<uint32_t>(a.declared_spp));
    unless_given("--seed", options.sampler.seed, a.seed);
    unless_given("--first-sample", options.first_sample, static_cast<uint32_t>(a.first_sample));
    unless_given("--max-depth", options.max_depth, a.max_depth);
    if (!given("--lights")) unless_given("--light-samples", options.light_samples, a.light_samples);
    unless_given("--noise", options.noise, a.noise.level);
    unless_given("--min-spp", options.min_spp, a.noise.min_spp);
    if (a.noise.level > 0 && options.noise > 0)
        unless_given("--exposure", options.exposure, a.noise.exposure);
    options.single_scatter = options.single_scatter || a.single_scatter;
    options.photometric = options.photometric || a.photometric;
    if (!(options.time_limit > 0)) unless_given("--spp", options.spp, std::max(a.spp, 1u));
    for (const NamedFile &file : setting_files(options)) check_inside(options, file);
    check_options(options);
    return head;
}

Film resume_film(const Options &options, const ExrHead &picture, const ExrHead &wanted) {
    const ExrAttributes &a = picture.attributes, &b = wanted.attributes;
    ExrHead earlier = picture;
    if (!(b.noise.level > 0) || noise_continues(a.noise, b.noise, a.spp))
        earlier.attributes.noise = b.noise;
    std::string difference = settings_difference(earlier, wanted, options.allow_changed);
    const Crop &had = picture.crop, &now = wanted.crop;
    if (difference.empty() && a.first_sample != b.first_sample) difference = "first sample";
    if (difference.empty() &&
        (had.x0 != now.x0 || had.y0 != now.y0 || had.x1 != now.x1 || had.y1 != now.y1))
        difference = "crop";
    if (!difference.empty())
        throw Error(options.resume + " is not an earlier state of this picture: they differ in " +
                    difference + "; options that you leave out are taken from it");
    Film film = exr_read_film(options.resume);
    const SampleCounts counts = film_counts(film);
    if (counts.most > options.spp || counts.least >= options.spp)
        throw Error(options.resume + " has " + std::to_string(counts.least) + " to " +
                    std::to_string(counts.most) +
                    " samples in each pixel already; give a larger --spp");
    return film;
}
