/* SPDX-License-Identifier: Apache-2.0
 * Neural masks and windows. */
#include "core.hpp"

#include <bn/neural.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string_view>

namespace bluenoise {

namespace {

class NeuralGenerator {
  public:
    /* `where` describes the model and the runtime for error messages. */
    NeuralGenerator(const std::optional<py::bytes> &model_path,
                    const std::optional<py::bytes> &model, const std::optional<py::bytes> &runtime,
                    uint32_t threads, const std::optional<std::string> &provider, uint32_t channels,
                    const std::string &where)
        : neural_(nullptr, bn_neural_close) {
        bn_neural_options options = bn_neural_options_default();
        if (model_path) options.model_path = PyBytes_AsString(model_path->ptr());
        if (model) {
            const std::string_view bytes = *model;
            options.model = bytes.data();
            options.model_size = bytes.size();
        }
        if (runtime) options.runtime_path = PyBytes_AsString(runtime->ptr());
        options.threads = threads;
        if (provider) options.provider = provider->c_str();
        options.channels = channels;
        bn_neural *neural = nullptr;
        const bn_result result = unlocked([&] { return bn_neural_open(&options, &neural); });
        neural_.reset(neural);
        check(result, where);
    }

    uint32_t channels() const { return bn_neural_channels(neural_.get()); }

    /* `out` has shape (height, width), or (channels, height, width) if there is more than one
     * channel. */
    void mask(Ranks &out, uint64_t seed, const py::object &callback) const {
        bn_mask mask = bn_mask_u32(out.mutable_data(), extent(out, 1), extent(out, 2));
        mask.channels = channels();
        Progress progress(callback);
        progress.finish(unlocked(
            [&] { return bn_neural_mask(neural_.get(), &mask, seed, Progress::call, &progress); }));
    }

    void window(int64_t x0, int64_t y0, Floats &out, uint64_t seed) const {
        const uint32_t height = extent(out, 2), width = extent(out, 1);
        float *values = out.mutable_data();
        const auto count = static_cast<size_t>(out.size());
        Progress interrupts{py::none()};
        interrupts.finish(unlocked([&] {
            return bn_neural_window(neural_.get(), x0, y0, width, height, seed, values, count,
                                    Progress::call, &interrupts);
        }));
    }

  private:
    /* The extent of an axis, counted from the last axis. */
    static uint32_t extent(const py::array &array, py::ssize_t from_end) {
        return static_cast<uint32_t>(array.shape(array.ndim() - from_end));
    }

    std::unique_ptr<bn_neural, decltype(&bn_neural_close)> neural_;
};

Floats neural_noise(int64_t x0, int64_t y0, uint32_t width, uint32_t height, uint64_t seed) {
    Floats noise({static_cast<py::ssize_t>(height), static_cast<py::ssize_t>(width)});
    float *out = noise.mutable_data();
    const auto count = static_cast<size_t>(noise.size());
    check(unlocked([&] { return bn_neural_noise(x0, y0, width, height, seed, out, count); }));
    return noise;
}

} // namespace

void bind_neural(py::module_ &module) {
    py::class_<NeuralGenerator>(module, "NeuralGenerator")
        .def(py::init<const std::optional<py::bytes> &, const std::optional<py::bytes> &,
                      const std::optional<py::bytes> &, uint32_t,
                      const std::optional<std::string> &, uint32_t, const std::string &>(),
             py::arg("model_path"), py::arg("model"), py::arg("runtime"), py::arg("threads"),
             py::arg("provider"), py::arg("channels"), py::arg("where"))
        .def_property_readonly("channels", &NeuralGenerator::channels)
        .def("mask", &NeuralGenerator::mask, py::arg("out").noconvert(), py::arg("seed"),
             py::arg("progress"))
        .def("window", &NeuralGenerator::window, py::arg("x0"), py::arg("y0"),
             py::arg("out").noconvert(), py::arg("seed"));
    module.def("neural_noise", &neural_noise, py::arg("x0"), py::arg("y0"), py::arg("width"),
               py::arg("height"), py::arg("seed"));
}

} // namespace bluenoise
