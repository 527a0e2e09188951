// SPDX-License-Identifier: Apache-2.0
// Files and messages: one-line errors, reading untrusted files, and a record of the files an image
// depends on. Only regular files are read, because pipes and devices may never end.
#pragma once

#include <charconv>
#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// Concatenates strings and numbers.
template <typename... Parts>
std::string joined(const Parts &...parts) {
    return (std::ostringstream() << ... << parts).str();
}

// The shortest string that reads back as the same number.
template <typename Number>
std::string shortest(Number number) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

// Thrown when the program cannot continue. The message is one line: what is wrong and what to do.
struct Error : std::runtime_error {
    template <typename... Parts>
    explicit Error(const Parts &...parts) : runtime_error(joined(parts...)) {}
};

// Runs a function and puts a name before the message of its Error.
template <typename Function>
auto named(const std::string &name, Function function) {
    try {
        return function();
    } catch (const Error &error) {
        throw Error(name, ": ", error.what());
    }
}

// Replaces line breaks and control characters, which a terminal would obey.
std::string without_controls(std::string text);

// Prints one line to standard error, after the program's name.
void say(const std::string &message);
// Returns what `run` returns, or 1 after saying what it throws.
int run_or_say(int (*run)(int, char **), int argc, char **argv);

// Throws Error unless it is a regular file. The message continues the file's name.
void check_regular(const std::filesystem::path &path);

// The files that were read, with checksums of their contents.
struct InputRecord {
    std::map<std::string, std::string> files = {}; // by name

    // The bytes of a file. Throws Error, also if the file was read before with other contents. The message
    // continues the file's name.
    std::vector<unsigned char> read(const std::filesystem::path &path);
    // One line per file, sorted by name: CRC-32, size, two spaces and the name.
    std::string text() const;
};

// ---- Writing. A file is written completely or not at all: a temporary file with a random name is
// created beside it, and renamed once it is on disk.

// Throws Error unless a file with that name can be written. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes files, and renames them once all are on disk. Symbolic links stay links. Throws Error.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string>> &files);

// Whether two names refer to the same file, or would if both files were created.
bool is_same_file(const std::filesystem::path &one, const std::filesystem::path &other);
