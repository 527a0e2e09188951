// SPDX-License-Identifier: Apache-2.0
// Merging a picture from parts: regions, ranges of samples, or both.
#pragma once

#include <string>
#include <vector>

#include "exr.h"

struct MergedPicture {
    Film film;
    ExrAttributes attributes;
};

// Reads and merges parts that this program wrote with the same settings, and of the same files.
// Where parts overlap they must hold different samples, and each pixel's samples must be
// consecutive, starting at the first sample of all parts. Pixels outside all parts are black and
// have no samples. Holds only the result and one part in memory. Throws Error.
MergedPicture merge_pictures(const std::vector<std::string> &paths);
