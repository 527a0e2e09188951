// SPDX-License-Identifier: Apache-2.0
// The files of a picture. Each is written completely or not at all: it goes to a temporary file in
// the same folder, which is renamed once it is on the disk. Temporary files have random names and are
// created exclusively, so nobody with write access to the folder can make this program follow a link
// of theirs.
#include "outputs.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <list>
#include <random>
#include <system_error>
#include <utility>

#include "error.h"
#include "film.h"
#include "image.h"

namespace fs = std::filesystem;

namespace {

constexpr int MAX_LINKS = 40; // followed from one name; Linux has the same limit

volatile std::sig_atomic_t waiting = 0;

// Signals that would end the program wait as long as this lives, so that no temporary file stays.
class Undisturbed {
  public:
    Undisturbed() {
        for (auto &[signal, before] : handlers_) {
            before = std::signal(signal, [](int number) { waiting = number; });
            if (before == SIG_IGN) std::signal(signal, SIG_IGN);
        }
    }
    ~Undisturbed() {
        for (const auto &[signal, before] : handlers_) std::signal(signal, before);
        const int number = waiting;
        waiting = 0;
        if (number) std::raise(number);
    }

  private:
    std::pair<int, void (*)(int)> handlers_[3] = {{SIGINT, {}}, {SIGTERM, {}}, {SIGHUP, {}}};
};

Error cannot_write(const fs::path &path, const std::string &why) {
    return Error("cannot write ", path.string(), ": ", why);
}

// The target of a path's symbolic links, whether or not a file exists there.
fs::path resolve(const fs::path &path) {
    fs::path result = path;
    std::error_code ignored;
    for (int links = 0; fs::is_symlink(fs::symlink_status(result, ignored)); ++links) {
        if (links == MAX_LINKS) throw cannot_write(path, std::strerror(ELOOP));
        result = result.parent_path() / fs::read_symlink(result, ignored);
    }
    return result;
}

// A file that is removed when it goes out of scope, unless it was renamed.
class TemporaryFile {
  public:
    // Creates a file next to what `path` leads to.
    explicit TemporaryFile(const fs::path &path)
        : path_(path), target_(resolve(path)), name_(target_) {
        std::random_device random;
        char suffix[32];
        std::snprintf(suffix, sizeof suffix, ".part-%08x%08x", random(), random());
        name_ += suffix;
        file_ =
            std::fopen(name_.c_str(), "wxe"); // exclusively; programs started here do not get it
        check(file_ != nullptr);
    }
    TemporaryFile(const TemporaryFile &) = delete;
    ~TemporaryFile() {
        if (file_) std::fclose(file_);
        if (!renamed_) unlink(name_.c_str());
    }

    // Writes the file and flushes it to disk.
    void write(const std::string &bytes) {
        check(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size() &&
              std::fflush(file_) == 0 && fsync(fileno(file_)) == 0);
    }

    // Puts the file in place.
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

// Throws Error unless a file can be written under that name. Leaves nothing behind.
void check_writable(const fs::path &path) {
    std::error_code none;
    if (fs::exists(path, none) && !fs::is_regular_file(path, none))
        throw cannot_write(path, "it exists and is not a regular file");
    const Undisturbed undisturbed;
    const TemporaryFile probe(path);
}

// Writes all the files, replacing any of the same names, once all of them are on the disk. Symbolic
// links stay links; the files they point to are replaced. Throws Error.
void write_files(const std::vector<std::pair<fs::path, std::string>> &files) {
    const Undisturbed undisturbed;
    std::list<TemporaryFile> parts;
    for (const auto &[path, bytes] : files) parts.emplace_back(path).write(bytes);
    for (TemporaryFile &part : parts) part.rename();
}

// Whether two names lead to the same file, or would if files were created under both.
bool is_same_file(const fs::path &output, const fs::path &other) {
    std::error_code none;
    if (fs::exists(output, none) && fs::exists(other, none))
        return fs::equivalent(output, other, none);
    const fs::path target = fs::weakly_canonical(resolve(output), none);
    return !none && target == fs::weakly_canonical(other, none);
}

fs::path preview_path(const fs::path &exr) {
    return fs::path(exr).replace_extension(".png");
}

} // namespace

std::vector<NamedFile> setting_files(const Options &o) {
    std::vector<NamedFile> files;
    if (is_scene_file(o.scene)) files.push_back({"--scene", o.scene});
    if (!o.environment.empty() && o.environment != "sky" && o.environment != "none")
        files.push_back({"--env", o.environment});
    const std::string &mask = o.sampler.mask;
    if (!mask.empty() && mask != "builtin" && mask != "neural") files.push_back({"--mask", mask});
    return files;
}

void check_file_names(const Options &options, std::vector<NamedFile> inputs) {
    if (!options.resume.empty()) inputs.push_back({"--resume", options.resume});
    if (!options.reference.empty()) inputs.push_back({"--reference", options.reference});
    const fs::path exr = options.output, png = preview_path(exr);
    const auto as = [](const fs::path &one, const fs::path &other) {
        return one == other ? "" : " (as " + other.string() + ")";
    };
    if (is_same_file(exr, png))
        throw Error("-o and the preview of -o would both write ", exr.string(), as(exr, png),
                    "; give another name");
    for (const NamedFile &output : {NamedFile{"-o", exr}, NamedFile{"the preview of -o", png}})
        for (const NamedFile &input : inputs)
            if (!(output.role == "-o" && input.role == "--resume") &&
                is_same_file(output.path, input.path))
                throw Error(output.role, " would overwrite ", output.path.string(), ", which ",
                            input.role, " reads", as(output.path, input.path),
                            "; give the output another name");
}

void check_outputs(const Options &options) {
    check_writable(options.output);
    check_writable(preview_path(options.output));
}

void write_outputs(const Options &options, const Film &film, ExrAttributes attributes) {
    const bool automatic = options.auto_exposure || is_scene_file(attributes.scene);
    attributes.exposure = options.exposure ? *options.exposure
                          : automatic      ? auto_exposure(film)
                                           : 0;
    write_files({{options.output, exr_encode(film, attributes)},
                 {preview_path(options.output),
                  png_encode_preview(film_image(film), attributes.exposure)}});
}
