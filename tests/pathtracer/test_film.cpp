// SPDX-License-Identifier: Apache-2.0
// Tests a pixel's running means and variances over 2^24 samples, where a mean in float would drift, and
// the merging of pixels, and the noise of a film with unmeasured or empty pixels.
#include "check.h"
#include "film.h"

namespace {

constexpr uint32_t COUNT = 1u << 24;

// Sample i of a ramp from 0 to 1: red is bright, green has low contrast, and blue is constant.
PathSample sample_at(uint32_t i) {
    const float ramp = float(i) / COUNT;
    PathSample sample = {};
    sample.radiance = {1000 * ramp, 1 + ramp / 1024, 0.1f};
    sample.albedo = sample.normal = {ramp, 0.1f, 1};
    sample.hit = i % 2 == 0;
    sample.depth = ramp;
    return sample;
}

void check_near(double value, double expected, double error, const char *what) {
    CHECK(std::abs(value - expected) <= error, "%s: %.17g instead of %.17g", what, value, expected);
}

void check_pixel(const FilmPixel &pixel) {
    const double n = COUNT, mean = (n - 1) / (2 * n), variance = (n + 1) / (12 * n);
    CHECK(pixel.count == COUNT && pixel.hits == COUNT / 2, "%u samples, %u hits", pixel.count,
          pixel.hits);
    check_near(pixel.albedo[0], mean, 1e-10, "albedo");
    check_near(pixel.normal[2], 1, 1e-10, "normal");
    check_near(pixel.depth, (n - 2) / (2 * n), 1e-10, "depth");
    // Samples are floats, so they differ from the ramp by a relative error of up to 2^-24.
    check_near(pixel.radiance[0], 1000 * mean, 1e-5, "red");
    check_near(pixel.radiance[1], 1 + mean / 1024, 1e-9, "green");
    check_near(pixel.radiance[2], double{0.1f}, 1e-11, "blue");
    check_near(film_variance(pixel)[0], 1e6 * variance, variance, "variance of red");
    check_near(film_variance(pixel)[1] * 1048576, variance, 1e-6 * variance, "variance of green");
    check_near(film_variance(pixel)[2], 0, 1e-20, "variance of blue");
}

// Of 100 pixels with samples, the last `unmeasured` have no noise; the others have 1, 2, 3 ... Another 50 are empty.
double noise_of(int unmeasured) {
    Film film = film_create(15, 10, {0, 0, 15, 10});
    for (int i = 0; i < 100; ++i) {
        film.pixels[i].count = 4;
        if (i < 100 - unmeasured) film.pixels[i].noise = i + 1;
    }
    return film_noise(film);
}

} // namespace

int main() {
    check_near(noise_of(0), 95, 0, "noise");
    check_near(noise_of(5), 95, 0, "noise with 5% unmeasured");
    check_near(noise_of(6), UNMEASURED, 0, "noise with 6% unmeasured");
    check_near(noise_of(100), UNMEASURED, 0, "noise of unmeasured pixels");
    FilmPixel whole = {}, parts[2] = {};
    for (uint32_t i = 0; i < COUNT; ++i) {
        const PathSample sample = sample_at(i);
        film_add(whole, sample);
        film_add(parts[i >= COUNT / 3], sample);
    }
    check_pixel(whole);
    film_merge(parts[0], parts[1]);
    check_pixel(parts[0]);
    return 0;
}
