/* SPDX-License-Identifier: Apache-2.0
 * Generating, converting and measuring masks. */
#include "core.hpp"

#include <vector>

namespace bluenoise {

namespace {

py::ssize_t extent(uint32_t value) {
    return static_cast<py::ssize_t>(value);
}

/* Makes a mask with make(ranks, count) and `options`, into which seed and callback are set. */
template <typename Options, typename Make>
void generate(Ranks &ranks, Options &options, uint64_t seed, const py::object &callback,
              const std::string &arguments, Make make) {
    Progress progress(callback);
    options.seed = seed;
    options.progress = Progress::call;
    options.progress_user = &progress;
    uint32_t *out = ranks.mutable_data();
    const auto count = static_cast<size_t>(ranks.size());
    progress.finish(unlocked([&] { return make(out, count); }), arguments);
}

/* `ranks` has shape (depth, height, width). */
void void_and_cluster(Ranks &ranks, double sigma, double initial_fraction, uint64_t seed,
                      const py::object &callback) {
    bn_void_and_cluster_options options = bn_void_and_cluster_options_default();
    options.sigma = sigma;
    options.initial_fraction = initial_fraction;
    const auto depth = static_cast<uint32_t>(ranks.shape(0));
    const auto height = static_cast<uint32_t>(ranks.shape(1));
    const auto width = static_cast<uint32_t>(ranks.shape(2));
    generate(ranks, options, seed, callback,
             "void-and-cluster, " + std::to_string(ranks.size()) + " texels, sigma " +
                 std::to_string(sigma) + ", initial_fraction " + std::to_string(initial_fraction),
             [&](uint32_t *out, size_t count) {
                 return bn_void_and_cluster(&options, width, height, depth, out, count);
             });
}

/* `ranks` has shape (channels, height, width). It receives the result, and is the initial mask if
 * start_from_ranks is set. */
void anneal(Ranks &ranks, double sigma, double far_sigma, double far_weight, double value_sigma,
            double start_temperature, double end_temperature, uint32_t sweeps, bool order_ends,
            bool start_from_ranks, uint64_t seed, const py::object &callback) {
    bn_anneal_options options = bn_anneal_options_default();
    options.sigma = sigma;
    options.far_sigma = far_sigma;
    options.far_weight = far_weight;
    options.value_sigma = value_sigma;
    options.start_temperature = start_temperature;
    options.end_temperature = end_temperature;
    options.sweeps = sweeps;
    options.order_ends = order_ends ? 1 : 0;
    options.start_from_ranks = start_from_ranks ? 1 : 0;
    const auto channels = static_cast<uint32_t>(ranks.shape(0));
    const auto height = static_cast<uint32_t>(ranks.shape(1));
    const auto width = static_cast<uint32_t>(ranks.shape(2));
    generate(ranks, options, seed, callback,
             "anneal, " + std::to_string(channels) + " x " + std::to_string(height) + " x " +
                 std::to_string(width) + (start_from_ranks ? ", start_from_ranks given" : "") +
                 ", sigma " + std::to_string(sigma) + ", far_sigma " + std::to_string(far_sigma) +
                 ", sweeps " + std::to_string(sweeps),
             [&](uint32_t *out, size_t count) {
                 return bn_anneal(&options, width, height, channels, out, count);
             });
}

/* As for anneal, but `ranks` has shape (height, width), and 0 steps are the learned schedule. */
void relax(Ranks &ranks, double sigma, double start_step, double end_step, double start_softness,
           double end_softness, uint32_t steps, uint32_t threads, bool start_from_ranks,
           uint64_t seed, const py::object &callback) {
    bn_relax_options options = bn_relax_options_default();
    options.sigma = sigma;
    options.start_step = start_step;
    options.end_step = end_step;
    options.start_softness = start_softness;
    options.end_softness = end_softness;
    options.steps = steps;
    options.threads = threads;
    options.start_from_ranks = start_from_ranks ? 1 : 0;
    const auto height = static_cast<uint32_t>(ranks.shape(0));
    const auto width = static_cast<uint32_t>(ranks.shape(1));
    generate(
        ranks, options, seed, callback,
        "relax, " + std::to_string(height) + " x " + std::to_string(width) +
            (start_from_ranks ? ", start_from_ranks given" : "") + ", sigma " +
            std::to_string(sigma) + ", steps " + std::to_string(steps) + ", threads " +
            std::to_string(threads),
        [&](uint32_t *out, size_t count) { return bn_relax(&options, width, height, out, count); });
}

Ranks ranks_from_values(const Floats &values) {
    Ranks ranks(values.size());
    const float *from = values.data();
    uint32_t *to = ranks.mutable_data();
    const auto count = static_cast<size_t>(values.size());
    check(unlocked([&] { return bn_ranks_from_values(from, count, to); }),
          "ranks of " + std::to_string(count) + " values");
    return ranks;
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
    if (bn_builtin_mask(size) == nullptr) return py::none();
    Ranks ranks({extent(size), extent(size)});
    check(bn_builtin_mask_copy(size, ranks.mutable_data(), static_cast<size_t>(ranks.size())),
          "built-in mask " + std::to_string(size));
    return ranks;
}

bool builtin_mask_exists(uint32_t size) {
    return bn_builtin_mask(size) != nullptr;
}

double mask_error(const Ranks &ranks, double sigma) {
    const auto height = static_cast<uint32_t>(ranks.shape(0));
    const auto width = static_cast<uint32_t>(ranks.shape(1));
    const auto count = static_cast<size_t>(ranks.size());
    Progress interrupts{py::none()};
    const uint32_t *from = ranks.data();
    double error = 0;
    const bn_result result = unlocked([&] {
        return bn_mask_error(from, width, height, count, sigma, &error, Progress::call,
                             &interrupts);
    });
    interrupts.finish(result, "error of a " + std::to_string(height) + " x " +
                                  std::to_string(width) + " mask, sigma " + std::to_string(sigma));
    return error;
}

Floats power_spectrum(const Ranks &ranks) {
    const auto height = static_cast<uint32_t>(ranks.shape(0));
    const auto width = static_cast<uint32_t>(ranks.shape(1));
    Progress interrupts{py::none()};
    Floats power({ranks.shape(0), ranks.shape(1)});
    const uint32_t *from = ranks.data();
    float *to = power.mutable_data();
    const auto count = static_cast<size_t>(ranks.size());
    const bn_result result = unlocked([&] {
        return bn_power_spectrum(from, width, height, count, to, Progress::call, &interrupts);
    });
    interrupts.finish(result, "spectrum of a " + std::to_string(height) + " x " +
                                  std::to_string(width) + " mask");
    return power;
}

} // namespace

void bind_masks(py::module_ &module) {
    module.def("void_and_cluster", &void_and_cluster, py::arg("ranks").noconvert(),
               py::arg("sigma"), py::arg("initial_fraction"), py::arg("seed"), py::arg("progress"));
    module.def("anneal", &anneal, py::arg("ranks").noconvert(), py::arg("sigma"),
               py::arg("far_sigma"), py::arg("far_weight"), py::arg("value_sigma"),
               py::arg("start_temperature"), py::arg("end_temperature"), py::arg("sweeps"),
               py::arg("order_ends"), py::arg("start_from_ranks"), py::arg("seed"),
               py::arg("progress"));
    module.def("relax", &relax, py::arg("ranks").noconvert(), py::arg("sigma"),
               py::arg("start_step"), py::arg("end_step"), py::arg("start_softness"),
               py::arg("end_softness"), py::arg("steps"), py::arg("threads"),
               py::arg("start_from_ranks"), py::arg("seed"), py::arg("progress"));
    module.def("ranks_from_values", &ranks_from_values, py::arg("values").noconvert());
    module.def("ranks_to_float", &ranks_to_float, py::arg("ranks").noconvert(), py::arg("count"));
    module.def("builtin_mask", &builtin_mask, py::arg("size"));
    module.def("builtin_mask_exists", &builtin_mask_exists, py::arg("size"));
    module.def("power_spectrum", &power_spectrum, py::arg("ranks").noconvert());
    module.def("mask_error", &mask_error, py::arg("ranks").noconvert(), py::arg("sigma"));
}

} // namespace bluenoise
