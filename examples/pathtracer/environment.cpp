// SPDX-License-Identifier: Apache-2.0
// The environment is sampled by brightness: a row, then a column in it, both by inversion, then
// uniformly over the texel's solid angle. Radiance is constant over a texel, so the pdf can match
// it exactly; with interpolation the two would differ most at the rim of the sun, where it matters.
// The mean is subtracted from each texel's luminance: scattered rays find whatever is no brighter
// than most of the sky, and multiple importance sampling accounts for both (Karlik et al., "MIS
// Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", 2019). A uniform
// sky is left to scattered rays alone.
#include "environment.h"

#include <cmath>

#include "distribution.h"
#include "error.h"
#include "exr.h"

namespace {

// Sample the environment only if at least this share of its light exceeds the mean.
constexpr double LEAST_CONTRAST = 0.02;

glm::ivec2 texel_at(const Environment &e, Vec3 d) {
    const float longitude = std::atan2(d.x, d.z);
    const float from_top = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
    const float x = (0.5f - longitude / (2 * PI)) * static_cast<float>(e.width);
    const float y = from_top / PI * static_cast<float>(e.height);
    return clamp(glm::ivec2(x, y), glm::ivec2(0), glm::ivec2(e.width, e.height) - 1);
}

Vec3 direction_at(float column, float cosine, int width) {
    const float longitude = (0.5f - column / static_cast<float>(width)) * 2 * PI;
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
}

float texel_pdf(const Environment &e, size_t row, float probability) {
    const float solid_angle =
        (e.row_cosines[row] - e.row_cosines[row + 1]) * 2 * PI / static_cast<float>(e.width);
    return probability / solid_angle;
}

} // namespace

Environment environment_create(int width, int height, std::vector<Vec3> texels) {
    Environment e{width, height, std::move(texels), {}, {}, {}, 0};
    for (Vec3 &v : e.texels) {
        if (!is_finite(v)) throw Error("it has a texel that is not finite");
        v = max(Vec3(0), v);
    }
    const auto w = static_cast<size_t>(width), h = static_cast<size_t>(height);
    e.row_limits.resize(h + 1);
    e.column_limits.resize(h * (w + 1));
    e.row_cosines.resize(h + 1);
    for (size_t y = 0; y <= h; ++y)
        e.row_cosines[y] = static_cast<float>(
            std::cos(3.14159265358979 * static_cast<double>(y) / static_cast<double>(h)));

    std::vector<double> weights(w * h), solid_angles(h), row_weights(h);
    double total = 0;
    for (size_t y = 0; y < h; ++y) {
        solid_angles[y] =
            static_cast<double>((e.row_cosines[y] - e.row_cosines[y + 1]) * 2 * PI) / width;
        for (size_t x = 0; x < w; ++x) {
            weights[y * w + x] = static_cast<double>(luminance(e.texels[y * w + x]));
            total += weights[y * w + x] * solid_angles[y];
        }
    }
    const double mean = total / (4 * static_cast<double>(PI));
    double sampled = 0;
    for (size_t y = 0; y < h; ++y) {
        for (size_t x = 0; x < w; ++x) {
            double &weight = weights[y * w + x];
            weight = std::max(0.0, weight - mean);
            row_weights[y] += weight * solid_angles[y];
        }
        distribution_build(&weights[y * w], w, &e.column_limits[y * (w + 1)]);
        sampled += row_weights[y];
    }
    distribution_build(row_weights.data(), h, e.row_limits.data());
    e.irradiance = sampled > LEAST_CONTRAST * total ? static_cast<float>(sampled) : 0;
    return e;
}

Vec3 environment_radiance(const Environment &e, Vec3 direction) {
    const glm::ivec2 at = texel_at(e, direction);
    return e.texels[at.y * e.width + at.x];
}

float environment_pdf(const Environment &e, Vec3 direction) {
    const glm::ivec2 at = texel_at(e, direction);
    const float *row = &e.row_limits[at.y], *column = &e.column_limits[at.y * (e.width + 1) + at.x];
    return texel_pdf(e, at.y, (row[1] - row[0]) * (column[1] - column[0]));
}

EnvironmentSample environment_sample(const Environment &e, Vec2 u) {
    const auto w = static_cast<size_t>(e.width), h = static_cast<size_t>(e.height);
    const Choice row = distribution_choose(e.row_limits.data(), h, u.y);
    const Choice column = distribution_choose(&e.column_limits[row.index * (w + 1)], w, u.x);
    const float cosine =
        (1 - row.rest) * e.row_cosines[row.index] + row.rest * e.row_cosines[row.index + 1];
    return {direction_at(static_cast<float>(column.index) + column.rest, cosine, e.width),
            texel_pdf(e, row.index, row.probability * column.probability)};
}

Environment environment_sky(Vec3 to_sun) {
    const int width = 1024, height = 512;
    const Vec3 zenith = {0.08f, 0.18f, 0.48f}, horizon = {0.55f, 0.62f, 0.70f};
    const Vec3 glow = {1.0f, 0.72f, 0.42f}, ground = {0.20f, 0.18f, 0.16f};
    const float sun_radius = 0.03f; // radians: ten texels across, enough to look round
    const Vec3 sun_radiance = {700, 590, 430};

    std::vector<Vec3> texels;
    texels.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
    for (int y = 0; y < height; ++y) {
        const float cosine = std::cos(PI * (static_cast<float>(y) + 0.5f) / height);
        for (int x = 0; x < width; ++x) {
            const Vec3 d = direction_at(static_cast<float>(x) + 0.5f, cosine, width);
            const float toward = std::max(dot(d, to_sun), 0.0f);
            const float haze = std::pow(1 - std::abs(d.y), 5.0f);
            Vec3 radiance = haze * horizon + (1 - haze) * (d.y > 0 ? zenith : ground);
            if (d.y > 0) {
                const float angle = std::acos(std::min(toward, 1.0f));
                const float edge = 2 * PI / static_cast<float>(width); // one texel, in radians
                const float disc = std::clamp((sun_radius - angle) / edge + 0.5f, 0.0f, 1.0f);
                radiance += (0.5f * std::pow(toward, 6.0f) + 3 * std::pow(toward, 300.0f)) * glow;
                radiance += disc * sun_radiance;
            }
            texels.push_back(radiance);
        }
    }
    return environment_create(width, height, std::move(texels));
}

Environment environment_read(const std::string &path) {
    if (path == "sky") return environment_sky(normalize(Vec3{-0.40f, 0.62f, 0.68f}));
    if (path == "none") return environment_create(2, 1, {{0, 0, 0}, {0, 0, 0}});
    Image image = exr_read(path);
    try {
        return environment_create(width(image.crop), height(image.crop), std::move(image.rgb));
    } catch (const Error &error) {
        throw Error("the environment ", path, ": ", error.what());
    }
}
