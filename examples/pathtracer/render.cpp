// SPDX-License-Identifier: Apache-2.0
// Rendering on all cores: threads take small tiles from a counter until none is left. A pixel is
// summed by one thread, in the order of its samples, so the picture is the same to the bit for any
// number of threads and any crop.
#include "render.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#include "error.h"

namespace {

constexpr int TILE_SIZE = 8; // pixels: small, so that the last tiles end together

struct Job {
    const Integrator *integrator;
    const RenderSettings *settings;
    Image *image;
    int tiles_x, tile_count;
    std::atomic<int> next_tile{0};
    std::atomic<int> tiles_done{0};
    std::atomic<uint64_t> ray_count{0};
    double cut_off = 0; // guarded by the mutex
    std::mutex mutex;
    std::condition_variable finished; // a thread has left
    unsigned threads_left = 0;
};

void render_pixel(Job &job, int x, int y, PathCounters &counters) {
    const RenderSettings &settings = *job.settings;
    // In double, so that thousands of samples add up without a trace of rounding in the result.
    double sum[3] = {0, 0, 0};
    for (uint32_t s = 0; s < settings.spp; ++s) {
        const Vec3 radiance =
            trace_path(*job.integrator, x, y, settings.first_sample + s, counters);
        sum[0] += static_cast<double>(radiance.x);
        sum[1] += static_cast<double>(radiance.y);
        sum[2] += static_cast<double>(radiance.z);
    }
    const auto row = static_cast<size_t>(y - settings.crop.y0);
    const auto column = static_cast<size_t>(x - settings.crop.x0);
    const auto row_length = static_cast<size_t>(width(settings.crop));
    float *out = &job.image->rgb[3 * (row * row_length + column)];
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(sum[c] / settings.spp);
}

void render_tiles(Job &job) {
    geometry_thread_begin();
    const Crop &crop = job.settings->crop;
    double cut_off = 0;
    for (;;) {
        const int tile = job.next_tile.fetch_add(1, std::memory_order_relaxed);
        if (tile >= job.tile_count) break;
        const int x0 = crop.x0 + tile % job.tiles_x * TILE_SIZE;
        const int y0 = crop.y0 + tile / job.tiles_x * TILE_SIZE;
        PathCounters counters;
        for (int y = y0; y < std::min(y0 + TILE_SIZE, crop.y1); ++y)
            for (int x = x0; x < std::min(x0 + TILE_SIZE, crop.x1); ++x)
                render_pixel(job, x, y, counters);
        cut_off += counters.cut_off;
        job.ray_count.fetch_add(counters.rays, std::memory_order_relaxed);
        job.tiles_done.fetch_add(1, std::memory_order_relaxed);
    }
    const std::lock_guard<std::mutex> lock(job.mutex);
    job.cut_off += cut_off;
    --job.threads_left;
    job.finished.notify_one();
}

} // namespace

Image render(const Integrator &integrator, const RenderSettings &settings,
             const std::function<void(const RenderProgress &)> &report, RenderProgress &done) {
    const Crop &crop = settings.crop;
    const Camera &camera = integrator.scene->camera;
    Image image{static_cast<int>(2 * camera.half_width), static_cast<int>(2 * camera.half_height),
                crop, std::vector<float>(3 * pixel_count(crop))};
    Job job;
    job.integrator = &integrator;
    job.settings = &settings;
    job.image = &image;
    job.tiles_x = (width(crop) + TILE_SIZE - 1) / TILE_SIZE;
    job.tile_count = job.tiles_x * ((height(crop) + TILE_SIZE - 1) / TILE_SIZE);

    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    const auto progress = [&] {
        const double fraction = static_cast<double>(job.tiles_done.load()) / job.tile_count;
        const std::chrono::duration<double> elapsed = Clock::now() - start;
        return RenderProgress{fraction, elapsed.count(), job.ray_count.load(), 0};
    };

    std::vector<std::thread> threads;
    {
        std::unique_lock<std::mutex> lock(job.mutex);
        try {
            while (threads.size() < settings.threads) {
                threads.emplace_back(render_tiles, std::ref(job));
                ++job.threads_left;
            }
        } catch (const std::system_error &) {
            // The system gives no more threads: those there are do the work.
            if (threads.empty()) throw Error("the system lets this program start no thread");
        }
        while (!job.finished.wait_for(lock, std::chrono::milliseconds(250),
                                      [&] { return job.threads_left == 0; })) {
            lock.unlock();
            report(progress());
            lock.lock();
        }
    }
    for (std::thread &thread : threads) thread.join();
    done = progress();
    done.cut_off = job.cut_off / (static_cast<double>(pixel_count(crop)) * settings.spp);
    report(done);
    return image;
}
