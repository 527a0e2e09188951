// SPDX-License-Identifier: Apache-2.0
// What the fuzzers of the path tracer's readers share; each program includes it once. A reader may
// throw Error, whatever the file, or run out of memory; any other exception, a crash or a hang is a finding.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

#include "files.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

// Like --max-memory of the path tracer, this makes large allocations fail. The operators of sanitizers
// would end the program.
constexpr size_t LARGEST_ALLOCATION = size_t{1} << 28; // bytes

void *operator new(size_t size) {
    void *bytes = size <= LARGEST_ALLOCATION ? std::malloc(size ? size : 1) : nullptr;
    if (!bytes) throw std::bad_alloc();
    return bytes;
}
void *operator new[](size_t size) {
    return operator new(size);
}
void operator delete(void *bytes) noexcept {
    std::free(bytes);
}
void operator delete(void *bytes, size_t) noexcept {
    std::free(bytes);
}
void operator delete[](void *bytes) noexcept {
    std::free(bytes);
}
void operator delete[](void *bytes, size_t) noexcept {
    std::free(bytes);
}

// A folder for the files of this process, removed when it ends. In memory where there is /dev/shm.
class FuzzFolder {
  public:
    FuzzFolder() { std::filesystem::create_directory(path_); }
    FuzzFolder(const FuzzFolder &) = delete;
    FuzzFolder &operator=(const FuzzFolder &) = delete;
    ~FuzzFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    // Writes a file; returns its path.
    std::string write(const char *name, const void *bytes, size_t size) const {
        const std::string path = path_ / name;
        std::ofstream file(path, std::ios::binary);
        file.write(static_cast<const char *>(bytes), static_cast<std::streamsize>(size));
        if (!file.flush()) std::abort();
        return path;
    }

  private:
    const std::filesystem::path path_ =
        (access("/dev/shm", W_OK) == 0 ? std::filesystem::path("/dev/shm")
                                       : std::filesystem::temp_directory_path()) /
        ("bn-fuzz-" + std::to_string(getpid()));
};

inline const FuzzFolder &fuzz_folder() {
    static const FuzzFolder folder;
    return folder;
}

// Whether any reader took the last input: what a corpus begins with must be read.
extern bool fuzz_input_was_read;

// Runs a reader, which may refuse the file.
template <typename Read>
void fuzz_read(Read read) {
    try {
        read();
        fuzz_input_was_read = true;
    } catch (const Error &) {
    } catch (const std::bad_alloc &) {
    }
}
