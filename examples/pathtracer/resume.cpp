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
void check_inside(const Options &options, const std::string &option,
                  const std::filesystem::path &file) {
    if (options.given.count(option) > 0) return;
    const auto refuse = [&](const std::string &why) {
        throw Error(options.resume + " names the file " + printable(file.string()) + ", which " +
                    why + "; name it with " + option + ", or use --allow-outside");
    };
    try {
        SceneFolder(options.resume, options.allow_outside)
            .resolve(std::filesystem::absolute(file).string());
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
    if (head.crop.x0 < 0 || head.crop.y0 < 0)
        throw Error(options.resume + " has pixels outside its picture");
    const auto unless_given = [&](const char *name, auto &option, const auto &value) {
        if (options.given.count(name) == 0) option = value;
    };
    if (options.given.count("--size") == 0) {
        options.width = head.full_width;
        options.height = head.full_height;
    } else if (options.width != head.full_width || options.height != head.full_height) {
        // Before the file's crop meets the other size.
        throw Error(options.resume + " is of a picture of " + std::to_string(head.full_width) +
                    "x" + std::to_string(head.full_height) +
                    " pixels; leave out --size, or give that size");
    }
    unless_given("--crop", options.crop, std::optional<Crop>(head.crop));
    unless_given("--scene", options.scene, a.scene);
    bool camera_given = false;
    for (const char *name : {"--camera", "--eye", "--target", "--fov"})
        camera_given = camera_given || options.given.count(name) > 0;
    if (!camera_given) options.camera.listed = a.camera;
    unless_given("--env", options.environment, a.environment);
    unless_given("--sampler", options.sampler.name, a.sampler);
    unless_given("--mask", options.sampler.mask, a.mask);
    unless_given("--declare", options.sampler.declared_spp, a.declared_spp);
    unless_given("--seed", options.sampler.seed, a.seed);
    unless_given("--first-sample", options.first_sample, a.first_sample);
    unless_given("--max-depth", options.max_depth, a.max_depth);
    if (options.given.count("--lights") == 0)
        unless_given("--light-samples", options.light_samples,
                     std::optional<uint32_t>(a.light_samples));
    unless_given("--noise", options.noise, a.noise.level);
    unless_given("--min-spp", options.min_spp, a.noise.min_spp);
    if (a.noise.level > 0 && options.noise > 0)
        unless_given("--exposure", options.exposure, std::optional<float>(a.noise.exposure));
    options.single_scatter = options.single_scatter || a.single_scatter;
    options.photometric = options.photometric || a.photometric;
    if (!(options.time_limit > 0)) unless_given("--spp", options.spp, std::max(a.spp, 1u));
    for (const NamedFile &file : setting_files(options))
        check_inside(options, file.role, file.path);
    return head;
}

void resume_check(const std::string &path, const ExrHead &picture, const ExrHead &wanted,
                  bool allow_changed) {
    ExrHead earlier = picture;
    if (noise_continues(picture.attributes.noise, wanted.attributes.noise, picture.attributes.spp))
        earlier.attributes.noise = wanted.attributes.noise;
    std::string difference = settings_difference(earlier, wanted, allow_changed);
    const uint32_t first = picture.attributes.first_sample;
    const Crop &a = picture.crop, &b = wanted.crop;
    if (difference.empty() && first != wanted.attributes.first_sample)
        difference = "first sample '" + std::to_string(first) + "' and '" +
                     std::to_string(wanted.attributes.first_sample) + "'";
    if (difference.empty() && (a.x0 != b.x0 || a.y0 != b.y0 || a.x1 != b.x1 || a.y1 != b.y1))
        difference = "crop";
    if (!difference.empty())
        throw Error(path + " is not an earlier state of this picture: they differ in " +
                    difference + "; options that you leave out are taken from it");
    note_unknown_inputs({path}, {picture});
}

Film resume_film(const std::string &path, uint32_t spp) {
    Film film = exr_read_film(path);
    const SampleCounts counts = film_counts(film);
    if (counts.most > spp)
        throw Error(path + " has up to " + std::to_string(counts.most) +
                    " samples per pixel already; --spp must be at least that");
    if (counts.least >= spp)
        throw Error(path + " has " + std::to_string(spp) +
                    " samples in each pixel already; give a larger --spp");
    return film;
}
