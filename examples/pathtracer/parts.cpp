// SPDX-License-Identifier: Apache-2.0
// Merging a picture from parts, and continuing one. Each pixel of a picture that was stopped holds its
// first samples, some pixels more than others. The counts alone say which samples are missing, so no
// other state is kept.
#include "outputs.h"

#include <algorithm>
#include <iomanip>
#include <map>
#include <sstream>

#include "error.h"
#include "input_file.h"

namespace {

bool overlap(const Crop &a, const Crop &b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

Crop around(const Crop &a, const Crop &b) {
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

using NamedSettings = std::vector<std::pair<std::string, std::string>>;

NamedSettings settings_of(const ExrHead &head) {
    NamedSettings settings;
    const auto add = [&](const char *name, const auto &value) {
        std::ostringstream text;
        text << std::setprecision(9) << value;
        settings.emplace_back(name, text.str());
    };
    exr_settings(head.attributes, add);
    add("size", std::to_string(head.full_width) + "x" + std::to_string(head.full_height));
    return settings;
}

// The first difference between the settings of two pictures, or between the files they are made of
// unless `allow_changed`, such as "seed '1' and '2'"; empty if they can be parts of one picture.
// Regions and sample ranges are not compared.
std::string settings_difference(const ExrHead &one, const ExrHead &other, bool allow_changed) {
    const NamedSettings a = settings_of(one), b = settings_of(other);
    for (size_t i = 0; i < a.size(); ++i) {
        const auto &[name, value] = a[i];
        if (value == b[i].second) continue;
        if (name != "inputs") return name + " '" + value + "' and '" + b[i].second + "'";
        if (!allow_changed)
            return inputs_difference(value, b[i].second) +
                   " (--allow-changed mixes them all the same)";
    }
    return "";
}

// Adds a part's samples to a pixel of the picture, which starts at sample `first`.
void add_samples(FilmPixel &to, const FilmPixel &from, int x, int y, uint64_t first,
                 const ExrHead &part, const std::string &path) {
    if (from.count == 0) return;
    const uint64_t next = first + to.count, begin = part.attributes.first_sample;
    if (begin > next)
        throw Error("samples ", next, " to ", begin - 1, " of pixel ", x, ",", y,
                    " are missing before ", path, "; render them with ", "--first-sample ", next,
                    " --spp ", begin - next, ", or --resume the picture that was stopped");
    film_merge(to, from);
}

// A picture may come from anybody: the files it names are read below its own folder only, unless
// the user names them too.
void check_inside(const Options &options, const NamedFile &file) {
    if (options.given.count(file.role) > 0) return;
    const auto refuse = [&](const std::string &why) {
        throw Error(options.resume, " names the file ", printable(file.path.string()), ", which ",
                    why, "; name it with ", file.role, ", or use --allow-outside");
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

void add_part(ExrAttributes &to, const ExrAttributes &part) {
    // Weighted by time, as if one machine had rendered everything.
    if (to.seconds + part.seconds > 0)
        to.sampling_share = (to.sampling_share * to.seconds + part.sampling_share * part.seconds) /
                            (to.seconds + part.seconds);
    to.seconds += part.seconds;
    to.ray_count += part.ray_count;
    to.threads = std::max(to.threads, part.threads);
    if (to.inputs != part.inputs) to.inputs.clear();
}

MergedPicture merge_pictures(const std::vector<std::string> &paths, bool allow_changed) {
    std::vector<ExrHead> heads;
    for (const std::string &path : paths) {
        const ExrHead head = exr_read_head(path);
        if (!heads.empty()) {
            const std::string difference = settings_difference(head, heads[0], allow_changed);
            if (!difference.empty())
                throw Error(path, " and ", paths[0],
                            " are not parts of one picture: they differ in ", difference);
        }
        for (size_t i = 0; i < heads.size(); ++i) {
            const ExrAttributes &a = heads[i].attributes, &b = head.attributes;
            const bool share_samples =
                a.first_sample < b.end_sample && b.first_sample < a.end_sample;
            if (share_samples && overlap(heads[i].crop, head.crop))
                throw Error(path, " and ", paths[i],
                            " contain the same samples of the same pixels");
        }
        heads.push_back(head);
    }

    MergedPicture merged{{}, heads[0].attributes};
    ExrAttributes &all = merged.attributes;
    Crop crop = heads[0].crop;
    for (size_t i = 1; i < heads.size(); ++i) {
        const ExrAttributes &a = heads[i].attributes;
        crop = around(crop, heads[i].crop);
        all.first_sample = std::min(all.first_sample, a.first_sample);
        all.end_sample = std::max(all.end_sample, a.end_sample);
        add_part(all, a);
    }
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("the parts span more than ", MAX_PIXELS, " pixels; merge fewer of them");

    merged.film = film_create(heads[0].full_width, heads[0].full_height, crop);
    // In sample order, so that each pixel fills up without gaps.
    std::multimap<uint64_t, size_t> order;
    for (size_t i = 0; i < paths.size(); ++i) order.emplace(heads[i].attributes.first_sample, i);
    for (const auto &[first, i] : order) {
        const Film part = exr_read_film(paths[i]);
        for (int y = part.crop.y0; y < part.crop.y1; ++y)
            for (int x = part.crop.x0; x < part.crop.x1; ++x)
                add_samples(film_pixel(merged.film, x, y), film_pixel(part, x, y), x, y,
                            all.first_sample, heads[i], paths[i]);
    }
    all.spp = film_counts(merged.film).most;
    return merged;
}

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
        throw Error(options.resume, " is of a picture of ", head.full_width, "x", head.full_height,
                    " pixels; leave out --size, or give that size");
    unless_given("--crop", options.crop, head.crop);
    const auto given = [&](const char *name) { return options.given.count(name) > 0; };
    if (!given("--camera") && !given("--eye") && !given("--target") && !given("--fov"))
        options.camera = camera_parse(a.camera);
    visit_settings(options, a, [&](auto, const char *name, auto &option, const auto &value) {
        if constexpr (std::is_same_v<decltype(value), const bool &>)
            option = option || value;
        else
            unless_given(name, option, value);
    });
    unless_given("--first-sample", options.first_sample, static_cast<uint32_t>(a.first_sample));
    if (!given("--lights")) unless_given("--light-samples", options.light_samples, a.light_samples);
    if (a.noise.level > 0 && options.noise.level > 0)
        unless_given("--exposure", options.exposure, a.noise.exposure);
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
        throw Error(options.resume, " is not an earlier state of this picture: they differ in ",
                    difference, "; options that you leave out are taken from it");
    Film film = exr_read_film(options.resume);
    const SampleCounts counts = film_counts(film);
    if (counts.most > options.spp || counts.least >= options.spp)
        throw Error(options.resume, " has ", counts.least, " to ", counts.most,
                    " samples in each pixel already; give a larger --spp");
    return film;
}
