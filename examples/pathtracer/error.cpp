// SPDX-License-Identifier: Apache-2.0
// Cleaning text for error messages, and exiting cleanly when the program cannot even throw.
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

std::string printable(std::string text) {
    constexpr size_t LONGEST = 200;
    if (text.size() > LONGEST) text = text.substr(0, LONGEST) + "...";
    for (char &c : text)
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
    return text;
}

void exit_where_it_would_abort() {
    std::set_terminate(say_why_and_exit);
}
