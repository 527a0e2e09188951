// SPDX-License-Identifier: Apache-2.0
// A frame from its first sample to its last.
#include "frame.h"

#include <algorithm>

namespace {

// The most samples per pixel in one pass. Threads stop only between tiles, so a long pass would
// make interrupts slow.
constexpr uint32_t LONGEST_PASS = 256;

// The count after `count` in 1, 2, 3, 4, 6, 8, 12, 16, 24 ...
uint32_t next_count(uint32_t count) {
    uint32_t power = 1;
    while (power <= count / 2) power *= 2;
    const uint32_t step = count < 2 ? 1 : power / 2;
    return count + std::min(step, LONGEST_PASS);
}

// The sample count at which the next pass should end to fit in the time left, or `count` if not
// even one sample fits. Passes from `start` to `count` took `seconds`.
uint32_t count_in_time(uint32_t start, uint32_t count, uint32_t next, double seconds,
                       double time_limit) {
    if (count == start) return count + 1;
    const double per_sample = seconds / (count - start);
    const double fitting = (time_limit - seconds) / per_sample;
    return fitting >= next - count ? next : count + static_cast<uint32_t>(std::max(fitting, 0.0));
}

} // namespace

FrameEnd render_frame(const Integrator &integrator, const FrameSettings &settings, Film &film,
                      RenderTotals &totals, const FrameEvents &events,
                      const volatile std::sig_atomic_t &interrupted) {
    double last_write = totals.seconds;
    const SampleCounts counts = film_counts(film);
    const uint32_t start = counts.least;
    for (uint32_t count = start; count < settings.spp;) {
        uint32_t next = std::min(next_count(count), settings.spp);
        if (settings.time_limit > 0) {
            next = count_in_time(start, count, next, totals.seconds, settings.time_limit);
            if (next == count) return FrameEnd::TIME_IS_UP;
        }
        next = std::max(next, counts.most); // brings all pixels to the same count
        const auto go_on = [&](double fraction, const RenderTotals &so_far) {
            const double samples = count + fraction * (next - count);
            double done = (samples - start) / (settings.spp - start);
            if (settings.time_limit > 0)
                done = std::max(done, std::min(so_far.seconds / settings.time_limit, 1.0));
            events.progress(done, so_far);
            const bool write_now = settings.write_interval > 0 &&
                                   so_far.seconds - last_write >= settings.write_interval;
            return !interrupted && !write_now;
        };
        while (!render_until(integrator, settings.render, next, film, totals, go_on)) {
            if (interrupted) return FrameEnd::INTERRUPTED;
            events.write(totals);
            last_write = totals.seconds;
        }
        count = next;
        events.pass_done(count, totals);
        if (!wants_samples(settings.render, settings.spp, film)) break;
        if (interrupted) return FrameEnd::INTERRUPTED;
    }
    return FrameEnd::COMPLETE;
}
