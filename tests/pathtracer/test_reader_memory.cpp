// SPDX-License-Identifier: Apache-2.0
// The readers of files when memory runs out: each allocation by `new` fails once, in this program
// and in the libraries that it uses, and the reader ends with an exception. Under the address
// sanitizer this program does not leak either; some of the libraries do.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <new>

#include "check.h"
#include "environment.h"
#include "error.h"
#include "exr.h"
#include "png_image.h"
#include "scene_camera.h"
#include "scene_file.h"

namespace {

// Allocations until one fails; none does below zero.
long left = -1;

void *allocate(size_t size) {
    if (left >= 0 && left-- == 0) return nullptr;
    return std::malloc(size ? size : 1);
}

} // namespace

extern "C" const char *__lsan_default_suppressions() {
    return "leak:libOpenEXR\nleak:libstb\n";
}

void *operator new(size_t size) {
    if (void *memory = allocate(size)) return memory;
    throw std::bad_alloc();
}
void *operator new[](size_t size) {
    return operator new(size);
}
void *operator new(size_t size, const std::nothrow_t &) noexcept {
    return allocate(size);
}
void *operator new[](size_t size, const std::nothrow_t &) noexcept {
    return allocate(size);
}
void operator delete(void *memory) noexcept {
    std::free(memory);
}
void operator delete[](void *memory) noexcept {
    std::free(memory);
}
void operator delete(void *memory, size_t) noexcept {
    std::free(memory);
}
void operator delete[](void *memory, size_t) noexcept {
    std::free(memory);
}

namespace {

namespace fs = std::filesystem;

constexpr long MANY = 400; // allocations, all of which are tried

enum class End { COMPLETE, FAILED, DID_WITHOUT };

// Runs a reader whose allocation number `number` fails.
End read_with_failure(const std::function<void()> &read, long number) {
    left = number;
    End end = End::FAILED;
    try {
        read();
        end = left < 0 ? End::DID_WITHOUT : End::COMPLETE;
    } catch (const std::bad_alloc &) {
    } catch (const Error &) {
    }
    left = -1;
    return end;
}

// The same in a process of its own, for readers in which a failure may end the program: it must do
// so in order.
End read_in_child(const std::function<void()> &read, long number) {
    const pid_t child = fork();
    CHECK(child >= 0, "no process");
    if (child == 0) {
        CHECK(std::freopen("/dev/null", "w", stderr), "no /dev/null");
        exit_where_it_would_abort();
        const End end = read_with_failure(read, number);
        std::_Exit(end == End::COMPLETE ? 2 : end == End::DID_WITHOUT ? 3 : 1);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child, "no end");
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) >= 1 && WEXITSTATUS(status) <= 3,
          "status %d when allocation %ld failed", status, number);
    return WEXITSTATUS(status) == 2   ? End::COMPLETE
           : WEXITSTATUS(status) == 3 ? End::DID_WITHOUT
                                      : End::FAILED;
}

// Fails each allocation of a reader in turn; of very many only some.
void check_reader(const char *what, const std::function<void()> &read, bool may_exit = false) {
    read(); // what is made once, and stays, is there from here on
    int failures = 0;
    for (long number = 0;; number += number < MANY ? 1 : 1 + number / 50) {
        const End end = (may_exit ? read_in_child : read_with_failure)(read, number);
        if (end == End::COMPLETE) break;
        failures += end == End::FAILED;
    }
    CHECK(failures > 0, "%s failed %d times", what, failures);
    read();
}

template <typename Bytes>
void save(const fs::path &path, const Bytes &bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char *>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    CHECK(file.good(), "%s", path.c_str());
}

const char *const GLTF = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1},
"material": 0}]}], "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
"textures": [{"source": 0}], "images": [{"uri": "grey.png"}],
"buffers": [{"uri": "triangle.bin", "byteLength": 60}],
"bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}]})";
const float TRIANGLE[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};

const char *const OBJ = "mtllib triangle.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
                        "vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1 2 4 3\n";
const char *const MTL = "newmtl a\nKd 1 1 1\nmap_Kd grey.png\nKe 1 1 1\n";

} // namespace

int main() {
    std::string name = (fs::temp_directory_path() / "bn-memory-XXXXXX").string();
    CHECK(mkdtemp(name.data()), "no folder %s", name.c_str());
    const fs::path folder = name;
    const Film film = film_create(16, 8, {0, 0, 16, 8});
    save(folder / "picture.exr", exr_encode(film, {}));
    save(folder / "grey.png", png_encode_preview(film_image(film), 0));
    save(folder / "triangle.gltf", std::string(GLTF));
    save(folder / "triangle.bin",
         std::string(reinterpret_cast<const char *>(TRIANGLE), sizeof TRIANGLE));
    save(folder / "triangle.obj", std::string(OBJ));
    save(folder / "triangle.mtl", std::string(MTL));

    const std::string exr = folder / "picture.exr", png = folder / "grey.png";
    check_reader(
        "glTF", [&] { scene_file_read(folder / "triangle.gltf", SceneOptions{}); }, true);
    check_reader("OBJ", [&] { scene_file_read(folder / "triangle.obj", SceneOptions{}); });
    check_reader("PNG", [&] { png_read_grey(png); });
    check_reader("EXR", [&] { exr_read(exr); });
    check_reader("EXR of this program", [&] { exr_read_film(exr); });
    check_reader("environment", [&] { environment_read(exr); });
    fs::remove_all(folder);
    return 0;
}
