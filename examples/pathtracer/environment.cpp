// SPDX-License-Identifier: Apache-2.0
// The environment is sampled by the light of its texels: first the row, then the column in it, both
// by inversion, then evenly over the texel's solid angle. Weights are the light of the interpolated
// picture over the texel, not of the texel alone: a dark texel beside the sun is partly bright.
// From each the mean is taken off: scattered rays find what is as bright as most of the sky well
// enough, and multiple importance sampling counts both (Karlik et al., "MIS Compensation:
// Optimizing Sampling Techniques in Multiple Importance Sampling", 2019). An even sky is left to
// scattered rays alone.
#include "environment.h"

#include <cmath>

#include "distribution.h"
#include "error.h"
#include "exr.h"

namespace {

// The least share of the light that must stand out from the mean for the environment to be sampled.
constexpr double LEAST_CONTRAST = 0.02;

struct Location {
    float x, y; // in texels: column and row
};

Location locate(const Environment &e, Vec3 d) {
    const float longitude = std::atan2(d.x, d.z);
    const float from_top = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
    return {(0.5f - longitude / (2 * PI)) * static_cast<float>(e.width),
            from_top / PI * static_cast<float>(e.height)};
}

Vec3 direction_at(float column, float cosine, int width) {
    const float longitude = (0.5f - column / static_cast<float>(width)) * 2 * PI;
    const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    return {sine * std::sin(longitude), cosine, sine * std::cos(longitude)};
}

// Columns go round; beyond the first and the last row lies the row itself again.
const Vec3 &texel(const Environment &e, int x, int y) {
    const int column = x < 0 ? x + e.width : x >= e.width ? x - e.width : x;
    const int row = std::clamp(y, 0, e.height - 1);
    return e.texels[static_cast<size_t>(row) * static_cast<size_t>(e.width) +
                    static_cast<size_t>(column)];
}

// The luminance of the interpolated picture, averaged over a texel.
double texel_light(const Environment &e, int x, int y) {
    static const double weights[3] = {0.125, 0.75, 0.125};
    double sum = 0;
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
            sum += weights[i + 1] * weights[j + 1] *
                   static_cast<double>(luminance(texel(e, x + i, y + j)));
    return sum;
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
        if (!is_finite(v)) throw Error("an environment must be of finite numbers, and one is not");
        v = {std::max(0.0f, v.x), std::max(0.0f, v.y), std::max(0.0f, v.z)};
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
            weights[y * w + x] = texel_light(e, static_cast<int>(x), static_cast<int>(y));
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
    const Location at = locate(e, direction);
    const float x = at.x - 0.5f, y = at.y - 0.5f;
    const float x0 = std::floor(x), y0 = std::floor(y);
    const float s = x - x0, t = y - y0;
    const int column = static_cast<int>(x0), row = static_cast<int>(y0);
    const Vec3 top = (1 - s) * texel(e, column, row) + s * texel(e, column + 1, row);
    const Vec3 bottom = (1 - s) * texel(e, column, row + 1) + s * texel(e, column + 1, row + 1);
    return (1 - t) * top + t * bottom;
}

float environment_pdf(const Environment &e, Vec3 direction) {
    const Location at = locate(e, direction);
    const auto w = static_cast<size_t>(e.width);
    const size_t column = std::min(static_cast<size_t>(std::max(at.x, 0.0f)), w - 1);
    const size_t row = std::min(static_cast<size_t>(at.y), static_cast<size_t>(e.height) - 1);
    const float *columns = &e.column_limits[row * (w + 1)];
    return texel_pdf(e, row,
                     (e.row_limits[row + 1] - e.row_limits[row]) *
                         (columns[column + 1] - columns[column]));
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
    const int width = 512, height = 256;
    const Vec3 zenith = {0.08f, 0.18f, 0.48f}, horizon = {0.55f, 0.62f, 0.70f};
    const Vec3 glow = {1.0f, 0.72f, 0.42f}, ground = {0.20f, 0.18f, 0.16f};
    const float sun_radius = 0.03f; // radians: seven texels across, so that it looks round
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
                const float edge = 2 * PI / static_cast<float>(width); // a texel's
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
    const Image image = exr_read(path);
    const int width = ::width(image.crop), height = ::height(image.crop);
    std::vector<Vec3> texels(pixel_count(image.crop));
    for (size_t i = 0; i < texels.size(); ++i)
        texels[i] = {image.rgb[3 * i], image.rgb[3 * i + 1], image.rgb[3 * i + 2]};
    try {
        return environment_create(width, height, std::move(texels));
    } catch (const Error &error) {
        throw Error("the environment " + path + ": " + error.what());
    }
}
