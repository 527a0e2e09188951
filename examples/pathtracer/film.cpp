// SPDX-License-Identifier: Apache-2.0
// Accumulating the samples of each pixel.
#include "film.h"

#include <algorithm>

Film film_create(int full_width, int full_height, const Crop &crop) {
    return {full_width, full_height, crop, std::vector<FilmPixel>(pixel_count(crop))};
}

FilmPixel &film_pixel(Film &film, int x, int y) {
    const size_t row = y - film.crop.y0;
    return film.pixels[row * width(film.crop) + x - film.crop.x0];
}

const FilmPixel &film_pixel(const Film &film, int x, int y) {
    return film_pixel(const_cast<Film &>(film), x, y);
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
