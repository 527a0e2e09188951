/* SPDX-License-Identifier: Apache-2.0
 * Dithering. */
#include "core.hpp"

namespace bluenoise {

namespace {

/* The image has shape (height, width, channels); the mask is (height, width) or None. */
Floats dither(const Floats &image, uint32_t levels, bool srgb, bool channel_offset,
              const py::object &mask) {
    bn_dither_options options = bn_dither_options_default();
    options.levels = levels;
    options.srgb = srgb ? 1 : 0;
    options.channel_offset = channel_offset ? 1 : 0;
    Floats out({image.shape(0), image.shape(1), image.shape(2)});
    const float *from = image.data();
    float *to = out.mutable_data();
    const auto height = static_cast<uint32_t>(image.shape(0));
    const auto width = static_cast<uint32_t>(image.shape(1));
    const auto channels = static_cast<uint32_t>(image.shape(2));
    const auto count = static_cast<size_t>(image.size());
    std::string arguments = "image of " + std::to_string(height) + " x " + std::to_string(width) +
                            " with " + std::to_string(channels) + " channels, levels " +
                            std::to_string(levels);
    const Ranks ranks = set_mask(options, mask, arguments);
    check(unlocked([&] { return bn_dither(&options, from, width, height, channels, to, count); }),
          arguments);
    return out;
}

} // namespace

void bind_images(py::module_ &module) {
    module.def("dither", &dither, py::arg("image").noconvert(), py::arg("levels"), py::arg("srgb"),
               py::arg("channel_offset"), py::arg("mask"));
}

} // namespace bluenoise
