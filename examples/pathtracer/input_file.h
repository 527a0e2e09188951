// SPDX-License-Identifier: Apache-2.0
// Reads untrusted files: only regular ones, as pipes and devices may never end, and of the files a
// scene names, only those below its folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

// The bytes of a file. Throws Error, its text to follow the file's name.
std::vector<unsigned char> read_file(const std::filesystem::path &path);

// Throws Error, its text to follow the name, unless there is a regular file.
void check_regular(const std::filesystem::path &path);

// ---- Which files a picture is made of, and what was in them: for --list-inputs, and to refuse to mix
// pictures of different files

// A file, and the option that names it.
struct NamedFile {
    std::string role;
    std::filesystem::path path;
};

class InputRecord {
  public:
    // A file that was read. Throws Error if it was read before with other bytes.
    void add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes);
    // Reads the file. Throws Error, with the file's name.
    void add_file(const std::filesystem::path &path);

    // One line for each file, by name, as sha256sum prints and checks them.
    std::string text() const;

    // The files, as what `role` reads.
    std::vector<NamedFile> files(const std::string &role) const;

  private:
    std::map<std::string, std::string> hashes_; // of each file
};

// How two such texts differ, such as "the contents of wood.png"; empty if they do not.
std::string inputs_difference(const std::string &one, const std::string &other);

// ---- The folder of a scene

// The files of one scene, by the names it uses for them.
class SceneFolder {
  public:
    // `scene` is the path of the scene file. With `allow_outside`, its files may lie anywhere.
    // `record` gets every file that is read, and may be null.
    SceneFolder(const std::filesystem::path &scene, bool allow_outside,
                InputRecord *record = nullptr);

    // The bytes of the scene file. Throws Error.
    std::vector<unsigned char> read_scene() { return load(scene_, scene_); }

    // The path a name leads to, all links followed, whether or not a file is there. Throws Error if
    // it is outside the folder.
    std::filesystem::path resolve(const std::string &name) const;
    // Whether there is such a file. Throws Error if it is outside the folder.
    bool has(const std::string &name) const { return std::filesystem::exists(resolve(name)); }
    // The bytes of a file. Throws Error.
    std::vector<unsigned char> read(const std::string &name);

  private:
    // Reads a file, which has this name in the record.
    std::vector<unsigned char> load(const std::filesystem::path &path,
                                    const std::filesystem::path &name);
    // As the scene's own path is written.
    std::filesystem::path listed(const std::filesystem::path &path) const {
        return scene_.parent_path() / path.lexically_relative(folder_);
    }

    std::filesystem::path scene_, folder_;
    bool allow_outside_;
    InputRecord *record_;
};
