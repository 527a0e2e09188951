// SPDX-License-Identifier: Apache-2.0
// Environment light: a latitude-longitude image of the whole sphere of directions.
#pragma once

#include <string>
#include <vector>

#include "math.h"

// Row 0 is straight up (+y), the middle of a row is +z and its left is +x, as in OpenEXR's
// latitude-longitude maps. Radiance is constant over each texel.
struct Environment {
    int width, height;
    std::vector<Vec3> texels; // radiance, row by row
    // For sampling: the limits between rows, and between the columns of each row.
    std::vector<float> row_limits;    // height + 1
    std::vector<float> column_limits; // height rows of width + 1
    std::vector<float> row_cosines;   // height + 1: of the angle to +y, from 1 to -1
    float irradiance; // luminance above the mean, integrated over the sphere. 0: too
                      // uniform to be worth sampling
};

// Makes an environment from its texels; negative values become 0. Throws Error if a texel is not
// finite.
Environment environment_create(int width, int height, std::vector<Vec3> texels);

// A clear sky with a sun, wider than the real one, and ground below.
Environment environment_sky(Vec3 to_sun);

// Reads a latitude-longitude EXR file. Two names are special: "sky" is environment_sky, "none" is
// black. Throws Error.
Environment environment_read(const std::string &path);

Vec3 environment_radiance(const Environment &environment, Vec3 direction);

// The density per steradian with which environment_sample chooses a direction. It is constant over
// each texel and 0 on texels darker than the mean, so combine it with scattered rays.
float environment_pdf(const Environment &environment, Vec3 direction);

struct EnvironmentSample {
    Vec3 direction;
    float pdf; // per steradian
};

EnvironmentSample environment_sample(const Environment &environment, Vec2 u);
