// SPDX-License-Identifier: Apache-2.0
// Renders a picture on all cores, in passes over the whole of it, so that an interrupt leaves a
// picture of fewer samples.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>

#include "film.h"
#include "integrator.h"

struct RenderSettings {
    uint32_t spp = 1;          // samples of each pixel
    uint32_t first_sample = 0; // index of the first
    unsigned threads = 1;
    NoiseSettings noise = {}; // with a level, the film's crop must consist of whole blocks
    double time_limit = 0;    // seconds, after which no pass over the picture starts; 0: none
};

// Statistics of rendering.
struct RenderTotals {
    double seconds = 0; // of rendering alone
    PathCounters counters;
};

// Fills a film, which may hold samples already, with fewer where blocks are done or time is up; at
// least one pass runs, and after it all pixels have the same number. Calls progress(fraction done, totals) from the calling thread a few times per second. Returns false soon after `interrupted`
// becomes non-zero: pixels then have different numbers of samples. The film does not depend on the
// number of threads or the crop.
bool render_frame(const Integrator &integrator, const RenderSettings &settings, Film &film,
                  RenderTotals &totals,
                  const std::function<void(double, const RenderTotals &)> &progress,
                  const volatile std::sig_atomic_t &interrupted);

// Estimates the share of rendering time spent drawing samples, by timing draws alone, with this
// picture's domains and pixels.
double sampling_share(const Integrator &integrator, const RenderSettings &settings,
                      const Film &film, const RenderTotals &totals);
