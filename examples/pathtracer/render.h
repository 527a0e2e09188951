// SPDX-License-Identifier: Apache-2.0
// Taking samples of a picture, or of a part of one, on all cores.
#pragma once

#include <cstdint>
#include <functional>

#include "film.h"
#include "integrator.h"

struct RenderSettings {
    uint32_t first_sample = 0; // index of the first sample of each pixel
    unsigned threads = 1;
};

// What rendering adds up beside the film.
struct RenderTotals {
    double seconds = 0; // of rendering alone
    PathCounters counters;
};

// Takes samples until every pixel of the film has `count` of them. Calls go_on(fraction, totals)
// from the calling thread a few times a second, where fraction is of the tiles, and stops early
// when it says false; then pixels have different numbers of samples, and the next call goes on from
// there. The film does not depend on the number of threads, the crop, or where it was interrupted.
// Returns whether all samples were taken.
bool render_until(const Integrator &integrator, const RenderSettings &settings, uint32_t count,
                  Film &film, RenderTotals &totals,
                  const std::function<bool(double, const RenderTotals &)> &go_on);

// The share of rendering's time that went into drawing samples, estimated: what as many draws cost
// when nothing else is done between them, with the domains and pixels of this picture.
double sampling_share(const Integrator &integrator, const RenderSettings &settings,
                      const Film &film, const RenderTotals &totals);
