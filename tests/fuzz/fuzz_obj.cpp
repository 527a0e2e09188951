// SPDX-License-Identifier: Apache-2.0
// OBJ and MTL: what comes after the first zero byte is the material file a.mtl, beside a texture
// t.tga.
#include <algorithm>

#include "reader_fuzzer.h"
#include "scene.h"

bool fuzz_input_was_read;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    // One grey texel.
    static const uint8_t texture[] = {0, 0, 3, 0, 0, 0,   0, 0, 0, 0, 0, 0, 1,
                                      0, 1, 0, 8, 0, 128, 0, 0, 0, 0, 0, 0, 0};
    static const std::string written = fuzz_folder().write("t.tga", texture, sizeof texture);
    const uint8_t *zero = std::find(bytes, bytes + size, 0);
    const auto obj_size = static_cast<size_t>(zero - bytes);
    const std::string path = fuzz_folder().write("input.obj", bytes, obj_size);
    if (obj_size < size) fuzz_folder().write("a.mtl", zero + 1, size - obj_size - 1);
    static const auto environment = std::make_shared<const Environment>(
        environment_create(2, 1, std::vector<Vec3>(2, Vec3{1, 1, 1})));
    SceneOptions options;
    options.environment = environment;
    fuzz_read([&] { scene_build(path, options); });
    return 0;
}
