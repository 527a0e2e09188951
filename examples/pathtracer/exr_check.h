// SPDX-License-Identifier: Apache-2.0
// Whether an OpenEXR file can be what its header says.
#pragma once

#include <string>

// Throws Error, its text to follow the file's name, for what is no regular file, and for a header
// that asks for far more memory than a file of that size can fill.
void exr_check(const std::string &path);
