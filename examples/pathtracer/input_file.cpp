// SPDX-License-Identifier: Apache-2.0
#include "input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "error.h"
#include "input_record.h"

namespace fs = std::filesystem;

namespace {

constexpr uint64_t MAX_FILE = uint64_t{1} << 32; // bytes, of all files of a scene together

// Whether a path lies below a folder. Both must be canonical.
bool is_below(const fs::path &path, const fs::path &folder) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return end == folder.end() && rest != path.end();
}

} // namespace

InputFile::InputFile(const fs::path &path) {
    // Without O_NONBLOCK, opening a pipe would wait for a writer.
    descriptor_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0 && (errno == ENOENT || errno == ENOTDIR))
        throw Error("there is no such file");
    if (descriptor_ < 0) throw Error(std::string("cannot be opened: ") + std::strerror(errno));
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(descriptor_);
        throw Error("is not a regular file");
    }
    size_ = static_cast<uint64_t>(status.st_size);
}

InputFile::~InputFile() {
    ::close(descriptor_);
}

size_t InputFile::read(uint64_t place, void *bytes, size_t count) const {
    size_t done = 0;
    while (done < count) {
        const ssize_t got = ::pread(descriptor_, static_cast<char *>(bytes) + done, count - done,
                                    static_cast<off_t>(place + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw Error(std::string("cannot be read: ") + std::strerror(errno));
        if (got == 0) break;
        done += static_cast<size_t>(got);
    }
    return done;
}

std::vector<unsigned char> read_file(const fs::path &path) {
    const InputFile file(path);
    if (file.size() >= MAX_FILE) throw Error("is too large: files below 4 GiB are read");
    std::vector<unsigned char> bytes(file.size());
    if (file.read(0, bytes.data(), bytes.size()) != bytes.size())
        throw Error("cannot be read completely");
    return bytes;
}

SceneFolder::SceneFolder(const fs::path &scene, bool allow_outside, InputRecord *record)
    : scene_(scene), allow_outside_(allow_outside), record_(record) {
    std::error_code error;
    const fs::path folder = scene.parent_path();
    folder_ = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
    if (error) throw Error("there is no such file");
}

fs::path SceneFolder::resolve(const std::string &name) const {
    // The system would read the name only up to there, while the checks below see all of it.
    if (name.find('\0') != std::string::npos) throw Error("has a zero byte in its name");
    std::error_code error;
    // Follows links in the part of the path that exists and normalises the rest.
    const fs::path path = fs::weakly_canonical(folder_ / name, error);
    if (error) throw Error("cannot be opened: " + error.message());
    if (!allow_outside_ && !is_below(path, folder_))
        throw Error("is outside the scene's folder; use --allow-outside to read it");
    return path;
}

fs::path SceneFolder::listed(const fs::path &path) const {
    return scene_.parent_path() / path.lexically_relative(folder_);
}

std::vector<unsigned char> SceneFolder::read_scene() {
    std::vector<unsigned char> bytes = read_file(scene_);
    if (record_) record_->add(scene_, bytes);
    return bytes;
}

std::optional<std::vector<unsigned char>> SceneFolder::find(const std::string &name) {
    const fs::path path = resolve(name);
    std::error_code error;
    if (fs::exists(path, error)) return load(path);
    // Once it is there, it will be read.
    if (record_) record_->add_missing(listed(path));
    return {};
}

std::vector<unsigned char> SceneFolder::load(const fs::path &path) {
    std::vector<unsigned char> bytes = read_file(path);
    if (record_) record_->add(listed(path), bytes);
    if (known_.insert(path).second) size_ += bytes.size();
    bytes_read_ += bytes.size();
    if (bytes_read_ >= MAX_FILE) throw Error("is too much: a scene reads at most 4 GiB of files");
    return bytes;
}

std::vector<unsigned char> SceneFolder::read(const std::string &name) {
    return load(resolve(name));
}
