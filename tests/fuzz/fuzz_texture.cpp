// SPDX-License-Identifier: Apache-2.0
// Textures: PNG and JPEG. One that is read has all its texels.
#include "image.h"
#include "reader_fuzzer.h"

bool fuzz_input_was_read;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_read([&] {
        const Texture texture = texture_decode({bytes, bytes + size});
        const size_t texels =
            static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height);
        if (texels == 0 || texture.rgba.size() != 4 * texels) std::abort();
        texture_at(texture, {0.3f, -7.9f});
    });
    return 0;
}
