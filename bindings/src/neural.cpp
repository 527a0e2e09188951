/* SPDX-License-Identifier: Apache-2.0
 * Neural masks and windows. */
#include "core.hpp"

#include <bn/neural.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace bluenoise {

namespace {

/* The call in progress on this thread. The network reports progress on the calling thread. */
thread_local Progress *current_call = nullptr;

int32_t poll_current_call(void *, double fraction) {
    return current_call != nullptr ? Progress::call(current_call, fraction) : 0;
}

/* Runs work() without the GIL. Ctrl-C or the callback can stop it. */
template <typename Work>
void interruptible(const std::string &arguments, const py::object &callback, Work work) {
    Progress progress{callback};
    bn_result result;
    {
        py::gil_scoped_release unlocked;
        current_call = &progress;
        result = work();
        current_call = nullptr;
    }
    progress.finish(result, arguments);
}

class NeuralGenerator {
  public:
    /* `where` describes the model and the runtime for error messages. */
    NeuralGenerator(const std::optional<std::string> &model_path,
                    const std::optional<py::bytes> &model,
                    const std::optional<std::string> &runtime, uint32_t threads,
                    const std::optional<std::string> &provider, uint32_t channels,
                    const std::string &where)
        : neural_(nullptr, bn_neural_close) {
        bn_neural_options options = bn_neural_options_default();
        if (model_path) options.model_path = model_path->c_str();
        if (model) {
            const std::string_view bytes = *model;
            options.model = bytes.data();
            options.model_size = bytes.size();
        }
        if (runtime) options.runtime_path = runtime->c_str();
        options.threads = threads;
        if (provider) options.provider = provider->c_str();
        options.channels = channels;
        options.progress = poll_current_call;
        bn_neural *neural = nullptr;
        bn_result result;
        {
            py::gil_scoped_release unlocked;
            result = bn_neural_open(&options, &neural);
        }
        neural_.reset(neural);
        check(result, where);
    }

    uint32_t channels() const { return bn_neural_channels(neural_.get()); }

    Ranks mask(uint32_t height, uint32_t width, uint64_t seed, const py::object &callback) const {
        const size_t count = checked_count({channels(), height, width}, sizeof(uint32_t));
        Ranks ranks(shape(height, width));
        uint32_t *out = ranks.mutable_data();
        interruptible(
            "neural, " + std::to_string(height) + " x " + std::to_string(width), callback,
            [&] { return bn_neural_mask(neural_.get(), width, height, seed, out, count); });
        return ranks;
    }

    Floats window(int64_t x0, int64_t y0, uint32_t width, uint32_t height, uint64_t seed) const {
        const size_t count = checked_count({channels(), height, width}, sizeof(float));
        Floats values(shape(height, width));
        float *out = values.mutable_data();
        interruptible("x0 " + std::to_string(x0) + ", y0 " + std::to_string(y0) + ", width " +
                          std::to_string(width) + ", height " + std::to_string(height),
                      py::none(), [&] {
                          return bn_neural_window(neural_.get(), x0, y0, width, height, seed, out,
                                                  count);
                      });
        return values;
    }

  private:
    std::vector<py::ssize_t> shape(uint32_t height, uint32_t width) const {
        std::vector<py::ssize_t> extents = {static_cast<py::ssize_t>(height),
                                            static_cast<py::ssize_t>(width)};
        if (channels() > 1) extents.insert(extents.begin(), static_cast<py::ssize_t>(channels()));
        return extents;
    }

    std::unique_ptr<bn_neural, decltype(&bn_neural_close)> neural_;
};

Floats neural_noise(int64_t x0, int64_t y0, uint32_t width, uint32_t height, uint64_t seed) {
    const size_t count = checked_count({height, width}, sizeof(float));
    Floats noise({static_cast<py::ssize_t>(height), static_cast<py::ssize_t>(width)});
    float *out = noise.mutable_data();
    bn_result result;
    {
        py::gil_scoped_release unlocked;
        result = bn_neural_noise(x0, y0, width, height, seed, out, count);
    }
    check(result, "x0 " + std::to_string(x0) + ", y0 " + std::to_string(y0) + ", width " +
                      std::to_string(width) + ", height " + std::to_string(height));
    return noise;
}

} // namespace

void bind_neural(py::module_ &module) {
    py::class_<NeuralGenerator>(module, "NeuralGenerator")
        .def(py::init<const std::optional<std::string> &, const std::optional<py::bytes> &,
                      const std::optional<std::string> &, uint32_t,
                      const std::optional<std::string> &, uint32_t, const std::string &>(),
             py::arg("model_path"), py::arg("model"), py::arg("runtime"), py::arg("threads"),
             py::arg("provider"), py::arg("channels"), py::arg("where"))
        .def_property_readonly("channels", &NeuralGenerator::channels)
        .def("mask", &NeuralGenerator::mask, py::arg("height"), py::arg("width"), py::arg("seed"),
             py::arg("progress"))
        .def("window", &NeuralGenerator::window, py::arg("x0"), py::arg("y0"), py::arg("width"),
             py::arg("height"), py::arg("seed"));
    module.def("neural_noise", &neural_noise, py::arg("x0"), py::arg("y0"), py::arg("width"),
               py::arg("height"), py::arg("seed"));
}

} // namespace bluenoise
