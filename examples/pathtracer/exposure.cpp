// SPDX-License-Identifier: Apache-2.0
// Choosing the exposure of a preview.
#include "film.h"

#include <algorithm>
#include <cmath>

namespace {

constexpr int BLOCK = 16; // pixels
constexpr double MIDDLE_GREY = 0.18;
constexpr double LARGEST = 64; // stops; the command line has the same limit

bool shows_surface(const FilmPixel &p) {
    return p.hits > 0 && 2 * uint64_t{p.hits} >= p.count;
}

// Whether to judge a picture only by the pixels that show a surface: not if there are hardly any.
bool has_surfaces(const Film &film) {
    const auto hits = std::count_if(film.pixels.begin(), film.pixels.end(), shows_surface);
    return static_cast<size_t>(hits) * 1000 > film.pixels.size();
}

} // namespace

float auto_exposure(const Film &film) {
    const bool surfaces_only = has_surfaces(film);
    const int columns = width(film.crop), rows = height(film.crop);
    double sum = 0, weight = 0; // of logarithms
    for (int top = 0; top < rows; top += BLOCK)
        for (int left = 0; left < columns; left += BLOCK) {
            double light = 0, count = 0;
            for (int y = top; y < std::min(top + BLOCK, rows); ++y)
                for (int x = left; x < std::min(left + BLOCK, columns); ++x) {
                    const FilmPixel &p = film_pixel(film, film.crop.x0 + x, film.crop.y0 + y);
                    if (p.count == 0 || (surfaces_only && !shows_surface(p))) continue;
                    light += luminance(p.radiance);
                    ++count;
                }
            if (!(light > 0)) continue;
            sum += count * std::log2(light / count);
            weight += count;
        }
    if (!(weight > 0)) return 0;
    const double exposure = std::log2(MIDDLE_GREY) - sum / weight;
    return static_cast<float>(std::clamp(std::round(4 * exposure) / 4, -LARGEST, LARGEST));
}

std::string film_warning(const Film &film, const std::string &extent) {
    if (film_counts(film).most == 0) return "";
    const auto any = [&](auto holds) {
        return std::any_of(film.pixels.begin(), film.pixels.end(), holds);
    };
    if (!any([](const FilmPixel &p) { return p.hits > 0; }))
        return "NOTHING IS VISIBLE: no camera ray hits a surface; point the camera at the scene, "
               "which " +
               extent + ", with --eye and --target, or leave them out";
    if (!any([](const FilmPixel &p) { return max_component(p.radiance) > 0; }))
        return "THE PICTURE IS BLACK: no light reaches the visible surfaces; add some with --env "
               "sky, look from inside with --eye and --target, or raise --max-depth";
    return "";
}
