// SPDX-License-Identifier: Apache-2.0
// Thrown when the program cannot continue: one line that says what is wrong and what to do.
#pragma once

#include <stdexcept>
#include <string>

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Text from a file, shortened and without line breaks or control characters, so that it can be part
// of a message.
std::string printable(std::string text);

// Makes the program end with one line and exit code 1 where it would abort: the libraries that read
// files can run out of memory in functions that are noexcept.
void exit_where_it_would_abort();
