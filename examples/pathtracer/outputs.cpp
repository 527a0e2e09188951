// SPDX-License-Identifier: Apache-2.0
// The files of a picture. Each is written completely or not at all: it goes to a temporary file in
// the same folder, which is renamed when complete. Temporary files have random names and are created
// exclusively, so nobody with write access to the folder can make this program follow a link of
// theirs. Files are flushed to disk before they are renamed: after a system crash either the old or
// the new file is there, complete.
#include "outputs.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <list>
#include <random>
#include <set>
#include <string>
#include <system_error>

#include "error.h"
#include "film.h"
#include "png_image.h"
#include "scene_file.h"

namespace fs = std::filesystem;

namespace {

constexpr int MAX_LINKS = 40; // followed from one name; Linux has the same limit

// The temporary files that there may be, for signal handlers: one for each output.
struct KnownName {
    volatile std::sig_atomic_t used;
    char name[4096];
} known_names[3];

void remember(const fs::path &name) {
    for (KnownName &known : known_names)
        if (!known.used && name.native().size() < sizeof known.name) {
            std::strcpy(known.name, name.c_str());
            std::atomic_signal_fence(std::memory_order_release); // the name before its use
            known.used = 1;
            return;
        }
}

void forget(const fs::path &name) {
    for (KnownName &known : known_names)
        if (known.used && name.native() == known.name) known.used = 0;
}

Error cannot_write(const fs::path &path, const std::string &why) {
    return Error("cannot write " + path.string() + ": " + why);
}

// Replaces a path by the target of its symbolic links, whether or not a file exists there. Returns
// false if the links never end.
bool follow_links(fs::path &path) {
    std::error_code ignored;
    for (int links = 0; fs::is_symlink(fs::symlink_status(path, ignored)); ++links) {
        if (links == MAX_LINKS) return false;
        const fs::path target = fs::read_symlink(path, ignored);
        path = target.is_absolute() ? target : path.parent_path() / target;
    }
    return true;
}

fs::path resolve(const fs::path &path) {
    fs::path result = path;
    if (!follow_links(result)) throw cannot_write(path, std::strerror(ELOOP));
    return result;
}

fs::path folder_of(const fs::path &path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// An unguessable name next to `path`.
fs::path beside(const fs::path &path) {
    std::random_device random;
    char suffix[32];
    std::snprintf(suffix, sizeof suffix, ".part-%08x%08x", random(), random());
    fs::path result = path;
    result += suffix;
    return result;
}

// A file that is removed when it goes out of scope, unless it was renamed.
class TemporaryFile {
  public:
    // Creates a file next to `target`. Errors name `path`, as the user wrote it.
    TemporaryFile(const fs::path &path, const fs::path &target)
        : path_(path), target_(target), name_(beside(target)) {
        remember(name_);
        descriptor_ =
            open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (descriptor_ < 0) {
            const int error = errno;
            forget(name_);
            throw cannot_write(path_, std::strerror(error));
        }
    }
    TemporaryFile(const TemporaryFile &) = delete;
    TemporaryFile &operator=(const TemporaryFile &) = delete;
    ~TemporaryFile() {
        if (descriptor_ >= 0) close(descriptor_);
        if (!renamed_) unlink(name_.c_str());
        forget(name_);
    }

    // Writes the file, flushes it to disk and closes it.
    void write(const std::vector<char> &bytes) {
        for (size_t done = 0; done < bytes.size();) {
            const ssize_t count = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) throw cannot_write(path_, std::strerror(errno));
            done += static_cast<size_t>(count);
        }
        const bool synced = fsync(descriptor_) == 0;
        const int error = errno;
        const bool closed = close(descriptor_) == 0;
        descriptor_ = -1;
        if (!synced || !closed) throw cannot_write(path_, std::strerror(synced ? errno : error));
    }

    // Puts the file in place.
    void rename() {
        if (std::rename(name_.c_str(), target_.c_str()) != 0)
            throw cannot_write(path_, std::strerror(errno));
        renamed_ = true;
    }

    const fs::path &target() const { return target_; }

  private:
    fs::path path_, target_, name_;
    int descriptor_ = -1;
    bool renamed_ = false;
};

// Makes renames in a folder durable. Some file systems cannot; then only durability is lost.
void sync_folder(const fs::path &folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    fsync(descriptor);
    close(descriptor);
}

// Throws Error unless a file can be written under that name. Leaves nothing behind.
void check_writable(const fs::path &path) {
    const fs::path target = resolve(path);
    struct stat status;
    if (stat(target.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw cannot_write(path, "it exists and is not a regular file");
    const TemporaryFile probe(path, target);
}

// Writes all the files, replacing any of the same names, once all of them are on the disk. Symbolic
// links stay links; the files they point to are replaced. Throws Error.
void write_files(const std::vector<std::pair<fs::path, std::vector<char>>> &files) {
    std::list<TemporaryFile> parts;
    for (const auto &[path, bytes] : files) parts.emplace_back(path, resolve(path)).write(bytes);
    for (TemporaryFile &part : parts) part.rename();
    std::set<fs::path> folders;
    for (const TemporaryFile &part : parts) folders.insert(folder_of(part.target()));
    for (const fs::path &folder : folders) sync_folder(folder);
}

// Whether two names lead to the same file, through symbolic or hard links too. Files that do not
// exist yet are the same if creating both would create one.
bool is_same_file(const fs::path &a, const fs::path &b) {
    struct stat one, other;
    if (stat(a.c_str(), &one) == 0 && stat(b.c_str(), &other) == 0)
        return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    fs::path p = a, q = b;
    if (!follow_links(p) || !follow_links(q)) return false;
    if (p.filename() != q.filename()) return false;
    return stat(folder_of(p).c_str(), &one) == 0 && stat(folder_of(q).c_str(), &other) == 0 &&
           one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

std::filesystem::path preview_path(const std::filesystem::path &exr) {
    return std::filesystem::path(exr).replace_extension(".png");
}

std::vector<NamedFile> output_files(const Options &options) {
    std::vector<NamedFile> files = {{"-o", options.output},
                                    {"the preview of -o", preview_path(options.output)}};
    if (!options.convergence.empty()) files.push_back({"--convergence", options.convergence});
    return files;
}

std::vector<NamedFile> input_files(const Options &options) {
    std::vector<NamedFile> files;
    for (const std::string &part : options.merge) files.push_back({"--merge", part});
    if (!options.reference.empty()) files.push_back({"--reference", options.reference});
    if (!options.resume.empty()) files.push_back({"--resume", options.resume});
    if (!options.merge.empty()) return files;
    for (const NamedFile &file : setting_files(options)) files.push_back(file);
    return files;
}

} // namespace

void end_without_temporary_files(int signal) {
    for (const KnownName &known : known_names)
        if (known.used) unlink(known.name);
    std::signal(signal, SIG_DFL);
    std::raise(signal); // once this handler returns
}

void remove_temporary_files_when_killed() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (std::signal(signal, end_without_temporary_files) == SIG_IGN)
            std::signal(signal, SIG_IGN);
}

std::vector<NamedFile> setting_files(const Options &options) {
    return named_files(options.scene, options.environment, options.sampler.mask);
}

void check_file_names(const Options &options, const std::vector<NamedFile> &read) {
    std::vector<NamedFile> inputs = input_files(options);
    inputs.insert(inputs.end(), read.begin(), read.end());
    const std::vector<NamedFile> outputs = output_files(options);
    const auto other_name = [](const NamedFile &one, const NamedFile &other) {
        return one.path == other.path ? "" : " (as " + other.path.string() + ")";
    };
    for (size_t i = 0; i < outputs.size(); ++i) {
        for (size_t k = 0; k < i; ++k)
            if (is_same_file(outputs[i].path, outputs[k].path))
                throw Error(outputs[k].role + " and " + outputs[i].role + " would both write " +
                            outputs[k].path.string() + other_name(outputs[k], outputs[i]) +
                            "; give one of them another name");
        for (const NamedFile &input : inputs) {
            if (outputs[i].role == "-o" && input.role == "--resume") continue;
            if (is_same_file(outputs[i].path, input.path))
                throw Error(outputs[i].role + " would overwrite " + outputs[i].path.string() +
                            ", which " + input.role + " reads" + other_name(outputs[i], input) +
                            "; give the output another name");
        }
    }
}

Outputs::Outputs(const Options &options, const std::string &scene)
    : exr_(options.output), png_(preview_path(options.output)), csv_(options.convergence),
      exposure_(options.exposure) {
    if (!exposure_ && !options.auto_exposure && !is_scene_file(scene)) exposure_ = 0.0f;
    check_writable(exr_);
    check_writable(png_);
    if (!csv_.empty()) check_writable(csv_);
}

float Outputs::write(const Film &film, ExrAttributes attributes,
                     const std::vector<ConvergenceRow> &rows) const {
    attributes.exposure = exposure_.value_or(0);
    if (!exposure_) attributes.exposure = auto_exposure(film);
    std::vector<std::pair<std::filesystem::path, std::vector<char>>> files = {
        {exr_, exr_encode(film, attributes)},
        {png_, png_encode_preview(film_image(film), attributes.exposure)}};
    if (!csv_.empty()) files.push_back({csv_, convergence_csv(rows)});
    write_files(files);
    return attributes.exposure;
}
