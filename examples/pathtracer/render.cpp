// SPDX-License-Identifier: Apache-2.0
// Rendering on all cores: threads take small tiles from a shared counter until none are left. Each
// pixel's samples are added in order, so the film is bit-identical for any number of threads and
// any crop.
#include "render.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#include "files.h"

namespace {

// Small, so that the last tiles finish together. Tiles are blocks of adaptive sampling, on the same
// grid over the whole picture.
constexpr int TILE_SIZE = BLOCK_SIZE;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Job {
    const Integrator &integrator;
    const RenderSettings &settings;
    uint32_t count;
    Film &film;
    std::vector<Crop> tiles = {}; // row by row, those at the edges smaller
    std::atomic<size_t> next_tile{0};
    std::atomic<bool> stop{false};
    std::mutex mutex = {};
    std::condition_variable finished = {}; // signalled when a thread exits
    PathCounters counters = {};            // guarded by the mutex, like the rest
    size_t tiles_done = 0;
    unsigned threads_left = 0;
};

void render_pixel(const Job &job, int x, int y, uint32_t count, PathCounters &counters) {
    FilmPixel &pixel = film_pixel(job.film, x, y);
    while (pixel.count < count) {
        const uint32_t index = job.settings.first_sample + pixel.count;
        PathSample sample = trace_path(job.integrator, x, y, index, counters);
        // One such sample would spoil the pixel for good. Count it; the total is reported at the
        // end.
        if (!is_finite(sample.radiance)) {
            sample.radiance = {0, 0, 0};
            ++counters.lost;
        }
        film_add(pixel, sample);
    }
}

void render_tile(const Job &job, const Crop &tile, uint32_t count, PathCounters &counters) {
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x) render_pixel(job, x, y, count, counters);
}

// Up to the job's count, or to a look that finds enough samples. Pixels of a block that a resumed
// picture does not have catch up with the others first.
void render_block(const Job &job, const Crop &block, PathCounters &counters) {
    const NoiseSettings &noise = job.settings.noise;
    uint32_t count = 0;
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x)
            count = std::max(count, film_pixel(job.film, x, y).count);
    for (;;) {
        render_tile(job, block, count, counters);
        if (count >= job.count || is_done(noise, job.film, block, count)) return;
        count = std::min(next_look(noise, count), job.count);
    }
}

void render_tiles(Job &job) {
    geometry_thread_begin();
    while (!job.stop.load(std::memory_order_relaxed)) {
        const size_t tile = job.next_tile.fetch_add(1, std::memory_order_relaxed);
        if (tile >= job.tiles.size()) break;
        const Crop &pixels = job.tiles[tile];
        PathCounters counters;
        if (job.settings.noise.level > 0)
            render_block(job, pixels, counters);
        else
            render_tile(job, pixels, job.count, counters);
        const std::lock_guard<std::mutex> lock(job.mutex);
        job.counters += counters;
        ++job.tiles_done;
    }
    const std::lock_guard<std::mutex> lock(job.mutex);
    --job.threads_left;
    job.finished.notify_one();
}

// Takes samples until every pixel of the film has `count` of them, or its block is done. Stops early
// if go_on(fraction of tiles, totals), called a few times per second, returns false. Returns whether
// all samples were taken.
template <typename GoOn>
bool render_until(const Integrator &integrator, const RenderSettings &settings, uint32_t count,
                  Film &film, RenderTotals &totals, GoOn go_on) {
    const Clock::time_point start = Clock::now();
    Job job{integrator, settings, count, film};
    const Crop &crop = film.crop, all = whole_blocks(crop, film.full_width, film.full_height);
    for (int y = all.y0; y < all.y1; y += TILE_SIZE)
        for (int x = all.x0; x < all.x1; x += TILE_SIZE)
            job.tiles.push_back({std::max(x, crop.x0), std::max(y, crop.y0),
                                 std::min(x + TILE_SIZE, crop.x1),
                                 std::min(y + TILE_SIZE, crop.y1)});

    std::vector<std::thread> threads;
    {
        std::unique_lock<std::mutex> lock(job.mutex);
        try {
            while (threads.size() < settings.threads) {
                threads.emplace_back(render_tiles, std::ref(job));
                ++job.threads_left;
            }
        } catch (const std::system_error &) {
            // The system grants no more threads: those already started do the work.
            if (threads.empty()) throw Error("the system does not let this program start a thread");
        }
        while (!job.finished.wait_for(lock, std::chrono::milliseconds(100),
                                      [&] { return job.threads_left == 0; })) {
            const double fraction =
                static_cast<double>(job.tiles_done) / static_cast<double>(job.tiles.size());
            RenderTotals so_far = totals;
            so_far.counters += job.counters;
            so_far.seconds += seconds_since(start);
            lock.unlock();
            if (!go_on(fraction, so_far)) job.stop = true;
            lock.lock();
        }
    }
    for (std::thread &thread : threads) thread.join();
    totals.counters += job.counters;
    totals.seconds += seconds_since(start);
    return job.tiles_done == job.tiles.size();
}

