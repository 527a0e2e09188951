// SPDX-License-Identifier: Apache-2.0
// glTF and GLB, told apart by their first bytes, up to a scene that is ready to render.
#include <cstring>

#include "reader_fuzzer.h"
#include "scene.h"

bool fuzz_input_was_read;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    const bool binary = size >= 4 && std::memcmp(bytes, "glTF", 4) == 0;
    const std::string path = fuzz_folder().write(binary ? "input.glb" : "input.gltf", bytes, size);
    // Without one, scenes that have no light get a sky, which takes longer than all the rest.
    static const auto environment = std::make_shared<const Environment>(
        environment_create(2, 1, std::vector<Vec3>(2, Vec3{1, 1, 1})));
    SceneOptions options;
    options.environment = environment;
    fuzz_read([&] { scene_build(path, options); });
    return 0;
}
