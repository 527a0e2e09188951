// SPDX-License-Identifier: Apache-2.0
// glTF and GLB, told apart by their first bytes, up to a scene that is ready to render. The reader may
// throw Error, whatever the file, or run out of memory; any other exception, a crash or a hang is a finding.
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

#include "files.h"
#include "scene.h"

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

namespace {

// A folder for the files of this process, removed when it ends. In memory where there is /dev/shm.
struct Folder {
    const std::filesystem::path path =
        (access("/dev/shm", W_OK) == 0 ? std::filesystem::path("/dev/shm")
                                       : std::filesystem::temp_directory_path()) /
        ("bn-fuzz-" + std::to_string(getpid()));

    Folder() { std::filesystem::create_directory(path); }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
};

} // namespace

bool fuzz_input_was_read; // what a corpus begins with must be read

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static const Folder folder;
    const bool binary = size >= 4 && std::memcmp(bytes, "glTF", 4) == 0;
    const std::string path = folder.path / (binary ? "input.glb" : "input.gltf");
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char *>(bytes), static_cast<std::streamsize>(size));
    if (!file.flush()) std::abort();
    // Without one, scenes that have no light get a sky, which takes longer than all the rest.
    static const auto environment = std::make_shared<const Environment>(
        environment_create(2, 1, std::vector<Vec3>(2, Vec3{1, 1, 1})));
    SceneOptions options;
    options.environment = environment;
    try {
        scene_build(path, options);
        fuzz_input_was_read = true;
    } catch (const Error &) {
    } catch (const std::bad_alloc &) {
    }
    return 0;
}
