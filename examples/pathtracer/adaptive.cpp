// SPDX-License-Identifier: Apache-2.0
// Where a picture has enough samples.
#include "film.h"

#include <algorithm>
#include <cmath>

namespace {

// Keeps black from needing endless samples: a fiftieth of white.
constexpr double DARKEST = 0.02;

int up_to_block(int v, int limit) {
    return std::min((v + BLOCK_SIZE - 1) / BLOCK_SIZE * BLOCK_SIZE, limit);
}

} // namespace

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
