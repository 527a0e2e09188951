// SPDX-License-Identifier: Apache-2.0
// Takes samples of a picture, or of part of it, on all cores; and renders a frame from its first sample
// to its last, in passes over the whole picture, so the picture can be compared or written at any time.
#pragma once

#include <csignal>
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

struct FrameSettings {
    RenderSettings render;
    uint32_t spp;              // target samples per pixel
    double time_limit = 0;     // seconds of rendering after which no pass starts; 0: none
    double write_interval = 0; // seconds of rendering between calls to `write`; 0: never
};

struct FrameEvents {
    // Called often, with the fraction done, by samples or by time.
    std::function<void(double fraction, const RenderTotals &totals)> progress;
    // Called when every pixel has `spp` samples or its block is done: at 1, 2, 3, 4, 6, 8, 12, 16 and so on, and at the
    // final count.
    std::function<void(uint32_t spp, const RenderTotals &totals)> pass_done;
    // Called between samples, every write_interval seconds.
    std::function<void(const RenderTotals &totals)> write;
};

enum class FrameEnd { COMPLETE, TIME_IS_UP, INTERRUPTED };

// Fills the film, which may already hold samples, to `spp` samples per pixel, or fewer where blocks
// are done. Passes always
// complete: with a time limit, the last pass takes as many samples as should fit, and at least one
// pass runs. Returns soon after `interrupted` becomes non-zero.
FrameEnd render_frame(const Integrator &integrator, const FrameSettings &settings, Film &film,
                      RenderTotals &totals, const FrameEvents &events,
                      const volatile std::sig_atomic_t &interrupted);
