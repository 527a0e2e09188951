// SPDX-License-Identifier: Apache-2.0
// The error of a picture as a function of the number of samples.
#pragma once

#include <string>
#include <vector>

#include "image.h"

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
