// SPDX-License-Identifier: Apache-2.0
#include "input_file.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <locale>
#include <new>
#include <sstream>

#include "error.h"

namespace fs = std::filesystem;

namespace {

constexpr int64_t MAX_FILE = int64_t{1} << 32; // bytes

// Whether a path lies below a folder. Both must be canonical.
bool is_below(const fs::path &path, const fs::path &folder) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
    return end == folder.end() && rest != path.end();
}

std::string sha256(const std::vector<unsigned char> &bytes) {
    unsigned char digest[32];
    if (!EVP_Digest(bytes.data(), bytes.size(), digest, nullptr, EVP_sha256(), nullptr))
        throw std::bad_alloc();
    std::string text;
    for (const unsigned char byte : digest) {
        text += "0123456789abcdef"[byte >> 4];
        text += "0123456789abcdef"[byte & 15];
    }
    return text;
}

bool is_utf8(const std::string &text) {
    using Utf8 = std::codecvt<char32_t, char, std::mbstate_t>;
    std::mbstate_t state{};
    const auto &utf8 = std::use_facet<Utf8>(std::locale::classic());
    const char *const begin = text.data();
    return utf8.length(state, begin, begin + text.size(), text.size()) ==
           static_cast<int>(text.size());
}

// Backslashes, control characters and what is no UTF-8, which readers of EXR attributes refuse, as
// escapes: those of sha256sum where it has any.
std::string escaped(const std::string &name) {
    const std::string clean = without_controls(name);
    const bool plain = is_utf8(name);
    std::string result;
    for (size_t i = 0; i < name.size(); ++i) {
        char code[8];
        const size_t known = std::string_view("\\\n\r").find(name[i]);
        if (known != std::string::npos) {
            result += {'\\', "\\nr"[known]};
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
        const size_t blank = line.find("  ");
        if (blank != std::string::npos) lines[line.substr(blank + 2)] = line.substr(0, blank);
    }
    return lines;
}

} // namespace

void check_regular(const fs::path &path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) throw Error("there is no such file");
    if (error) throw Error("cannot be opened: ", error.message());
    if (!fs::is_regular_file(status)) throw Error("is not a regular file");
}

std::vector<unsigned char> read_file(const fs::path &path) {
    check_regular(path);
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw Error("cannot be opened: ", std::strerror(errno));
    const std::streamoff size = file.tellg();
    if (size >= MAX_FILE) throw Error("is too large: files below 4 GiB are read");
    std::vector<unsigned char> bytes(static_cast<size_t>(size));
    file.seekg(0);
    if (!file.read(reinterpret_cast<char *>(bytes.data()), size))
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
    if (error) throw Error("cannot be opened: ", error.message());
    if (!allow_outside_ && !is_below(path, folder_))
        throw Error("is outside the scene's folder; use --allow-outside to read it");
    return path;
}

std::vector<unsigned char> SceneFolder::load(const fs::path &path, const fs::path &name) {
    std::vector<unsigned char> bytes = read_file(path);
    if (record_) record_->add(name, bytes);
    return bytes;
}

std::vector<unsigned char> SceneFolder::read(const std::string &name) {
    const fs::path path = resolve(name);
    return load(path, listed(path));
}

void InputRecord::add(const fs::path &path, const std::vector<unsigned char> &bytes) {
    const std::string hash = sha256(bytes);
    const auto [known, is_new] = hashes_.try_emplace(path.string(), hash);
    if (!is_new && known->second != hash) throw Error("has changed while it was read; try again");
}

void InputRecord::add_file(const fs::path &path) {
    try {
        add(path, read_file(path));
    } catch (const Error &error) {
        throw Error("cannot read ", path.string(), ": ", error.what());
    }
}

std::string InputRecord::text() const {
    std::string result;
    for (const auto &[name, hash] : hashes_) {
        const std::string written = escaped(name);
        result += (written == name ? "" : "\\") + hash + "  " + written + "\n";
    }
    return result;
}

std::vector<NamedFile> InputRecord::files(const std::string &role) const {
    std::vector<NamedFile> result;
    for (const auto &file : hashes_) result.push_back({role, file.first});
    return result;
}

std::string inputs_difference(const std::string &one, const std::string &other) {
    const auto a = parsed(one), b = parsed(other);
    auto all = a;
    all.insert(b.begin(), b.end());
    for (const auto &[name, contents] : all) {
        if (a.count(name) != b.count(name))
            return printable(name) + ", which only one of them reads";
        if (a.at(name) != b.at(name)) return "the contents of " + printable(name);
    }
    return one == other ? "" : "the list of their files";
}
