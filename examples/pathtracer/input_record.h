// SPDX-License-Identifier: Apache-2.0
// Which files a picture is made of, and what was in them: for --list-inputs, and to refuse to mix
// pictures of different files.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

// A file, and the option that names it.
struct NamedFile {
    std::string role;
    std::filesystem::path path;
};

// Those of a scene, an environment and a mask, as options and pictures name them, that are files.
std::vector<NamedFile> named_files(const std::string &scene, const std::string &environment,
                                   const std::string &mask);

class InputRecord {
  public:
    // A file that was read. Throws Error if it was read before with other bytes.
    void add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes);
    // Reads the file, in pieces. Throws Error, with the file's name.
    void add_file(const std::filesystem::path &path);
    // A file that was looked for and is not there.
    void add_missing(const std::filesystem::path &path);

    // One line for each file, by name, as sha256sum prints and checks them; files that are not there
    // stand in comments.
    std::string text() const;

    // The files, as what `role` reads.
    std::vector<NamedFile> files(const std::string &role) const;

  private:
    void add_hash(const std::filesystem::path &path, const std::string &hash);

    std::map<std::string, std::string> hashes_; // empty: not there
};

// How two such texts differ, such as "the contents of wood.png"; empty if they do not.
std::string inputs_difference(const std::string &one, const std::string &other);
