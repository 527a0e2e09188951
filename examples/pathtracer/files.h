// SPDX-License-Identifier: Apache-2.0
// Files and messages: errors of one line, reading untrusted files, and which files a picture is made
// of. Only regular files are read, as pipes and devices may never end, and of the files that a scene
// names only those below its folder.
#pragma once

#include <filesystem>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// Thrown when the program cannot continue: one line that says what is wrong and what to do.
struct Error : std::runtime_error {
    // Of texts and whole numbers, one after the other.
    template <typename... Parts>
    explicit Error(const Parts &...parts)
        : runtime_error((std::ostringstream() << ... << parts).str()) {}
};

// Makes text from a file safe to print in a message: shortens it and replaces line breaks and
// control characters. The second does not shorten it, for names of files and for whole messages.
std::string printable(std::string text);
std::string without_controls(std::string text);

// Prints one line to the standard error, after the name of the program.
void say(const std::string &message);

// Makes the program print one line and exit with code 1 instead of aborting: the libraries that
// read files can run out of memory inside noexcept functions.
void exit_where_it_would_abort();

// The bytes of a file. Throws Error, its text to follow the file's name.
std::vector<unsigned char> read_file(const std::filesystem::path &path);

// Throws Error, its text to follow the name, unless there is a regular file.
void check_regular(const std::filesystem::path &path);

// The files that were read, with what tells their contents apart: for --list-inputs, and to refuse to
// mix pictures of different files.
class InputRecord {
  public:
    // Throws Error if the file was read before with other bytes.
    void add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes);
    // Reads the file. Throws Error, with the file's name.
    void add_file(const std::filesystem::path &path);
    // One line for each file, by name: CRC-32 and size, two blanks, and the name, in which backslashes,
    // control characters and what is no UTF-8 are escapes.
    std::string text() const;

    std::map<std::string, std::string> files; // by name
};

// How two such texts differ, such as "the contents of wood.png"; empty if they do not.
std::string inputs_difference(const std::string &one, const std::string &other);

// The files of one scene, by the names it uses for them.
class SceneFolder {
  public:
    // `scene` is the path of the scene file. With `allow_outside`, its files may lie anywhere.
    // `record` gets every file that is read, and may be null.
    SceneFolder(const std::filesystem::path &scene, bool allow_outside,
                InputRecord *record = nullptr);

    // The path a name leads to, all links followed, whether or not a file is there. Throws Error if
    // it is outside the folder.
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

// ---- Writing. A file is written completely or not at all: it goes to a temporary file in the same
// folder, of a random name and created exclusively, so that nobody with write access to the folder can
// make this program follow a link of theirs, and is renamed once it is on the disk.

// Throws Error unless a file can be written under that name. Leaves nothing behind.
void check_writable(const std::filesystem::path &path);

// Writes all the files, replacing any of the same names, once all of them are on the disk. Symbolic
// links stay links; the files they point to are replaced. Throws Error.
void write_files(const std::vector<std::pair<std::filesystem::path, std::string>> &files);

// Whether two names lead to the same file, or would if files were created under both.
bool is_same_file(const std::filesystem::path &one, const std::filesystem::path &other);
