/* SPDX-License-Identifier: Apache-2.0
 * What the files of the extension share: results as exceptions, interrupts and progress. */
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

/* Arrays as the Python side hands them over: right type, C order; nothing is converted here. */
using Ranks = py::array_t<uint32_t, py::array::c_style>;
using Floats = py::array_t<float, py::array::c_style>;

void bind_errors(py::module_ &module);
void bind_sampler(py::module_ &module);
void bind_masks(py::module_ &module);
void bind_images(py::module_ &module);
void bind_neural(py::module_ &module);

/* Raises the exception of a result that is not BN_SUCCESS; `arguments` names what was asked for,
 * with values. Needs the interpreter lock. */
void check(bn_result result, const std::string &arguments);

/* The product of extents, or MemoryError when it, times the element size, is beyond the address
 * space. */
size_t checked_count(std::initializer_list<uint64_t> extents, size_t element_size);

/* Lets Ctrl-C reach Python during long work without the interpreter lock: poll() takes the lock
 * every 50 ms at most and throws what a signal handler raised. */
class Interrupts {
  public:
    void poll();

  private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/* A Python callable (or None) as a bn_progress. The callable gets the fraction; a true result
 * cancels. An exception, also one from a signal handler, cancels too and is raised again by
 * finish(). Lives in a scope that holds the interpreter lock; call() is made without it. */
class Progress {
  public:
    explicit Progress(py::object callable) : callable_(std::move(callable)) {}

    static int32_t call(void *self, double fraction) noexcept;

    /* Raises what stopped the work, else does check(result, arguments). */
    void finish(bn_result result, const std::string &arguments);

  private:
    py::object callable_;
    Interrupts interrupts_;
    std::exception_ptr error_;
};

} // namespace bluenoise

#endif
