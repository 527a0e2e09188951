// SPDX-License-Identifier: Apache-2.0
// Renders a frame from first sample to last, in passes over the whole picture, so the picture can
// be compared or written at any time.
#pragma once

#include <csignal>
#include <functional>

#include "render.h"

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
