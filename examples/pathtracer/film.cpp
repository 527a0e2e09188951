// SPDX-License-Identifier: Apache-2.0
// Renders a film in blocks on all cores, and computes what needs many pixels: the automatic exposure, and
// when a block may stop (--noise, --visible-noise).
#include "film.h"

#include <bn/bn.h>

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <new>
#include <system_error>

#include "files.h"

namespace {

constexpr int LARGE_BLOCK = 16; // for auto_exposure
constexpr double MIDDLE_GREY = 0.18;
constexpr double LARGEST = 64; // stops; the command line has the same limit

bool shows_surface(const FilmPixel &p) {
    return p.hits > 0 && 2 * uint64_t{p.hits} >= p.count;
}

// A crop's blocks, row by row from its corner; the last ones may be smaller.
std::vector<Crop> blocks_of(const Crop &crop, int size) {
    std::vector<Crop> blocks;
    for (int y = crop.y0; y < crop.y1; y += size)
        for (int x = crop.x0; x < crop.x1; x += size)
            blocks.push_back({x, y, std::min(x + size, crop.x1), std::min(y + size, crop.y1)});
    return blocks;
}

// ---- Rendering: threads take blocks from a shared counter until none are left. Each pixel's samples
// are added in order, so the film is bit-identical for any number of threads and any crop.

using Clock = std::chrono::steady_clock;

constexpr double DARKEST = 0.02; // a fiftieth of white, so that black does not need endless samples
constexpr double PROGRESS_SECONDS = 0.1; // between two reports
constexpr uint32_t LONGEST_PASS = 256;   // samples per pixel

// A crop extended to whole blocks.
Crop whole_blocks(const Crop &crop, const Film &film, int size) {
    const auto up = [&](int v, int limit) { return std::min((v + size - 1) / size * size, limit); };
    return {crop.x0 / size * size, crop.y0 / size * size, up(crop.x1, film.full_width),
            up(crop.y1, film.full_height)};
}

// The film for another crop, inside or around its own. Pixels outside its own crop have no samples.
Film film_with_crop(const Film &film, const Crop &crop) {
    Film result = film_create(film.full_width, film.full_height, crop);
    const bool inside = pixel_count(crop) < film.pixels.size();
    each_pixel(inside ? crop : film.crop,
               [&](int x, int y) { film_pixel(result, x, y) = film_pixel(film, x, y); });
    return result;
}

// The relative error of a block whose pixels share a count of at least 2: the RMS standard error of the
// displayed (exposed and clipped) mean, over that mean plus DARKEST. Reads what the EXR stores, as resuming does.
double displayed_error(const Film &film, const Crop &block, float exposure) {
    const double gain = std::exp2(double(exposure));
    double squares = 0, light = 0;
    each_pixel(block, [&](int x, int y) {
        const FilmPixel &pixel = film_pixel(film, x, y);
        const Vec3 mean = pixel.radiance, variance = film_variance(pixel);
        const glm::dvec3 value = gain * glm::dvec3(mean);
        const glm::dvec3 error = gain * sqrt(glm::dvec3(variance) / double(pixel.count));
        // The error itself below white, and 0 above.
        const glm::dvec3 shown =
            0.25 * (min(value + 2.0 * error, 1.0) - min(value - 2.0 * error, 1.0));
        squares += dot(shown, shown);
        light += dot(min(value, 1.0), glm::dvec3(1));
    });
    const double values = 3 * double(pixel_count(block));
    return std::sqrt(squares / values) / (light / values + DARKEST);
}

// The visible noise of a block whose pixels share a count of at least 2. The block is measured by itself, with
// mirrored borders, so that its neighbours and the crop do not matter. Like displayed_error(), it reads only
// values that the EXR stores, so a resumed render makes the same decisions.
float visible_noise(const Film &film, const Crop &block, float exposure) {
    std::vector<float> first, second;
    uint32_t half = 1, count = 0;
    each_pixel(block, [&](int x, int y) { count = film_pixel(film, x, y).count; });
    while (2 * half < count) half *= 2;
    bn_visible_noise_options options = bn_visible_noise_options_default();
    options.exposure = std::exp2(double(exposure));
    options.first_share = double(half) / count;
    options.window =
        2 * RenderSettings::VISIBLE_BLOCK + 1; // the whole block, for each of its pixels
    options.threads = 1;
    each_pixel(block, [&](int x, int y) {
        const FilmPixel &pixel = film_pixel(film, x, y);
        const Vec3 mean = pixel.radiance, earlier = pixel.half;
        const Vec3 later = mean + float(half) / float(count - half) * (mean - earlier);
        for (int c = 0; c < 3; ++c) {
            first.push_back(earlier[c]);
            second.push_back(later[c]);
        }
    });
    std::vector<float> map(pixel_count(block));
    if (bn_visible_noise(&options, first.data(), second.data(), uint32_t(width(block)),
                         uint32_t(height(block)), 3, first.size(), map.data(), map.size(), nullptr,
                         nullptr) != BN_SUCCESS)
        throw std::bad_alloc();
    return map[0];
}

struct Renderer {
    const Integrator &integrator;
    const RenderSettings &settings;
    const volatile std::sig_atomic_t &interrupted;
    Film &film;
    RenderTotals &totals;

