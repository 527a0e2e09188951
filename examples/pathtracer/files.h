// SPDX-License-Identifier: Apache-2.0
// Files and messages: errors of one line, reading untrusted files, and which files an image is made
// of. Only regular files are read, as pipes and devices may never end, and of the files that a scene
// names only those below its folder.
#pragma once

#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// Texts and numbers, one after the other.
template <typename... Parts>
std::string joined(const Parts &...parts) {
    return (std::ostringstream() << ... << parts).str();
}

// The shortest text that reads back as the same number.
std::string shortest(double number);

// Thrown when the program cannot continue: one line that says what is wrong and what to do.
struct Error : std::runtime_error {
    template <typename... Parts>
    explicit Error(const Parts &...parts) : runtime_error(joined(parts...)) {}
};

// Replaces line breaks and control characters, which a terminal would obey; the first also shortens.
std::string printable(std::string text);
std::string without_controls(std::string text);

// Prints one line to the standard error, after the name of the program.
void say(const std::string &message);

// Libraries can run out of memory inside noexcept functions: one line and exit code 1, no abort.
void exit_where_it_would_abort();

// The bytes of a file. Throws Error, its text to follow the file's name.
std::vector<unsigned char> read_file(const std::filesystem::path &path);

// Throws Error, its text to follow the name, unless there is a regular file.
void check_regular(const std::filesystem::path &path);

// The files that were read, with what tells their contents apart.
class InputRecord {
  public:
    // Throws Error if the file was read before with other bytes, or has a name that fits no line.
    void add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes);
    void add_file(const std::filesystem::path &path);
    // One line for each file, by name: CRC-32 and size, two blanks, and the name.
    std::string text() const;

    std::map<std::string, std::string> files; // by name
};

// The files of one scene, by the names it uses for them.
class SceneFolder {
  public:
    // With `allow_outside`, files may lie anywhere. `record` gets every file that is read.
    SceneFolder(const std::filesystem::path &scene, bool allow_outside,
                InputRecord *record = nullptr);

    // The path a name leads to, all links followed. Throws Error if it is outside the folder.
    std::filesystem::path resolve(const std::string &name) const;
    bool has(const std::string &name) const { return std::filesystem::exists(resolve(name)); }
    // The bytes of the scene file, and of another one. They throw Error.
    std::vector<unsigned char> read_scene() { return load(scene_, scene_); }
    std::vector<unsigned char> read(const std::string &name);

  private:
    std::vector<unsigned char> load(const std::filesystem::path &path,
                                    const std::filesystem::path &name);

    std::filesystem::path scene_, folder_;
    bool allow_outside_;
    InputRecord *record_;
};

// ---- Writing. A file is written completely or not at all: a temporary file beside it, of a random name
// and created exclusively, is renamed once it is on the disk.

// Throws Error unless a file can be written under that name. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes all the files once all of them are on the disk. Symbolic links stay links. Throws Error.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string>> &files);

// Whether two names lead to the same file, or would if files were created under both.
bool is_same_file(const std::filesystem::path &one, const std::filesystem::path &other);
