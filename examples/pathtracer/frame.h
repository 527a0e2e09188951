// SPDX-License-Identifier: Apache-2.0
// Renders a frame from the first sample to the last, in passes over the whole picture. So the
// picture can be compared or written at any time.
#pragma once

#include <csignal>
#include <functional>

#include "render.h"

struct FrameSettings {
    RenderSettings render;
    uint32_t spp;              // samples per pixel to end with
    double time_limit = 0;     // seconds of rendering after which no pass begins; 0: none
    double write_interval = 0; // seconds of rendering between calls of `write`; 0: never
};

struct FrameEvents {
    // Called often, with the fraction that is done, by samples or by time.
    std::function<void(double fraction, const RenderTotals &totals)> progress;
    // Called when every pixel has `spp` samples: 1, 2, 3, 4, 6, 8, 12, 16 and so on, and the last
    // count.
    std::function<void(uint32_t spp, const RenderTotals &totals)> pass_done;
    // Called between samples, every write_interval seconds.
    std::function<void(const RenderTotals &totals)> write;
};

enum class FrameEnd { COMPLETE, TIME_IS_UP, INTERRUPTED };

// Fills the film up to `spp` samples in each pixel; it may hold some already. Passes are always
// complete: with a time limit, the last pass takes as many samples as should fit, and there is
// always at least one pass. Returns soon after `interrupted` becomes non-zero.
FrameEnd render_frame(const Integrator &integrator, const FrameSettings &settings, Film &film,
                      RenderTotals &totals, const FrameEvents &events,
                      const volatile std::sig_atomic_t &interrupted);
