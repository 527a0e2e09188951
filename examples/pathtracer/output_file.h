// SPDX-License-Identifier: Apache-2.0
// Writes files completely or not at all: each goes to a temporary file in the same folder, which is
// renamed when complete.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// Throws Error unless a file can be written under that name. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes all the files, replacing any of the same names, once all of them are on the disk. Symbolic
// links stay links; the files they point to are replaced. Throws Error.
void write_files(const std::vector<std::pair<std::filesystem::path, std::vector<char>>> &files);

// Ends the program by a signal, without leaving temporary files behind: a signal handler.
void end_without_temporary_files(int signal);

// Does so for SIGINT, SIGTERM and SIGHUP, except those that are ignored.
void remove_temporary_files_when_killed();

// Whether two names lead to the same file, through symbolic or hard links too. Files that do not
// exist yet are the same if creating both would create one.
bool is_same_file(const std::filesystem::path &a, const std::filesystem::path &b);
