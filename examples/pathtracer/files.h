// SPDX-License-Identifier: Apache-2.0
// Files and messages: one-line errors, reading untrusted files, and a record of the files that an image
// depends on. Only regular files are read, because pipes and devices may never end. A scene can name
// only files below its own folder.
#pragma once

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
std::string shortest(double number);

// Thrown when the program cannot continue. The message is one line: what is wrong and what to do.
struct Error : std::runtime_error {
    template <typename... Parts>
    explicit Error(const Parts &...parts) : runtime_error(joined(parts...)) {}
};

// Replace line breaks and control characters, which a terminal would obey. The first also shortens.
std::string printable(std::string text);
std::string without_controls(std::string text);

// Prints one line to standard error, after the program's name.
void say(const std::string &message);

// If memory runs out inside a library's noexcept function, prints one line and exits with code 1.
void exit_where_it_would_abort();

// The bytes of a file. Throws Error with a message that continues the file's name.
std::vector<unsigned char> read_file(const std::filesystem::path &path);

// Throws Error, with a message that continues the name, unless it is a regular file.
void check_regular(const std::filesystem::path &path);

// The files that were read, with checksums of their contents.
class InputRecord {
  public:
    // Throws Error if the file was read before with other contents, or its name does not fit on a line.
    void add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes);
    void add_file(const std::filesystem::path &path);
    // One line per file, sorted by name: CRC-32, size, two spaces and the name.
    std::string text() const;

    std::map<std::string, std::string> files; // by name
};

// The files of one scene, by the names that the scene uses.
class SceneFolder {
  public:
    // With `allow_outside`, files may be anywhere. `record` receives every file that is read.
    SceneFolder(const std::filesystem::path &scene, bool allow_outside,
                InputRecord *record = nullptr);

    // The path of a name, with all links resolved. Throws Error if it is outside the folder.
    std::filesystem::path resolve(const std::string &name) const;
    bool has(const std::string &name) const { return std::filesystem::exists(resolve(name)); }
    // The bytes of the scene file, and of another file. Throw Error.
    std::vector<unsigned char> read_scene() const { return load(scene_, scene_); }
    std::vector<unsigned char> read(const std::string &name) const;

  private:
    std::vector<unsigned char> load(const std::filesystem::path &path,
                                    const std::filesystem::path &name) const;

    std::filesystem::path scene_, folder_;
    bool allow_outside_;
    InputRecord *record_;
};

// ---- Writing. A file is written completely or not at all: a temporary file with a random name is
// created beside it, and renamed once it is on disk.

// Throws Error unless a file with that name can be written. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes files, and renames them once all are on disk. Symbolic links stay links. Throws Error.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string>> &files);

// Whether two names refer to the same file, or would if both files were created.
bool is_same_file(const std::filesystem::path &one, const std::filesystem::path &other);
