// SPDX-License-Identifier: Apache-2.0
// Putting a picture together from parts.
#include "merge.h"

#include <algorithm>

#include "error.h"

namespace {

bool overlap(const Crop &a, const Crop &b) {
    return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

Crop around(const Crop &a, const Crop &b) {
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

// What the parts of one picture have in common, by name, for saying what differs.
std::vector<std::pair<const char *, std::string>> settings_of(const ExrHead &head) {
    const ExrAttributes &a = head.attributes;
    return {{"size", std::to_string(head.full_width) + "x" + std::to_string(head.full_height)},
            {"scene", a.scene},
            {"camera", a.camera},
            {"environment", a.environment},
            {"sampler", a.sampler},
            {"mask", a.mask},
            {"declared spp", std::to_string(a.declared_spp)},
            {"seed", std::to_string(a.seed)},
            {"max depth", std::to_string(a.max_depth)},
            {"light samples", std::to_string(a.light_samples)},
            {"single scatter", a.single_scatter ? "on" : "off"},
            {"photometric", a.photometric ? "on" : "off"}};
}

void check_same(const std::string &path, const ExrHead &part, const std::string &first_path,
                const ExrHead &first) {
    const auto have = settings_of(part), wanted = settings_of(first);
    for (size_t i = 0; i < have.size(); ++i)
        if (have[i].second != wanted[i].second)
            throw Error(path + " and " + first_path + " are not parts of one picture: " +
                        have[i].first + " '" + have[i].second + "' and '" + wanted[i].second + "'");
}

} // namespace

MergedPicture merge_pictures(const std::vector<std::string> &paths) {
    std::vector<ExrHead> heads;
    for (const std::string &path : paths) {
        const ExrHead head = exr_read_head(path);
        if (!heads.empty()) check_same(path, head, paths[0], heads[0]);
        for (size_t i = 0; i < heads.size(); ++i) {
            const ExrAttributes &a = heads[i].attributes, &b = head.attributes;
            const bool share_samples =
                a.first_sample < b.end_sample && b.first_sample < a.end_sample;
            if (share_samples && overlap(heads[i].crop, head.crop))
                throw Error(path + " and " + paths[i] +
                            " hold the same samples of the same pixels");
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
        // Of all threads' time, as if one machine had done it all.
        if (all.seconds + a.seconds > 0)
            all.sampling_share = (all.sampling_share * all.seconds + a.sampling_share * a.seconds) /
                                 (all.seconds + a.seconds);
        all.seconds += a.seconds;
        all.ray_count += a.ray_count;
        all.threads = std::max(all.threads, a.threads);
    }
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("the parts lie in a picture of more than " + std::to_string(MAX_PIXELS) +
                    " pixels; merge fewer of them");

    merged.film = film_create(heads[0].full_width, heads[0].full_height, crop);
    for (const std::string &path : paths) {
        const Film part = exr_read_film(path);
        const auto row_length = static_cast<size_t>(width(part.crop));
        for (int y = part.crop.y0; y < part.crop.y1; ++y) {
            FilmPixel *to =
                &merged.film
                     .pixels[static_cast<size_t>(y - crop.y0) * static_cast<size_t>(width(crop)) +
                             static_cast<size_t>(part.crop.x0 - crop.x0)];
            const FilmPixel *from =
                &part.pixels[static_cast<size_t>(y - part.crop.y0) * row_length];
            for (size_t i = 0; i < row_length; ++i) film_merge(to[i], from[i]);
        }
    }
    all.spp = film_counts(merged.film).most;
    all.fireflies = film_fireflies(merged.film);
    return merged;
}
