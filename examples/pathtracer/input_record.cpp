// SPDX-License-Identifier: Apache-2.0
#include "input_record.h"

#include <cstdio>
#include <sstream>

#include "error.h"
#include "input_file.h"
#include "scene_file.h"
#include "sha256.h"

namespace {

constexpr const char *MISSING = "# missing: ";

// Control characters and backslashes as escapes, those of sha256sum where it has any.
std::string escaped(const std::string &name) {
    const std::string clean = without_controls(name);
    std::string result;
    for (size_t i = 0; i < name.size(); ++i) {
        char code[8];
        if (name[i] == '\\') {
            result += "\\\\";
        } else if (name[i] == '\n' || name[i] == '\r') {
            result += name[i] == '\n' ? "\\n" : "\\r";
        } else if (clean[i] != name[i]) {
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
