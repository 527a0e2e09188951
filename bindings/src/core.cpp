/* SPDX-License-Identifier: Apache-2.0
 * Converts results to Python exceptions; handles Ctrl-C and progress callbacks. */
#include "core.hpp"

namespace bluenoise {

namespace {

/* Created once and kept for the process's lifetime, like extension modules. */
PyObject *cancelled_error = nullptr;
PyObject *runtime_missing_error = nullptr;

PyObject *new_error(py::module_ &module, const char *name, const char *doc) {
    py::exception<std::exception> error(module, name, PyExc_RuntimeError);
    error.attr("__module__") = "bluenoise";
    error.attr("__doc__") = doc;
    return error.release().ptr();
}

PyObject *exception_type(bn_result result) {
    switch (result) {
    case BN_ERROR_OUT_OF_MEMORY:
        return PyExc_MemoryError;
    case BN_ERROR_RUNTIME:
        return runtime_missing_error;
    case BN_ERROR_IO:
        return PyExc_OSError;
    case BN_ERROR_CANCELLED:
        return cancelled_error;
    default:
        return PyExc_ValueError;
    }
}

} // namespace

void bind_errors(py::module_ &module) {
    cancelled_error = new_error(module, "CancelledError",
                                "A progress callback stopped the work by returning a true value.");
    runtime_missing_error =
        new_error(module, "RuntimeMissingError",
                  "ONNX Runtime, which neural masks need, is missing or failed.");
}

void check(bn_result result, const std::string &about) {
    if (result == BN_SUCCESS) return;
    std::string message = bn_result_string(result);
    if (!about.empty()) message += " (" + about + ")";
    PyErr_SetString(exception_type(result), message.c_str());
    throw py::error_already_set();
}

void Progress::poll() {
    auto now = std::chrono::steady_clock::now();
    if (now - last_poll_ < interval) return;
    last_poll_ = now;
    py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

int32_t Progress::report(double fraction) {
    reported_ = fraction;
    py::object stop = callable_(fraction);
    int truth = PyObject_IsTrue(stop.ptr());
    if (truth < 0) throw py::error_already_set();
    return truth;
}

int32_t Progress::call(void *self, double fraction) noexcept {
    auto *progress = static_cast<Progress *>(self);
    try {
        progress->poll();
        if (progress->callable_.is_none()) return 0;
        py::gil_scoped_acquire lock;
        return progress->report(fraction);
    } catch (...) {
        progress->error_ = std::current_exception();
        return 1;
    }
}

void Progress::finish(bn_result result) {
    if (error_) std::rethrow_exception(error_);
    check(result);
    if (callable_.is_none() || reported_ >= 1) return;
    if (report(1) != 0) check(BN_ERROR_CANCELLED);
}

} // namespace bluenoise
