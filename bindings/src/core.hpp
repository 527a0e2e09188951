/* SPDX-License-Identifier: Apache-2.0
 * Shared by the extension's files: exceptions, interrupts and progress. */
#ifndef BLUENOISE_CORE_HPP
#define BLUENOISE_CORE_HPP

#include <bn/bn.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>
#include <string>
#include <system_error>

namespace bluenoise {

namespace py = pybind11;

/* Arrays from the Python side already have the right type. Inputs may have any memory order: pybind11 copies
 * those that are not C-ordered. Outputs are noconvert(), because a copy would be lost. */
using Ranks = py::array_t<uint32_t, py::array::c_style>;
using Floats = py::array_t<float, py::array::c_style>;
using Doubles = py::array_t<double, py::array::c_style>;

void bind_errors(py::module_ &module);
void bind_sampler(py::module_ &module);
void bind_masks(py::module_ &module);
void bind_neural(py::module_ &module);

/* Raises the exception for a result other than BN_SUCCESS; its message ends with `about` in brackets. Needs the
 * GIL. */
void check(bn_result result, const std::string &about = "");

/* Runs work() without the GIL and returns its result. */
template <typename Work>
bn_result unlocked(Work work) {
    py::gil_scoped_release release;
    return work();
}

/* A mask that borrows a 2-D array of ranks. */
inline bn_mask mask_of(const Ranks &ranks) {
    return bn_mask_u32(ranks.data(), static_cast<uint32_t>(ranks.shape(1)),
                       static_cast<uint32_t>(ranks.shape(0)));
}

/* A Python callable (or None) as a bn_progress. It receives the fraction done; returning true
 * cancels. Exceptions, including those from signal handlers, also cancel, and finish() raises them
 * again. Create and finish it with the GIL held; call() runs without it. */
class Progress {
  public:
    explicit Progress(py::object callable) : callable_(std::move(callable)) {}

    static int32_t call(void *self, double fraction) noexcept;

    /* Raises the exception that stopped the work, or else calls check(result). After success, passes 1 to the
     * callable if it has not received it yet. */
    void finish(bn_result result);

  private:
    /* Lets Ctrl-C interrupt the work: takes the GIL at most once per interval, and throws the exception
     * that a signal handler raised. */
    void poll();
    int32_t report(double fraction);

    static constexpr std::chrono::milliseconds interval{50};

    py::object callable_;
    double reported_ = 0;
    std::chrono::steady_clock::time_point last_poll_ = std::chrono::steady_clock::now();
    std::exception_ptr error_;
};

} // namespace bluenoise

#endif
