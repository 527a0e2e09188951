// SPDX-License-Identifier: Apache-2.0
// Thrown when the program cannot continue: one line that says what is wrong and what to do.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

struct Error : std::runtime_error {
    // Of texts and whole numbers, one after the other.
    template <typename... Parts>
    explicit Error(const Parts &...parts)
        : runtime_error((std::ostringstream() << ... << parts).str()) {}
};

// Makes text from a file safe to print in a message: shortens it and replaces line breaks and
// control characters.
std::string printable(std::string text);

// The same without shortening it, for names of files and for whole messages.
std::string without_controls(std::string text);

// Prints one line to the standard error, after the name of the program.
void say(const std::string &message);

// Makes the program print one line and exit with code 1 instead of aborting: the libraries that
// read files can run out of memory inside noexcept functions.
void exit_where_it_would_abort();
