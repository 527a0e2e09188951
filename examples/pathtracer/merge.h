// SPDX-License-Identifier: Apache-2.0
// Merging a picture from parts: regions, ranges of samples, or both.
#pragma once

#include <string>
#include <vector>

#include "exr.h"

// The first difference between the settings of two pictures, or between the files they are made of
// unless `allow_changed`, such as "seed '1' and '2'"; empty if they can be parts of one picture.
// Regions and sample ranges are not compared.
std::string settings_difference(const ExrHead &one, const ExrHead &other, bool allow_changed);

// Adds the rendering cost of a part to a picture that does not list its files any more if the part
// is made of other ones.
void add_part(ExrAttributes &to, const ExrAttributes &part);

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads and merges parts that this program wrote with the same settings, and of the same files
// unless `allow_changed`. Where parts overlap they must hold different samples, and each pixel's
// samples must be consecutive, starting at the first sample of all parts. Pixels outside all parts
// are black and have no samples. Holds only the result and one part in memory. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths, bool allow_changed);
