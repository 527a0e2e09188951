// SPDX-License-Identifier: Apache-2.0
// The difference between a picture and its reference, as is and as seen from a distance.
#pragma once

#include <string>
#include <vector>

#include "image.h"

// The RMS of image - reference over pixels and channels, after a Gaussian of sigma pixels that is
// cut off at four sigma and mirrors the picture at its edges. Sigma 0 is the plain RMSE. Both
// images must cover the same pixels.
double blurred_rmse(const Image &image, const Image &reference, double sigma);

// The RMS of (image - reference) / (reference + a tenth of the reference's mean) over pixels and
// channels, so dark parts count as much as bright ones.
double relative_rmse(const Image &image, const Image &reference);

// The part of an image inside a crop, which must lie within the image's own crop.
Image image_crop(const Image &image, const Crop &crop);

// The error of a picture as a function of the number of samples.
struct ConvergenceRow {
    double spp;     // on average
    double seconds; // since rendering began
    double rmse;
    double relative_rmse;  // see difference.h
    double rmse_1, rmse_2; // after Gaussians of 1.0 and 2.1 pixels
};

ConvergenceRow convergence_row(const Image &image, const Image &reference, double spp,
                               double seconds);

// The rows as a CSV file with a header line.
std::vector<char> convergence_csv(const std::vector<ConvergenceRow> &rows);
