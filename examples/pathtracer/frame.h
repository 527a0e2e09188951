// SPDX-License-Identifier: Apache-2.0
// A frame from its first sample to its last: pass after pass over the whole picture, so that there
// is a picture at any time, and that it can be judged or written on the way.
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
    // Often: what part is done, by samples or by time.
    std::function<void(double fraction, const RenderTotals &totals)> progress;
    // When every pixel has `spp` samples: 1, 2, 3, 4, 6, 8, 12, 16 and so on, and the last.
    std::function<void(uint32_t spp, const RenderTotals &totals)> pass_done;
    // Between samples, every write_interval seconds.
    std::function<void(const RenderTotals &totals)> write;
};

enum class FrameEnd { COMPLETE, TIME_IS_UP, INTERRUPTED };

// Fills the film, which may hold samples already, at most `spp` in each pixel. It takes whole
// passes: within a time limit the last one is cut to as many samples as should fit, and there is
// always a first. Ends soon after `interrupted` becomes non-zero.
FrameEnd render_frame(const Integrator &integrator, const FrameSettings &settings, Film &film,
                      RenderTotals &totals, const FrameEvents &events,
                      const volatile std::sig_atomic_t &interrupted);
