// SPDX-License-Identifier: Apache-2.0
// Accumulating the samples of each pixel, and what follows from them: the exposure of a preview, and where
// a picture has enough samples.
#include "film.h"

#include <algorithm>
#include <cmath>

namespace {

constexpr int LARGE_BLOCK = 16; // pixels
constexpr double MIDDLE_GREY = 0.18;
constexpr double LARGEST = 64; // stops; the command line has the same limit

bool shows_surface(const FilmPixel &p) {
    return p.hits > 0 && 2 * uint64_t{p.hits} >= p.count;
}

// Keeps black from needing endless samples: a fiftieth of white.
constexpr double DARKEST = 0.02;

int up_to_block(int v, int limit) {
    return std::min((v + BLOCK_SIZE - 1) / BLOCK_SIZE * BLOCK_SIZE, limit);
}

} // namespace

Film film_create(int full_width, int full_height, const Crop &crop) {
    return {full_width, full_height, crop, std::vector<FilmPixel>(pixel_count(crop))};
}

Film film_with_crop(const Film &film, const Crop &crop) {
    Film result = film_create(film.full_width, film.full_height, crop);
    for (int y = std::max(crop.y0, film.crop.y0); y < std::min(crop.y1, film.crop.y1); ++y)
        for (int x = std::max(crop.x0, film.crop.x0); x < std::min(crop.x1, film.crop.x1); ++x)
            film_pixel(result, x, y) = film_pixel(film, x, y);
    return result;
}

void film_add(FilmPixel &pixel, const PathSample &sample) {
    const double share = 1.0 / ++pixel.count;
    const glm::dvec3 radiance = sample.radiance, difference = radiance - pixel.radiance;
    pixel.radiance += share * difference;
    pixel.squares += difference * (radiance - pixel.radiance);
    pixel.albedo += share * (glm::dvec3(sample.albedo) - pixel.albedo);
    pixel.normal += share * (glm::dvec3(sample.normal) - pixel.normal);
    if (sample.hit) pixel.depth += (sample.depth - pixel.depth) / ++pixel.hits;
}

void film_merge(FilmPixel &pixel, const FilmPixel &other) {
    if (other.count == 0) return;
    const double count = static_cast<double>(pixel.count) + other.count;
    const double share = other.count / count;
    const glm::dvec3 difference = other.radiance - pixel.radiance;
    pixel.squares +=
        other.squares + difference * difference * share * static_cast<double>(pixel.count);
    pixel.radiance += share * difference;
    pixel.albedo += share * (other.albedo - pixel.albedo);
    pixel.normal += share * (other.normal - pixel.normal);
    pixel.count += other.count;
    pixel.hits += other.hits;
    if (other.hits > 0)
        pixel.depth += static_cast<double>(other.hits) / pixel.hits * (other.depth - pixel.depth);
}

SampleCounts film_counts(const Film &film) {
    SampleCounts counts = {film.pixels[0].count, film.pixels[0].count};
    for (const FilmPixel &pixel : film.pixels) {
        counts.least = std::min(counts.least, pixel.count);
        counts.most = std::max(counts.most, pixel.count);
    }
    return counts;
}

double film_samples(const Film &film) {
    double samples = 0;
    for (const FilmPixel &pixel : film.pixels) samples += pixel.count;
    return samples;
}

Image film_image(const Film &film) {
    Image image{film.full_width, film.full_height, film.crop, {}};
    for (const FilmPixel &pixel : film.pixels) image.rgb.push_back(pixel.radiance);
    return image;
}

glm::dvec3 film_variance(const FilmPixel &pixel) {
    return pixel.count < 2 ? glm::dvec3(0) : pixel.squares / static_cast<double>(pixel.count - 1);
}

// ---- Exposure

float auto_exposure(const Film &film) {
    // Judges the picture only by the pixels that show a surface, but not if there are hardly any.
    const auto hits = std::count_if(film.pixels.begin(), film.pixels.end(), shows_surface);
    const bool surfaces_only = static_cast<size_t>(hits) * 1000 > film.pixels.size();
    const int columns = width(film.crop), rows = height(film.crop);
    double sum = 0, weight = 0; // of logarithms
    for (int top = 0; top < rows; top += LARGE_BLOCK)
        for (int left = 0; left < columns; left += LARGE_BLOCK) {
            double light = 0, count = 0;
            for (int y = top; y < std::min(top + LARGE_BLOCK, rows); ++y)
                for (int x = left; x < std::min(left + LARGE_BLOCK, columns); ++x) {
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

// ---- Adaptive sampling

Crop whole_blocks(const Crop &crop, int full_width, int full_height) {
    return {crop.x0 / BLOCK_SIZE * BLOCK_SIZE, crop.y0 / BLOCK_SIZE * BLOCK_SIZE,
            up_to_block(crop.x1, full_width), up_to_block(crop.y1, full_height)};
}

uint32_t next_look(const NoiseSettings &noise, uint32_t count) {
    uint64_t look = 2;
    while (look <= count || look < noise.min_spp) look *= 2;
    return static_cast<uint32_t>(std::min<uint64_t>(look, UINT32_MAX));
}

double displayed_error(const Film &film, const Crop &block, float exposure) {
    const double gain = std::exp2(static_cast<double>(exposure));
    double squares = 0, light = 0;
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x) {
            const FilmPixel &pixel = film_pixel(film, x, y);
            // Single precision, as in the EXR.
            const Vec3 mean = pixel.radiance, variance = film_variance(pixel);
            const glm::dvec3 value = gain * glm::dvec3(mean);
            const glm::dvec3 error =
                gain * sqrt(glm::dvec3(variance) / static_cast<double>(pixel.count));
            // A quarter of what two errors up and down span on the display: the error itself below
            // white, and 0 above.
            const glm::dvec3 shown =
                0.25 * (min(value + 2.0 * error, 1.0) - min(value - 2.0 * error, 1.0));
            squares += dot(shown, shown);
            light += dot(min(value, 1.0), glm::dvec3(1));
        }
    const double values = 3 * static_cast<double>(pixel_count(block));
    return std::sqrt(squares / values) / (light / values + DARKEST);
}

bool is_done(const NoiseSettings &noise, const Film &film, const Crop &block, uint32_t count) {
    if (!(noise.level > 0) || count < 2 || next_look(noise, count - 1) != count) return false;
    return displayed_error(film, block, noise.exposure) < static_cast<double>(noise.level);
}
