/* SPDX-License-Identifier: Apache-2.0
 * Generating, converting and measuring masks, and dithering. */
#include "core.hpp"

namespace bluenoise {

namespace {

py::ssize_t extent(uint32_t value) {
    return static_cast<py::ssize_t>(value);
}

/* A function that fills an array with a mask. `first` is the bn_mask field for the first of the three
 * axes. If options.start_from_ranks is set, it starts from the ranks in the array. */
template <auto make, typename Options>
auto generator(uint32_t bn_mask::*first) {
    return [first](Ranks &ranks, const Options &options, const py::object &callback) {
        bn_mask mask = bn_mask_u32(ranks.mutable_data(), static_cast<uint32_t>(ranks.shape(2)),
                                   static_cast<uint32_t>(ranks.shape(1)));
        mask.*first = static_cast<uint32_t>(ranks.shape(0));
        Progress progress(callback);
        progress.finish(unlocked([&] { return make(&options, &mask, Progress::call, &progress); }));
    };
}

Floats ranks_to_float(const Ranks &ranks, uint64_t count) {
    Floats values(ranks.size());
    const uint32_t *from = ranks.data();
    float *to = values.mutable_data();
    const py::ssize_t size = ranks.size();
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < size; ++i) to[i] = bn_rank_to_float(from[i], count);
    return values;
}

py::object builtin_mask(uint32_t size) {
    const auto *from = static_cast<const uint16_t *>(bn_builtin_mask(size).ranks);
    if (from == nullptr) return py::none();
    Ranks ranks({extent(size), extent(size)});
    std::copy_n(from, ranks.size(), ranks.mutable_data());
    return ranks;
}

double mask_error(const Ranks &ranks, double sigma) {
    const bn_mask mask = mask_of(ranks);
    Progress interrupts{py::none()};
    double error = 0;
    interrupts.finish(
        unlocked([&] { return bn_mask_error(&mask, sigma, &error, Progress::call, &interrupts); }));
    return error;
}

Floats power_spectrum(const Ranks &ranks) {
    const bn_mask mask = mask_of(ranks);
    Progress interrupts{py::none()};
    Floats power({ranks.shape(0), ranks.shape(1)});
    float *to = power.mutable_data();
    const auto count = static_cast<size_t>(ranks.size());
    interrupts.finish(
        unlocked([&] { return bn_power_spectrum(&mask, to, count, Progress::call, &interrupts); }));
    return power;
}

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
    const Ranks ranks = mask.is_none() ? Ranks() : mask.cast<Ranks>();
    bn_mask value;
    if (!mask.is_none()) {
        value = mask_of(ranks);
        options.mask = &value;
    }
    check(unlocked([&] { return bn_dither(&options, from, width, height, channels, to, count); }));
    return out;
}

Floats visible_noise(const Floats &first, const Floats &second, double sigma, double exposure,
                     double first_share, uint32_t window, py::object progress) {
    bn_visible_noise_options options = bn_visible_noise_options_default();
    options.sigma = sigma;
    options.exposure = exposure;
    options.first_share = first_share;
    options.window = window;
    const auto height = static_cast<uint32_t>(first.shape(0));
    const auto width = static_cast<uint32_t>(first.shape(1));
    const auto channels = static_cast<uint32_t>(first.shape(2));
    Floats map({first.shape(0), first.shape(1)});
    const float *a = first.data(), *b = second.data();
    float *to = map.mutable_data();
    const auto count = static_cast<size_t>(first.size()), pixels = static_cast<size_t>(map.size());
    Progress reports(std::move(progress));
    reports.finish(unlocked([&] {
        return bn_visible_noise(&options, a, b, width, height, channels, count, to, pixels,
                                Progress::call, &reports);
    }));
    return map;
}

} // namespace

void bind_masks(py::module_ &module) {
    /* The header's options and their defaults. */
    py::class_<bn_void_and_cluster_options>(module, "VoidAndClusterOptions")
        .def(py::init(&bn_void_and_cluster_options_default))
        .def_readwrite("sigma", &bn_void_and_cluster_options::sigma)
        .def_readwrite("initial_fraction", &bn_void_and_cluster_options::initial_fraction)
        .def_readwrite("seed", &bn_void_and_cluster_options::seed);
    py::class_<bn_relax_options>(module, "RelaxOptions")
        .def(py::init(&bn_relax_options_default))
        .def_readwrite("threads", &bn_relax_options::threads)
        .def_readwrite("seed", &bn_relax_options::seed);
    py::class_<bn_anneal_options>(module, "AnnealOptions")
        .def(py::init(&bn_anneal_options_default))
        .def_readwrite("sigma", &bn_anneal_options::sigma)
        .def_readwrite("far_sigma", &bn_anneal_options::far_sigma)
        .def_readwrite("far_weight", &bn_anneal_options::far_weight)
        .def_readwrite("value_sigma", &bn_anneal_options::value_sigma)
        .def_readwrite("start_temperature", &bn_anneal_options::start_temperature)
        .def_readwrite("end_temperature", &bn_anneal_options::end_temperature)
        .def_readwrite("sweeps", &bn_anneal_options::sweeps)
        .def_readwrite("order_ends", &bn_anneal_options::order_ends)
        .def_readwrite("start_from_ranks", &bn_anneal_options::start_from_ranks)
        .def_readwrite("seed", &bn_anneal_options::seed);
    module.def("void_and_cluster",
               generator<bn_void_and_cluster, bn_void_and_cluster_options>(&bn_mask::depth),
               py::arg("ranks").noconvert(), py::arg("options"), py::arg("progress"));
    module.def("anneal", generator<bn_anneal, bn_anneal_options>(&bn_mask::channels),
               py::arg("ranks").noconvert(), py::arg("options"), py::arg("progress"));
    module.def("relax", generator<bn_relax, bn_relax_options>(&bn_mask::depth),
               py::arg("ranks").noconvert(), py::arg("options"), py::arg("progress"));
    module.def("ranks_to_float", &ranks_to_float, py::arg("ranks"), py::arg("count"));
    module.def("builtin_mask", &builtin_mask, py::arg("size"));
    module.def("builtin_mask_exists",
               [](uint32_t size) { return bn_builtin_mask(size).ranks != nullptr; });
    module.def("power_spectrum", &power_spectrum, py::arg("ranks"));
    module.def("mask_error", &mask_error, py::arg("ranks"), py::arg("sigma"));
    module.def("dither", &dither, py::arg("image"), py::arg("levels"), py::arg("srgb"),
               py::arg("channel_offset"), py::arg("mask"));
    module.def("visible_noise", &visible_noise, py::arg("first"), py::arg("second"),
               py::arg("sigma"), py::arg("exposure"), py::arg("first_share"), py::arg("window"),
               py::arg("progress"));
}

} // namespace bluenoise
