// SPDX-License-Identifier: Apache-2.0
// Putting a picture together from parts: regions, ranges of samples, or both.
#pragma once

#include <string>
#include <vector>

#include "exr.h"

// The first difference between the settings of two pictures, such as "seed '1' and '2'"; empty if
// they can be parts of one picture. Regions and samples are not compared.
std::string settings_difference(const ExrHead &one, const ExrHead &other);

// Adds the rendering cost of a part.
void add_cost(ExrAttributes &to, const ExrAttributes &part);

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads parts that this program wrote with the same settings, and merges them. Where they overlap
// they must hold different samples, and the samples of each pixel must follow each other without
// gaps, from the first sample of all parts. Pixels outside all parts are black and have no samples.
// Holds the result and one part in memory. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths);
