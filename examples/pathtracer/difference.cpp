// SPDX-License-Identifier: Apache-2.0
// Blue noise moves error to high frequencies, where the eye and any later filter average it away.
// To measure what remains, blur the error first: a separable Gaussian, in double, in two passes.
#include <algorithm>
#include <cmath>

#include "image.h"

namespace {

std::vector<double> gaussian_weights(double sigma) {
    const int radius = static_cast<int>(4 * sigma + 0.5);
    std::vector<double> weights;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
        weights.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
        sum += weights.back();
    }
    for (double &weight : weights) weight /= sum;
    return weights;
}

// Mirrors an index into 0 .. size - 1, repeating the edge: c b a | a b c | c b a.
int mirror(int i, int size) {
    const int period = 2 * size;
    i = (i % period + period) % period;
    return i < size ? i : period - 1 - i;
}

// Filters `lines` lines of `size` elements. Element i of line j is data[j * line_step + i * step].
void filter_lines(std::vector<double> &data, const std::vector<double> &weights, int size,
                  size_t step, int lines, size_t line_step) {
    const int radius = static_cast<int>(weights.size() / 2);
    std::vector<double> line(static_cast<size_t>(size + 2 * radius));
    for (int j = 0; j < lines; ++j) {
        double *first = &data[static_cast<size_t>(j) * line_step];
        for (int i = -radius; i < size + radius; ++i)
            line[i + radius] = first[static_cast<size_t>(mirror(i, size)) * step];
        for (int i = 0; i < size; ++i) {
            double sum = 0;
            for (size_t k = 0; k < weights.size(); ++k)
                sum += weights[k] * line[static_cast<size_t>(i) + k];
            first[static_cast<size_t>(i) * step] = sum;
        }
    }
}

} // namespace

double blurred_rmse(const Image &image, const Image &reference, double sigma) {
    const int columns = width(image.crop), rows = height(image.crop);
    const size_t count = pixel_count(image.crop);
    double total = 0;
    for (int c = 0; c < 3; ++c) {
        std::vector<double> error(count);
        for (size_t i = 0; i < count; ++i) error[i] = double{image.rgb[i][c]} - reference.rgb[i][c];
        if (sigma > 0) {
            const std::vector<double> weights = gaussian_weights(sigma);
            const auto row_length = static_cast<size_t>(columns);
            filter_lines(error, weights, columns, 1, rows, row_length);
            filter_lines(error, weights, rows, row_length, columns, 1);
        }
        for (double e : error) total += e * e;
    }
    return std::sqrt(total / (3 * static_cast<double>(count)));
}

Image image_crop(const Image &image, const Crop &crop) {
    Image result{image.full_width, image.full_height, crop, {}};
    for (int y = crop.y0; y < crop.y1; ++y) {
        const Crop &have = image.crop;
        const size_t first = (y - have.y0) * width(have) + crop.x0 - have.x0;
        const auto from = image.rgb.begin() + static_cast<std::ptrdiff_t>(first);
        result.rgb.insert(result.rgb.end(), from, from + width(crop));
    }
    return result;
}
