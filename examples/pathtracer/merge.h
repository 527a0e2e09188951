// SPDX-License-Identifier: Apache-2.0
// Putting a picture together from parts: regions, ranges of samples, or both.
#pragma once

#include <string>
#include <vector>

#include "exr.h"

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads the parts, which this program wrote with the same settings, and merges them: where they
// overlap they must hold different samples. Pixels that no part holds are black and have no
// samples. What is held in memory is the result and one part. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths);
