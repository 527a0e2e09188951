// SPDX-License-Identifier: Apache-2.0
// Takes samples of a picture, or of part of it, on all cores.
#pragma once

#include <cstdint>
#include <functional>

#include "adaptive.h"
#include "film.h"
#include "integrator.h"

struct RenderSettings {
    uint32_t first_sample = 0; // index of the first sample of each pixel
    unsigned threads = 1;
    NoiseSettings noise = {}; // with a level, the film's crop must consist of whole blocks
};

// Statistics of rendering.
struct RenderTotals {
    double seconds = 0; // of rendering alone
    PathCounters counters;
};

// Takes samples until every pixel of the film has `count` of them, or its block is done. Calls go_on(fraction of tiles,
// totals) from the calling thread a few times per second, and stops early if it returns false.
// Pixels then have different numbers of samples, and the next call continues from there. The film
// does not depend on the number of threads, the crop or interruptions. Returns whether all samples
// were taken.
bool render_until(const Integrator &integrator, const RenderSettings &settings, uint32_t count,
                  Film &film, RenderTotals &totals,
                  const std::function<bool(double, const RenderTotals &)> &go_on);

// Whether more samples would be taken: a block is not done, or has fewer than `count` samples.
bool wants_samples(const RenderSettings &settings, uint32_t count, const Film &film);

// Estimates the share of rendering time spent drawing samples, by timing draws alone, with this
// picture's domains and pixels.
double sampling_share(const Integrator &integrator, const RenderSettings &settings,
                      const Film &film, const RenderTotals &totals);
