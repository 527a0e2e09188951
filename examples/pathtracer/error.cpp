// SPDX-License-Identifier: Apache-2.0
// The last words of a program that cannot even throw.
#include "error.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

namespace {

[[noreturn]] void say_why_and_exit() {
    const char *why = "stopped by an internal error";
    try {
        if (std::current_exception()) std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc &) {
        why = "out of memory";
    } catch (...) {
    }
    std::fprintf(stderr, "pathtracer: %s\n", why);
    std::_Exit(1);
}

} // namespace

void exit_where_it_would_abort() {
    std::set_terminate(say_why_and_exit);
}
