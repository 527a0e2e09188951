// SPDX-License-Identifier: Apache-2.0
// Putting a picture together from parts: regions, ranges of samples, or both.
#pragma once

#include <string>
#include <vector>

#include "exr.h"

// How the settings of two pictures differ, with the first one's first: "seed '1' and '2'"; empty
// when they are parts of one picture. Of regions and samples nothing is said.
std::string settings_difference(const ExrHead &one, const ExrHead &other);

// Adds what it cost to render a part to the cost of another.
void add_cost(ExrAttributes &to, const ExrAttributes &part);

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads the parts, which this program wrote with the same settings, and merges them: where they
// overlap they must hold different samples, and in each pixel these must follow each other without
// a gap, from the first sample of all. Pixels that no part holds are black and have no samples.
// What is held in memory is the result and one part. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths);
