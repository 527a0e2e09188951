// SPDX-License-Identifier: Apache-2.0
// EXR: as a reference, as an environment, and as a picture to merge or resume.
#include "exr.h"
#include "light.h"
#include "reader_fuzzer.h"

bool fuzz_input_was_read;

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    const std::string path = fuzz_folder().write("input.exr", bytes, size);
    fuzz_read([&] {
        const Image image = exr_read(path);
        if (image.rgb.size() != pixel_count(image.crop)) std::abort();
    });
    fuzz_read([&] { environment_read(path); });
    fuzz_read([&] {
        const Film film = exr_read_film(path);
        if (film.pixels.size() != pixel_count(film.crop)) std::abort();
    });
    return 0;
}
