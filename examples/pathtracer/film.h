// SPDX-License-Identifier: Apache-2.0
// The accumulated samples of each pixel, from which the layers of the picture are made. All values
// are means in double precision, stored with the number of samples. So pixels may have different
// numbers of samples, can get more later, and films with different samples can be merged.
#pragma once

#include <cstdint>
#include <vector>

#include "image.h"
#include "integrator.h"

struct FilmPixel {
    double radiance[3]; // mean
    double squares[3];  // of radiance: sum of squared differences from the mean
    double albedo[3];   // means at what the camera ray hits; 0 where it hits nothing
    double normal[3];   // alike, in the world
    double depth;       // along the camera's axis: the mean over those samples that hit
    uint32_t count;     // samples taken
    uint32_t hits;      // of these, camera rays that hit a surface
};

struct Film {
    int full_width, full_height;   // of the whole picture
    Crop crop;                     // the pixels that are held
    std::vector<FilmPixel> pixels; // row by row
};

Film film_create(int full_width, int full_height, const Crop &crop);

// Adds a sample to a pixel (Welford, "Note on a Method for Calculating Corrected Sums of Squares
// and Products", 1962). The order of samples changes only the last bits of the result.
void film_add(FilmPixel &pixel, const PathSample &sample);

// Adds the samples of another pixel (Chan, Golub and LeVeque, "Updating Formulae and a Pairwise
// Algorithm for Computing Sample Variances", 1979).
void film_merge(FilmPixel &pixel, const FilmPixel &other);

// The smallest and the largest number of samples of a pixel.
struct SampleCounts {
    uint32_t least, most;
};
SampleCounts film_counts(const Film &film);

// The mean radiance; black where there is no sample.
Image film_image(const Film &film);

// The unbiased variance of single samples of one channel of radiance; 0 below two samples. The
// samples of a pixel are not independent: the variance of their mean is smaller than this over
// count.
double film_variance(const FilmPixel &pixel, int channel);

// Counts fireflies: pixels more than ten times as bright as both the second brightest of their
// neighbours and the mean of the picture. Such a pixel has found light that its neighbours missed.
// One-pixel edges of small bright objects can be counted too.
uint64_t film_fireflies(const Film &film);