    // The next count after `count` at which blocks are tested, or UINT32_MAX.
    uint32_t next_test(uint32_t count) const {
        uint64_t next = 2;
        while (next <= count || next < settings.min_spp) next *= 2;
        return uint32_t(std::min<uint64_t>(next, UINT32_MAX));
    }

    // Whether a block with `count` samples per pixel is done; always false between tests.
    bool is_done(const Crop &block, uint32_t count) {
        if (!settings.adaptive() || count < 2) return false;
        const bool is_test = next_test(count - 1) == count;
        if (settings.visible_noise > 0) {
            if (!is_test && count != settings.spp) return false;
            const float noise = visible_noise(film, block, settings.exposure);
            const bool done = is_test && noise < settings.visible_noise;
            each_pixel(block, [&](int x, int y) {
                FilmPixel &pixel = film_pixel(film, x, y);
                pixel.noise = noise;
                if (done) pixel.half = {0, 0, 0}; // needed no more, and zeros make small files
            });
            return done;
        }
        return is_test && displayed_error(film, block, settings.exposure) < double(settings.noise);
    }

    void render_pixel(int x, int y, uint32_t count, PathCounters &counters) {
        for (FilmPixel &pixel = film_pixel(film, x, y); pixel.count < count;) {
            const uint32_t index = settings.first_sample + pixel.count;
            const bool power_of_two = (pixel.count & (pixel.count - 1)) == 0;
            if (settings.visible_noise > 0 && power_of_two) pixel.half = pixel.radiance;
            PathSample sample = trace_path(integrator, x, y, index, counters);
            // One non-finite sample would ruin the pixel. The total is reported at the end.
            if (!is_finite(sample.radiance)) {
                sample.radiance = {0, 0, 0};
                ++counters.lost;
            }
            film_add(pixel, sample);
        }
    }

    // Renders up to `limit` samples, or until a test finds that they suffice. Missing pixels of a
    // resumed image catch up.
    PathCounters render_block(const Crop &block, uint32_t limit) {
        PathCounters counters;
        uint32_t count = settings.adaptive() ? 0 : limit;
        double noise = UNMEASURED;
        each_pixel(block, [&](int x, int y) {
            count = std::max(count, film_pixel(film, x, y).count);
            noise = std::max(noise, film_pixel(film, x, y).noise);
        });
        // An earlier pass has stopped it. A resumed image may hold noise measured at a count that is not a test.
        const bool is_test = count >= 2 && next_test(count - 1) == count;
        if (is_test && noise != UNMEASURED && noise < double(settings.visible_noise))
            return counters;
        for (;; count = std::min(next_test(count), limit)) {
            each_pixel(block, [&](int x, int y) { render_pixel(x, y, count, counters); });
            if (is_done(block, count) || count >= limit) return counters;
        }
    }

    // Gives every pixel `count` samples, unless its block is done. Returns false if interrupted.
    bool render_pass(uint32_t count, const Progress &progress) {
        const std::vector<Crop> blocks = blocks_of(film.crop, settings.block_size());
        const double seconds_before = totals.seconds;
        const Clock::time_point start = Clock::now();
        double reported = 0;
        std::mutex mutex; // guards totals, reported and done
        size_t done = 0;
        std::atomic<size_t> next{0};
        const auto take_blocks = [&] {
            geometry_thread_begin();
            for (size_t i; !interrupted && (i = next++) < blocks.size();) {
                const PathCounters counters = render_block(blocks[i], count);
                const std::lock_guard<std::mutex> lock(mutex);
                const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
                totals += counters;
                totals.seconds = seconds_before + seconds;
                ++done;
                if (seconds - reported < PROGRESS_SECONDS && done < blocks.size()) continue;
                reported = seconds;
                progress(double(done) / double(blocks.size()), totals);
            }
        };
        const auto work = [&] {
            try {
                take_blocks();
            } catch (...) {
                next = blocks.size(); // the other threads stop, too
                throw;
            }
        };
        std::vector<std::future<void>> threads;
        try {
            while (threads.size() + 1 < settings.threads)
                threads.push_back(std::async(std::launch::async, work));
        } catch (const std::system_error &) { // the threads that did start do the work
        }
        work();
        for (std::future<void> &thread : threads) thread.get(); // throws what the thread threw
        return done == blocks.size();
    }
};

} // namespace

