// SPDX-License-Identifier: Apache-2.0
// Accumulating the samples of each pixel, and what follows from them: the exposure of a preview, and where
// a picture has enough samples.
#include "film.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>

#include "files.h"

namespace {

constexpr int LARGE_BLOCK = 16; // pixels
constexpr double MIDDLE_GREY = 0.18;
constexpr double LARGEST = 64; // stops; the command line has the same limit

bool shows_surface(const FilmPixel &p) {
    return p.hits > 0 && 2 * uint64_t{p.hits} >= p.count;
}

// Keeps black from needing endless samples: a fiftieth of white.
constexpr double DARKEST = 0.02;

int up_to_block(int v, int limit) {
    return std::min((v + BLOCK_SIZE - 1) / BLOCK_SIZE * BLOCK_SIZE, limit);
}

} // namespace

Film film_create(int full_width, int full_height, const Crop &crop) {
    return {full_width, full_height, crop, std::vector<FilmPixel>(pixel_count(crop))};
}

Film film_with_crop(const Film &film, const Crop &crop) {
    Film result = film_create(film.full_width, film.full_height, crop);
    for (int y = std::max(crop.y0, film.crop.y0); y < std::min(crop.y1, film.crop.y1); ++y)
        for (int x = std::max(crop.x0, film.crop.x0); x < std::min(crop.x1, film.crop.x1); ++x)
            film_pixel(result, x, y) = film_pixel(film, x, y);
    return result;
}

void film_add(FilmPixel &pixel, const PathSample &sample) {
    const double share = 1.0 / ++pixel.count;
    const glm::dvec3 radiance = sample.radiance, difference = radiance - pixel.radiance;
    pixel.radiance += share * difference;
    pixel.squares += difference * (radiance - pixel.radiance);
    pixel.albedo += share * (glm::dvec3(sample.albedo) - pixel.albedo);
    pixel.normal += share * (glm::dvec3(sample.normal) - pixel.normal);
    if (sample.hit) pixel.depth += (sample.depth - pixel.depth) / ++pixel.hits;
}

void film_merge(FilmPixel &pixel, const FilmPixel &other) {
    if (other.count == 0) return;
    const double count = static_cast<double>(pixel.count) + other.count;
    const double share = other.count / count;
    const glm::dvec3 difference = other.radiance - pixel.radiance;
    pixel.squares +=
        other.squares + difference * difference * share * static_cast<double>(pixel.count);
    pixel.radiance += share * difference;
    pixel.albedo += share * (other.albedo - pixel.albedo);
    pixel.normal += share * (other.normal - pixel.normal);
    pixel.count += other.count;
    pixel.hits += other.hits;
    if (other.hits > 0)
        pixel.depth += static_cast<double>(other.hits) / pixel.hits * (other.depth - pixel.depth);
}

SampleCounts film_counts(const Film &film) {
    SampleCounts counts = {film.pixels[0].count, film.pixels[0].count};
    for (const FilmPixel &pixel : film.pixels) {
        counts.least = std::min(counts.least, pixel.count);
        counts.most = std::max(counts.most, pixel.count);
    }
    return counts;
}

double film_samples(const Film &film) {
    double samples = 0;
    for (const FilmPixel &pixel : film.pixels) samples += pixel.count;
    return samples;
}

Image film_image(const Film &film) {
    Image image{film.full_width, film.full_height, film.crop, {}};
    for (const FilmPixel &pixel : film.pixels) image.rgb.push_back(pixel.radiance);
    return image;
}

glm::dvec3 film_variance(const FilmPixel &pixel) {
    return pixel.count < 2 ? glm::dvec3(0) : pixel.squares / static_cast<double>(pixel.count - 1);
}

// ---- Exposure

