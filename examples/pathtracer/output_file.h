// SPDX-License-Identifier: Apache-2.0
// Files that are there whole or not at all: written beside their name and renamed when complete.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// Throws Error unless a file could be written under that name. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes all the files, then renames all of them. When one fails, throws Error and leaves no trace
// of any; a file that had that name before is still there.
void write_files(const std::vector<std::pair<std::filesystem::path, std::vector<char>>> &files);
