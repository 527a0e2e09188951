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
        why = "out of memory; --max-memory allows more, where there is more";
    } catch (...) {
    }
    std::fprintf(stderr, "pathtracer: %s\n", why);
    std::_Exit(1);
}

} // namespace

std::string printable(std::string text) {
    constexpr size_t LONGEST = 200;
    if (text.size() > LONGEST) text = text.substr(0, LONGEST) + "...";
    return without_controls(text);
}

std::string without_controls(std::string text) {
    for (size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        // In UTF-8, a second set of controls from U+0080 to U+009F: some terminals obey them.
        const bool second =
            c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0;
        if (c < 32 || c == 127 || second) text[i] = '?';
        if (second) text[i + 1] = '?';
    }
    return text;
}

void say(const std::string &message) {
    std::fprintf(stderr, "pathtracer: %s\n", without_controls(message).c_str());
}

void exit_where_it_would_abort() {
    std::set_terminate(say_why_and_exit);
}