// The most samples per pixel in one pass.
constexpr uint32_t LONGEST_PASS = 256;

// The count after `count` in 1, 2, 3, 4, 6, 8, 12, 16, 24 ...
uint32_t next_count(uint32_t count) {
    uint32_t power = 1;
    while (power <= count / 2) power *= 2;
    const uint32_t step = count < 2 ? 1 : power / 2;
    return count + std::min(step, LONGEST_PASS);
}

} // namespace

double sampling_share(const Integrator &integrator, const RenderSettings &settings,
                      const Film &film, const RenderTotals &totals) {
    if (!(totals.seconds > 0)) return 0;
    const auto seconds_per_draw = [&](bool both) {
        constexpr int DRAWS = 1 << 15;
        const Crop &crop = film.crop;
        double fastest = 1;
        volatile float sink = 0; // keeps the compiler from removing the draws
        for (int run = 0; run < 3; ++run) {
            const Clock::time_point start = Clock::now();
            float sum = 0;
            for (int i = 0; i < DRAWS; ++i) {
                // In the order paths draw: all rays of a sample, then the next sample or pixel.
                const int x = crop.x0 + i / 64 % width(crop), y = crop.y0 + i / 512 % height(crop);
                const uint32_t index = settings.first_sample + static_cast<uint32_t>(i / 16 % 4);
                const uint32_t ray = static_cast<uint32_t>(i) % (integrator.max_depth + 1);
                sum += with_path(*integrator.sampler, x, y, index, [&](const auto &path) {
                    return both ? path.ray(ray).draw()[0] : path.ray(ray).draw_where()[0];
                });
            }
            sink = sink + sum;
            fastest = std::min(fastest, seconds_since(start) / DRAWS);
        }
        return fastest;
    };
    const double drawing = static_cast<double>(totals.counters.draws_2d) * seconds_per_draw(false) +
                           static_cast<double>(totals.counters.draws_4d) * seconds_per_draw(true);
    return drawing / (totals.seconds * settings.threads);
}

bool render_frame(const Integrator &integrator, const RenderSettings &settings, Film &film,
                  RenderTotals &totals,
                  const std::function<void(double, const RenderTotals &)> &progress,
                  const volatile std::sig_atomic_t &interrupted) {
    const SampleCounts counts = film_counts(film);
    const double limit = settings.time_limit;
    for (uint32_t count = counts.least; count < settings.spp;) {
        uint32_t next = std::min(next_count(count), settings.spp);
        if (limit > 0 && count > counts.least) { // no more than what should fit
            const double fitting =
                (limit - totals.seconds) / totals.seconds * (count - counts.least);
            if (fitting < 1) break;
            if (fitting < next - count) next = count + static_cast<uint32_t>(fitting);
        }
        next = std::max(limit > 0 && count == counts.least ? count + 1 : next, counts.most);
        const auto go_on = [&](double fraction, const RenderTotals &so_far) {
            const double samples = count + fraction * (next - count) - counts.least;
            progress(std::max(samples / (settings.spp - counts.least),
                              limit > 0 ? std::min(so_far.seconds / limit, 1.0) : 0),
                     so_far);
            return !interrupted;
        };
        if (!render_until(integrator, settings, next, film, totals, go_on)) return false;
        count = next;
    }
    return true;
}
