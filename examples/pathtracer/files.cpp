// SPDX-License-Identifier: Apache-2.0
// A file is written beside the old one, flushed to the disk, and renamed, so an interrupted run leaves
// either the old file or the new one.
#include "files.h"

#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <list>
#include <random>

namespace fs = std::filesystem;

namespace {

Error cannot_write(const fs::path &path, const std::string &why) {
    return Error("cannot write ", path.string(), ": ", why);
}

// The target of a path's symbolic links, whether or not a file exists there.
fs::path resolve(const fs::path &path) {
    std::error_code error;
    const bool dangles =
        fs::is_symlink(fs::symlink_status(path, error)) && !fs::exists(path, error);
    const fs::path target = dangles ? path.parent_path() / fs::read_symlink(path, error) : path;
    const fs::path result = fs::weakly_canonical(target, error);
    if (error) throw cannot_write(path, error.message());
    return result;
}

class TemporaryFile {
  public:
    explicit TemporaryFile(const fs::path &path)
        : path_(path), target_(resolve(path)), name_(target_) {
        std::random_device random;
        char suffix[32];
        std::snprintf(suffix, sizeof suffix, ".part-%08x%08x", random(), random());
        name_ += suffix;
        file_ = std::fopen(name_.c_str(), "wxe"); // exclusively; child processes do not inherit it
        check(file_ != nullptr);
    }
    TemporaryFile(const TemporaryFile &) = delete;
    ~TemporaryFile() {
        if (file_) std::fclose(file_);
        if (!renamed_) unlink(name_.c_str());
    }

    void write(const std::string &bytes) {
        check(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size() &&
              std::fflush(file_) == 0 && fsync(fileno(file_)) == 0);
    }

    void rename() {
        check(std::rename(name_.c_str(), target_.c_str()) == 0);
        renamed_ = true;
    }

  private:
    void check(bool good) const {
        if (!good) throw cannot_write(path_, std::strerror(errno));
    }

    fs::path path_, target_, name_;
    std::FILE *file_;
    bool renamed_ = false;
};

} // namespace

std::string without_controls(std::string text) {
    for (char &c : text)
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
    return text;
}

void say(const std::string &message) {
    std::fprintf(stderr, "pathtracer: %s\n", without_controls(message).c_str());
}

int run_or_say(int (*run)(int, char **), int argc, char **argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception &error) {
        say(error.what());
        return 1;
    }
}

void check_regular(const fs::path &path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) throw Error("there is no such file");
    if (error) throw Error("cannot be opened: ", error.message());
    if (!fs::is_regular_file(status)) throw Error("is not a regular file");
}

std::vector<unsigned char> InputRecord::read(const fs::path &path) {
    check_regular(path);
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw Error("cannot be opened: ", std::strerror(errno));
    std::vector<unsigned char> bytes(size_t(file.tellg()));
    file.seekg(0);
    if (!file.read(reinterpret_cast<char *>(bytes.data()), std::streamsize(bytes.size())))
        throw Error("cannot be read completely");
    char hash[32];
    std::snprintf(hash, sizeof hash, "%08lx-%zu", crc32_z(0, bytes.data(), bytes.size()),
                  bytes.size());
    const auto [known, is_new] = files.try_emplace(path.string(), hash);
    if (!is_new && known->second != hash) throw Error("has changed while it was read; try again");
    return bytes;
}

std::string InputRecord::text() const {
    std::string result;
    for (const auto &[name, hash] : files) result += hash + "  " + without_controls(name) + "\n";
    return result;
}

void check_writable(const fs::path &path) {
    std::error_code none;
    if (fs::exists(path, none) && !fs::is_regular_file(path, none))
        throw cannot_write(path, "it exists and is not a regular file");
    const TemporaryFile probe(path);
}

void write_files(const std::vector<std::pair<fs::path, std::string>> &files) {
    std::list<TemporaryFile> parts;
    for (const auto &[path, bytes] : files) parts.emplace_back(path).write(bytes);
    for (TemporaryFile &part : parts) part.rename();
}

bool is_same_file(const fs::path &one, const fs::path &other) {
    std::error_code none;
    if (fs::exists(one, none) && fs::exists(other, none)) return fs::equivalent(one, other, none);
    return resolve(one) == resolve(other);
}
