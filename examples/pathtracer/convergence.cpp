// SPDX-License-Identifier: Apache-2.0
// How the error of a picture falls as it renders.
#include "convergence.h"

#include <cstdio>

#include "difference.h"

ConvergenceRow convergence_row(const Image &image, const Image &reference, double spp,
                               double seconds) {
    return {spp,
            seconds,
            blurred_rmse(image, reference, 0),
            relative_rmse(image, reference),
            blurred_rmse(image, reference, 1.0),
            blurred_rmse(image, reference, 2.1)};
}

std::vector<char> convergence_csv(const std::vector<ConvergenceRow> &rows) {
    std::string text = "spp,seconds,rmse,relative_rmse,rmse_1.0,rmse_2.1\n";
    for (const ConvergenceRow &row : rows) {
        char line[160];
        std::snprintf(line, sizeof line, "%.9g,%.6f,%.9g,%.9g,%.9g,%.9g\n", row.spp, row.seconds,
                      row.rmse, row.relative_rmse, row.rmse_1, row.rmse_2);
        text += line;
    }
    return {text.begin(), text.end()};
}
