// SPDX-License-Identifier: Apache-2.0
// PNG files given as masks.
#include "image.h"
#include "reader_fuzzer.h"

bool fuzz_input_was_read;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    const std::string path = fuzz_folder().write("input.png", bytes, size);
    fuzz_read([&] {
        const GreyImage image = png_read_grey(path);
        if (image.values.size() != size_t{image.width} * image.height) std::abort();
    });
    return 0;
}
