// SPDX-License-Identifier: Apache-2.0
// Checks that an OpenEXR file can hold what its header claims.
#pragma once

#include <string>

// Throws Error, its text to follow the file's name, if the file is not a regular file, or if its
// header asks for far more memory than a file of that size can fill.
void exr_check(const std::string &path);
