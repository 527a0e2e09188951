// SPDX-License-Identifier: Apache-2.0
// The accumulated samples of each pixel, from which an image's layers are computed. Values are means in
// double precision, stored with their sample counts. So pixels may have different counts and receive more
// samples later, and films with different samples can be merged.
#pragma once

#include <csignal>
#include <map>

#include "image.h"
#include "integrator.h"

constexpr double UNMEASURED = -1;

struct FilmPixel {
    glm::dvec3 radiance; // mean
    glm::dvec3 squares;  // sum of the radiance's squared deviations from the mean
    glm::dvec3 albedo;   // mean at the camera ray's hit; 0 for a miss
    glm::dvec3 normal;   // likewise, in world space
    double depth;        // along the camera's axis; mean over the samples that hit
    uint32_t count;      // samples taken
    uint32_t hits;       // samples whose camera ray hit a surface
    // With --visible-noise: the mean of the first samples, as many as the largest power of two below `count`,
    // and the noise of the pixel's block in steps, or UNMEASURED.
    glm::dvec3 half;
    double noise = UNMEASURED;
};

struct Film : Window {
    std::vector<FilmPixel> pixels; // row by row
};

Film film_create(int full_width, int full_height, const Crop &crop);

// The pixel (x, y) of the whole image, which must be inside the film's crop.
template <typename FilmOrConst>
auto &film_pixel(FilmOrConst &film, int x, int y) {
    const size_t row = y - film.crop.y0;
    return film.pixels[row * width(film.crop) + x - film.crop.x0];
}

// Calls visit(x, y) for all pixels, row by row.
template <typename Visit>
void each_pixel(const Crop &crop, Visit visit) {
    for (int y = crop.y0; y < crop.y1; ++y)
        for (int x = crop.x0; x < crop.x1; ++x) visit(x, y);
}

// Adds a sample to a pixel (Welford, "Note on a Method for Calculating Corrected Sums of Squares
// and Products", 1962). Sample order affects only the last bits of the result.
void film_add(FilmPixel &pixel, const PathSample &sample);

// Adds the samples of another pixel (Chan, Golub and LeVeque, "Updating Formulae and a Pairwise
// Algorithm for Computing Sample Variances", 1979).
void film_merge(FilmPixel &pixel, const FilmPixel &other);

struct SampleCounts {
    uint32_t least, most;
    double mean;
};
SampleCounts film_counts(const Film &film);

// The mean radiance; black where there are no samples.
Image film_image(const Film &film);

// The unbiased variance of a single sample of radiance; 0 with fewer than two samples.
glm::dvec3 film_variance(const FilmPixel &pixel);

// The exposure in stops that maps the geometric mean of the image's luminance to middle grey (0.18),
// rounded to a quarter of a stop. Only pixels that mostly show a surface count, unless there are very
// few. Luminance is averaged over 16x16 pixels, so that noise and black shadows have little effect.
float auto_exposure(const Film &film);

// A one-line warning, with advice, if the image has no visible surfaces or light; empty otherwise, and
// for parts of an image. `extent` describes the scene's bounds.
std::string film_warning(const Film &film, const std::string &extent);

// The visible noise that 95% of the pixels with samples do not exceed; UNMEASURED if more than 5% of them
// are not measured.
double film_noise(const Film &film);

// ---- Rendering on all cores, in passes over the whole image, so that an interrupt leaves an image with
// fewer samples. Adaptive sampling decides block by block, at powers of two, whether to stop: by variance
// (--noise) or by what a viewer sees (--visible-noise). The grid of blocks is that of the whole image, so
// crops do not matter. docs/stop.md explains why.

struct RenderSettings {
    uint32_t spp;          // samples per pixel
    uint32_t first_sample; // index of the first sample
    unsigned threads;
    float noise;         // relative error as displayed at which a block stops; 0: never
    float visible_noise; // in steps of an 8-bit display, at which a block stops; 0: never
    uint32_t min_spp;    // the first test is at the first power of two at or above this
    float exposure;      // display exposure, in stops

    bool adaptive() const { return noise > 0 || visible_noise > 0; }
    // Pixels per side. The blur of --visible-noise needs larger blocks.
    static constexpr int BLOCK = 8, VISIBLE_BLOCK = 16;
    int block_size() const { return visible_noise > 0 ? VISIBLE_BLOCK : BLOCK; }
};

struct RenderTotals : PathCounters {
    double seconds = 0;
};
using Progress = std::function<void(double fraction, const RenderTotals &)>;

// Adds samples to a film, which may already hold some; blocks that are done get fewer. Reports progress
// as a fraction, a few times per second. Returns false soon after `interrupted` becomes non-zero; pixels
// then have different sample counts. The result does not depend on the number of threads or the crop. Throws
// what a plug-in sampler throws.
bool render_frame(const Integrator &integrator, const RenderSettings &settings, Film &film,
                  RenderTotals &totals, const Progress &progress,
                  const volatile std::sig_atomic_t &interrupted);

// ---- OpenEXR images: layers in one part, 32 bits per channel, ZIP compression; the data window is the
// crop, and attributes are strings.
//
//     R, G, B         mean radiance          A           fraction of camera rays that hit a surface
//     albedo.R, G, B  mean; 0 for misses     normal.X, Y, Z   mean, in world space; 0 for misses
//     depth.Z         along the camera's axis, mean over the hits
//     count           samples taken (the only integer channel)
//     variance.R, G, B  of single samples, unbiased; 0 below two samples
//
// With --visible-noise also:
//
//     noise           of the pixel's block, in steps of an 8-bit display; -1 where not yet measured
//     half.R, G, B    mean radiance of the first samples, as many as the largest power of two below `count`;
//                     0 in blocks that are done

// The maximum number of pixels of a film in memory (7 GiB).
constexpr uint64_t MAX_PIXELS = 1u << 26;

// The statistics of an image: attributes that differ between its parts.
struct ImageStatistics {
    uint32_t spp = 0;                          // the highest sample count of any pixel
    uint64_t first_sample = 0, end_sample = 0; // all sample numbers are below the latter
    float exposure = 0;                        // preview exposure, in stops
    double seconds = 0;                        // rendering time
    uint64_t ray_count = 0;
    unsigned threads = 0;
};

// The header of a file that this program wrote. Parts of one image share the settings, which determine
// its samples.
struct ExrHead : Window {
    std::map<std::string, std::string> settings = {};
    ImageStatistics statistics = {};
};

// Encodes an EXR file of the film, with the film's size and crop. Throws Error.
std::string exr_encode(const Film &film, const ExrHead &head);

// Reads the channels R, G and B of any EXR file that has them, converted to Rec. 709. Throws Error.
Image exr_read(const std::string &path);

// Read files that exr_encode wrote. Throw Error for any other file.
ExrHead exr_read_head(const std::string &path);
Film exr_read_film(const std::string &path);
