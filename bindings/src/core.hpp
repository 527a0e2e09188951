/* SPDX-License-Identifier: Apache-2.0
 * Shared by the files of the extension: exceptions, interrupts and progress. */
#ifndef BLUENOISE_CORE_HPP
#define BLUENOISE_CORE_HPP

#include <bn/bn.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chrono>
#include <cstdint>
#include <exception>
#include <string>

namespace bluenoise {

namespace py = pybind11;

/* Arrays from the Python side already have the right type and C order; nothing is converted here. */
using Ranks = py::array_t<uint32_t, py::array::c_style>;
using Floats = py::array_t<float, py::array::c_style>;

void bind_errors(py::module_ &module);
void bind_sampler(py::module_ &module);
void bind_masks(py::module_ &module);
void bind_images(py::module_ &module);
void bind_neural(py::module_ &module);

/* Raises the exception for a result other than BN_SUCCESS; `arguments` lists names and values for the
 * message. Needs the GIL. */
void check(bn_result result, const std::string &arguments);

/* The product of extents. Raises MemoryError if the array would exceed the address space. */
size_t checked_count(std::initializer_list<uint64_t> extents, size_t element_size);

/* Lets Ctrl-C interrupt long work that runs without the GIL: poll() takes the GIL at most every 50 ms
 * and throws what a signal handler raised. */
class Interrupts {
  public:
    void poll();

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/* A Python callable (or None) as a bn_progress. It receives the fraction done; a true result cancels.
 * Exceptions, including those from signal handlers, cancel too, and finish() raises them again.
 * Create and finish it with the GIL held; call() runs without it. */
class Progress {
  public:
    explicit Progress(py::object callable) : callable_(std::move(callable)) {}

    static int32_t call(void *self, double fraction) noexcept;

    /* Raises the exception that stopped the work, else calls check(result, arguments). */
    void finish(bn_result result, const std::string &arguments);

  private:
    py::object callable_;
    Interrupts interrupts_;
    std::exception_ptr error_;
};

} // namespace bluenoise

#endif