Film film_create(int full_width, int full_height, const Crop &crop) {
    return {{full_width, full_height, crop}, std::vector<FilmPixel>(pixel_count(crop))};
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
    if (pixel.count == 0) {
        pixel = other;
        return;
    }
    const double count = double(pixel.count) + other.count;
    const double share = other.count / count;
    const glm::dvec3 difference = other.radiance - pixel.radiance;
    pixel.squares += other.squares + difference * difference * share * double(pixel.count);
    pixel.radiance += share * difference;
    pixel.albedo += share * (other.albedo - pixel.albedo);
    pixel.normal += share * (other.normal - pixel.normal);
    pixel.count += other.count;
    pixel.hits += other.hits;
    if (other.hits > 0)
        pixel.depth += double(other.hits) / pixel.hits * (other.depth - pixel.depth);
}

SampleCounts film_counts(const Film &film) {
    SampleCounts counts = {UINT32_MAX, 0, 0};
    for (const FilmPixel &pixel : film.pixels) {
        counts.least = std::min(counts.least, pixel.count);
        counts.most = std::max(counts.most, pixel.count);
        counts.mean += pixel.count / double(film.pixels.size());
    }
    return counts;
}

Image film_image(const Film &film) {
    Image image{film, {}};
    for (const FilmPixel &pixel : film.pixels) image.rgb.push_back(pixel.radiance);
    return image;
}

glm::dvec3 film_variance(const FilmPixel &pixel) {
    return pixel.count < 2 ? glm::dvec3(0) : pixel.squares / double(pixel.count - 1);
}

double film_noise(const Film &film) {
    std::vector<double> noise; // without places that merged parts leave empty
    for (const FilmPixel &pixel : film.pixels)
        if (pixel.count > 0) noise.push_back(pixel.noise == UNMEASURED ? HUGE_VAL : pixel.noise);
    if (noise.empty()) return UNMEASURED;
    const auto at = noise.begin() + ptrdiff_t(0.95 * double(noise.size() - 1));
    std::nth_element(noise.begin(), at, noise.end());
    return std::isfinite(*at) ? *at : UNMEASURED;
}

// ---- Exposure

float auto_exposure(const Film &film) {
    const auto hits = std::count_if(film.pixels.begin(), film.pixels.end(), shows_surface);
    const bool surfaces_only = size_t(hits) * 1000 > film.pixels.size();
    double sum = 0, weight = 0; // for the mean logarithm
    for (const Crop &block : blocks_of(film.crop, LARGE_BLOCK)) {
        double light = 0, count = 0;
        each_pixel(block, [&](int x, int y) {
            const FilmPixel &p = film_pixel(film, x, y);
            if (p.count == 0 || (surfaces_only && !shows_surface(p))) return;
            light += luminance(p.radiance);
            ++count;
        });
        if (!(light > 0)) continue;
        sum += count * std::log2(light / count);
        weight += count;
    }
    if (!(weight > 0)) return 0;
    const double exposure = std::log2(MIDDLE_GREY) - sum / weight;
    return float(std::clamp(std::round(4 * exposure) / 4, -LARGEST, LARGEST));
}

std::string film_warning(const Film &film, const std::string &extent) {
    const bool part = film.pixels.size() < size_t(film.full_width) * film.full_height;
    if (part || film_counts(film).most == 0) return "";
    bool hit = false, lit = false;
    for (const FilmPixel &p : film.pixels) {
        hit = hit || p.hits > 0;
        lit = lit || max_component(p.radiance) > 0;
    }
    if (!hit)
        return "NOTHING IS VISIBLE: no camera ray hits a surface; point the camera at the scene, "
               "which " +
               extent + ", with --eye and --target, or leave them out";
    if (!lit)
        return "THE IMAGE IS BLACK: no light reaches the visible surfaces; add some with --env "
               "sky, look from inside with --eye and --target, or raise --max-depth";
    return "";
}

bool render_frame(const Integrator &integrator, const RenderSettings &settings, Film &film,
                  RenderTotals &totals, const Progress &progress,
                  const volatile std::sig_atomic_t &interrupted) {
    const Crop crop = film.crop;
    const Crop wide = settings.adaptive() ? whole_blocks(crop, film, settings.block_size()) : crop;
    const bool extends = pixel_count(wide) > pixel_count(crop);
    if (extends) film = film_with_crop(film, wide);
    Renderer renderer = {integrator, settings, interrupted, film, totals};
    const SampleCounts counts = film_counts(film);
    bool complete = true;
    for (uint32_t count = counts.least, next; complete && count < settings.spp; count = next) {
        const uint32_t step = std::clamp(count / 2, 1u, LONGEST_PASS);
        next = std::max(std::min(count + step, settings.spp), counts.most);
        complete = renderer.render_pass(next, [&](double fraction, const RenderTotals &so_far) {
            const double samples = count + fraction * (next - count) - counts.least;
            progress(samples / (settings.spp - counts.least), so_far);
        });
    }
    if (extends) film = film_with_crop(film, crop);
    return complete;
}
