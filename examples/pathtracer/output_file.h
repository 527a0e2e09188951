// SPDX-License-Identifier: Apache-2.0
// Writing files so that each is there complete or not at all: they are written to a temporary file
// in the same folder and renamed when complete.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// Throws Error unless a file could be written under that name. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes all the files and replaces those that had their names before. Symbolic links stay links:
// the files they point to are replaced. When anything fails, throws Error and leaves nothing new; the
// old files are still there, all of them (on file systems without hard links, only those whose
// renaming failed).
void write_files(const std::vector<std::pair<std::filesystem::path, std::vector<char>>> &files);

// Whether two names lead to the same file, through symbolic and hard links too. Files that do not
// exist yet are the same when creating both would create one.
bool is_same_file(const std::filesystem::path &a, const std::filesystem::path &b);
