// SPDX-License-Identifier: Apache-2.0
// Reading files that others made: regular ones only, as pipes and devices may never end, and of
// those that a scene names only the ones below its folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

// The bytes of a file. Throws Error, its text to follow the file's name.
std::vector<unsigned char> read_file(const std::filesystem::path &path);

// A file that is read in part.
class InputFile {
  public:
    // Throws Error, its text to follow the file's name.
    explicit InputFile(const std::filesystem::path &path);
    ~InputFile();
    InputFile(const InputFile &) = delete;
    InputFile &operator=(const InputFile &) = delete;

    uint64_t size() const { return size_; }
    // Up to `count` bytes from a place on; returns how many there were. Throws Error.
    size_t read(uint64_t place, void *bytes, size_t count) const;

  private:
    int descriptor_;
    uint64_t size_;
};

// The files of one scene, by the names it has for them.
class SceneFolder {
  public:
    // Of the scene in that file. With `allow_outside` its files may lie anywhere.
    SceneFolder(const std::filesystem::path &scene, bool allow_outside);

    // Where a name leads, all links followed, whether or not a file is there. Throws Error when that
    // is outside of the folder.
    std::filesystem::path resolve(const std::string &name) const;
    // The bytes of a file, or nothing where there is none. Throws Error.
    std::optional<std::vector<unsigned char>> find(const std::string &name);
    // The same, and an Error where there is none.
    std::vector<unsigned char> read(const std::string &name);

    // Of all files that were read, each counted once.
    uint64_t size() const { return size_; }

  private:
    std::filesystem::path folder_;
    bool allow_outside_;
    std::set<std::filesystem::path> known_;
    uint64_t size_ = 0, bytes_read_ = 0; // of each file once, and whenever it is read
};
