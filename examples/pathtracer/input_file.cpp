// SPDX-License-Identifier: Apache-2.0
#include "input_file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <sstream>

#include "error.h"
#include "scene_file.h"

namespace fs = std::filesystem;

namespace {

constexpr uint64_t MAX_FILE = uint64_t{1} << 32; // bytes, of all files of a scene together

// Whether a path lies below a folder. Both must be canonical.
bool is_below(const fs::path &path, const fs::path &folder) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return end == folder.end() && rest != path.end();
}

constexpr const char *MISSING = "# missing: ";

class Sha256 {
  public:
    Sha256() { check(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr)); }
    void add(const void *bytes, size_t count) {
        check(EVP_DigestUpdate(context_.get(), bytes, count));
    }
    // Of all bytes, in hexadecimal. Call it once, last.
    std::string hex() {
        unsigned char digest[32];
        check(EVP_DigestFinal_ex(context_.get(), digest, nullptr));
        std::string text;
        for (const unsigned char byte : digest) {
            text += "0123456789abcdef"[byte >> 4];
            text += "0123456789abcdef"[byte & 15];
        }
        return text;
    }

  private:
    static void check(int good) {
        if (!good) throw std::bad_alloc();
    }

    std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX *)> context_{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

bool is_utf8(const std::string &text) {
    constexpr uint32_t LEAST[4] = {0, 0x80, 0x800, 0x10000}; // of so many further bytes
    for (size_t i = 0; i < text.size();) {
        const auto first = static_cast<unsigned char>(text[i++]);
        const uint32_t further = first < 0x80 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
        if ((first >= 0x80 && first < 0xc0) || first >= 0xf8) return false;
        uint32_t code = further == 0 ? first : first & (0x3fu >> further);
        for (uint32_t k = 0; k < further; ++k, ++i) {
            if (i == text.size() || (text[i] & 0xc0) != 0x80) return false;
            code = code << 6 | (text[i] & 0x3fu);
        }
        if (code < LEAST[further] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
            return false;
    }
    return true;
}

// Backslashes, control characters and what is no UTF-8, which readers of EXR attributes refuse, as
// escapes: those of sha256sum where it has any.
std::string escaped(const std::string &name) {
    const std::string clean = without_controls(name);
    const bool plain = is_utf8(name);
    std::string result;
    for (size_t i = 0; i < name.size(); ++i) {
        char code[8];
        if (name[i] == '\\') {
            result += "\\\\";
        } else if (name[i] == '\n' || name[i] == '\r') {
            result += name[i] == '\n' ? "\\n" : "\\r";
        } else if (clean[i] != name[i] || (!plain && (name[i] & 0x80) != 0)) {
            std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned char>(name[i]));
            result += code;
        } else {
            result += name[i];
        }
    }
    return result;
}

// The names of a text, each with what tells its contents.
std::map<std::string, std::string> parsed(const std::string &text) {
    std::map<std::string, std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        const size_t blank = line.rfind(MISSING, 0) == 0 ? line.find(": ") : line.find("  ");
        if (blank != std::string::npos) lines[line.substr(blank + 2)] = line.substr(0, blank);
    }
    return lines;
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

std::vector<NamedFile> named_files(const std::string &scene, const std::string &environment,
                                   const std::string &mask) {
    std::vector<NamedFile> files;
    if (is_scene_file(scene)) files.push_back({"--scene", scene});
    if (!environment.empty() && environment != "sky" && environment != "none")
        files.push_back({"--env", environment});
    if (!mask.empty() && mask != "builtin" && mask != "neural") files.push_back({"--mask", mask});
    return files;
}

void InputRecord::add_hash(const std::filesystem::path &path, const std::string &hash) {
    const auto [known, is_new] = hashes_.try_emplace(path.string(), hash);
    if (!is_new && known->second != hash) throw Error("has changed while it was read; try again");
}

void InputRecord::add(const std::filesystem::path &path, const std::vector<unsigned char> &bytes) {
    Sha256 hash;
    hash.add(bytes.data(), bytes.size());
    add_hash(path, hash.hex());
}

void InputRecord::add_file(const std::filesystem::path &path) {
    try {
        const InputFile file(path);
        Sha256 hash;
        std::vector<unsigned char> piece(1 << 20);
        for (uint64_t place = 0;;) {
            const size_t count = file.read(place, piece.data(), piece.size());
            if (count == 0) break;
            hash.add(piece.data(), count);
            place += count;
        }
        add_hash(path, hash.hex());
    } catch (const Error &error) {
        throw Error("cannot read " + path.string() + ": " + error.what());
    }
}

void InputRecord::add_missing(const std::filesystem::path &path) {
    add_hash(path, "");
}

std::string InputRecord::text() const {
    std::string result;
    for (const auto &[name, hash] : hashes_) {
        const std::string written = escaped(name);
        if (hash.empty())
            result += MISSING + written + "\n";
        else
            result += (written == name ? "" : "\\") + hash + "  " + written + "\n";
    }
    return result;
}

std::vector<NamedFile> InputRecord::files(const std::string &role) const {
    std::vector<NamedFile> result;
    for (const auto &[name, hash] : hashes_)
        if (!hash.empty()) result.push_back({role, name});
    return result;
}

std::string inputs_difference(const std::string &one, const std::string &other) {
    const auto a = parsed(one), b = parsed(other);
    for (const auto &[name, contents] : a) {
        const auto found = b.find(name);
        if (found == b.end()) return printable(name) + ", which only one of them reads";
        if (found->second != contents) return "the contents of " + printable(name);
    }
    for (const auto &[name, contents] : b)
        if (a.count(name) == 0) return printable(name) + ", which only one of them reads";
    return one == other ? "" : "the list of their files";
}
