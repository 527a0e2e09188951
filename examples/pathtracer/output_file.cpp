// SPDX-License-Identifier: Apache-2.0
// Files that are there whole or not at all.
#include "output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include "error.h"

namespace fs = std::filesystem;

namespace {

// The file a name stands for: a link keeps pointing at it.
fs::path resolve(fs::path path) {
    std::error_code ignored;
    for (int links = 0; links < 40 && fs::is_symlink(path, ignored); ++links) {
        const fs::path target = fs::read_symlink(path, ignored);
        path = target.is_absolute() ? target : path.parent_path() / target;
    }
    return path;
}

fs::path beside(const fs::path &path) {
    fs::path result = path;
    result += ".part-" + std::to_string(getpid());
    return result;
}

Error cannot_write(const fs::path &path, const std::string &why) {
    return Error("cannot write " + path.string() + ": " + why);
}

// Creates or overwrites `part` on the way to `path`.
void write_whole(const fs::path &part, const fs::path &path, const std::vector<char> &bytes) {
    errno = 0;
    std::FILE *file = std::fopen(part.string().c_str(), "wb");
    if (!file) throw cannot_write(path, std::strerror(errno));
    bool good = bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    good = std::fflush(file) == 0 && good;
    const int write_error = errno;
    good = std::fclose(file) == 0 && good;
    if (!good) {
        const int error = write_error ? write_error : errno;
        std::error_code ignored;
        fs::remove(part, ignored);
        throw cannot_write(path, std::strerror(error));
    }
}

} // namespace

void check_writable(const fs::path &path) {
    const fs::path target = resolve(path);
    std::error_code ignored;
    const fs::file_status status = fs::status(target, ignored);
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw cannot_write(path, "it is there and is no regular file");
    write_whole(beside(target), path, {});
    fs::remove(beside(target), ignored);
}

void write_files(const std::vector<std::pair<fs::path, std::vector<char>>> &files) {
    size_t written = 0;
    std::error_code error;
    try {
        for (; written < files.size(); ++written) {
            const fs::path &path = files[written].first;
            write_whole(beside(resolve(path)), path, files[written].second);
        }
        for (const auto &file : files) {
            fs::rename(beside(resolve(file.first)), resolve(file.first), error);
            if (error) throw cannot_write(file.first, error.message());
        }
    } catch (const Error &) {
        for (size_t i = 0; i < written; ++i) fs::remove(beside(resolve(files[i].first)), error);
        throw;
    }
}