float auto_exposure(const Film &film) {
    // Judges the picture only by the pixels that show a surface, but not if there are hardly any.
    const auto hits = std::count_if(film.pixels.begin(), film.pixels.end(), shows_surface);
    const bool surfaces_only = static_cast<size_t>(hits) * 1000 > film.pixels.size();
    const int columns = width(film.crop), rows = height(film.crop);
    double sum = 0, weight = 0; // of logarithms
    for (int top = 0; top < rows; top += LARGE_BLOCK)
        for (int left = 0; left < columns; left += LARGE_BLOCK) {
            double light = 0, count = 0;
            for (int y = top; y < std::min(top + LARGE_BLOCK, rows); ++y)
                for (int x = left; x < std::min(left + LARGE_BLOCK, columns); ++x) {
                    const FilmPixel &p = film_pixel(film, film.crop.x0 + x, film.crop.y0 + y);
                    if (p.count == 0 || (surfaces_only && !shows_surface(p))) continue;
                    light += luminance(p.radiance);
                    ++count;
                }
            if (!(light > 0)) continue;
            sum += count * std::log2(light / count);
            weight += count;
        }
    if (!(weight > 0)) return 0;
    const double exposure = std::log2(MIDDLE_GREY) - sum / weight;
    return static_cast<float>(std::clamp(std::round(4 * exposure) / 4, -LARGEST, LARGEST));
}

std::string film_warning(const Film &film, const std::string &extent) {
    if (film_counts(film).most == 0) return "";
    const auto any = [&](auto holds) {
        return std::any_of(film.pixels.begin(), film.pixels.end(), holds);
    };
    if (!any([](const FilmPixel &p) { return p.hits > 0; }))
        return "NOTHING IS VISIBLE: no camera ray hits a surface; point the camera at the scene, "
               "which " +
               extent + ", with --eye and --target, or leave them out";
    if (!any([](const FilmPixel &p) { return max_component(p.radiance) > 0; }))
        return "THE PICTURE IS BLACK: no light reaches the visible surfaces; add some with --env "
               "sky, look from inside with --eye and --target, or raise --max-depth";
    return "";
}

// ---- Adaptive sampling

Crop whole_blocks(const Crop &crop, int full_width, int full_height) {
    return {crop.x0 / BLOCK_SIZE * BLOCK_SIZE, crop.y0 / BLOCK_SIZE * BLOCK_SIZE,
            up_to_block(crop.x1, full_width), up_to_block(crop.y1, full_height)};
}

uint32_t next_look(const NoiseSettings &noise, uint32_t count) {
    uint64_t look = 2;
    while (look <= count || look < noise.min_spp) look *= 2;
    return static_cast<uint32_t>(std::min<uint64_t>(look, UINT32_MAX));
}

double displayed_error(const Film &film, const Crop &block, float exposure) {
    const double gain = std::exp2(static_cast<double>(exposure));
    double squares = 0, light = 0;
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x) {
            const FilmPixel &pixel = film_pixel(film, x, y);
            // Single precision, as in the EXR.
            const Vec3 mean = pixel.radiance, variance = film_variance(pixel);
            const glm::dvec3 value = gain * glm::dvec3(mean);
            const glm::dvec3 error =
                gain * sqrt(glm::dvec3(variance) / static_cast<double>(pixel.count));
            // A quarter of what two errors up and down span on the display: the error itself below
            // white, and 0 above.
            const glm::dvec3 shown =
                0.25 * (min(value + 2.0 * error, 1.0) - min(value - 2.0 * error, 1.0));
            squares += dot(shown, shown);
            light += dot(min(value, 1.0), glm::dvec3(1));
        }
    const double values = 3 * static_cast<double>(pixel_count(block));
    return std::sqrt(squares / values) / (light / values + DARKEST);
}

bool is_done(const NoiseSettings &noise, const Film &film, const Crop &block, uint32_t count) {
    if (!(noise.level > 0) || count < 2 || next_look(noise, count - 1) != count) return false;
    return displayed_error(film, block, noise.exposure) < static_cast<double>(noise.level);
}

// ---- Rendering: threads take small tiles from a shared counter until none are left. Each pixel's
// samples are added in order, so the film is bit-identical for any number of threads and any crop.

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
                    return both ? path.ray(ray).draw()[0] : path.ray(ray).draw_direction()[0];
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
    for (uint32_t count = counts.least; count < settings.spp;) {
        const uint32_t next = std::max(std::min(next_count(count), settings.spp), counts.most);
        const auto go_on = [&](double fraction, const RenderTotals &so_far) {
            const double samples = count + fraction * (next - count) - counts.least;
            progress(samples / (settings.spp - counts.least), so_far);
            return !interrupted;
        };
        if (!render_until(integrator, settings, next, film, totals, go_on)) return false;
        count = next;
    }
    return true;
}
