// SPDX-License-Identifier: Apache-2.0
// What is thrown when a run cannot go on: one line that says what was wrong and what to do.
#pragma once

#include <stdexcept>
#include <string>

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// A text out of a file as a part of a line: no ends of lines, no commands to a terminal, no novels.
std::string printable(std::string text);

// Ends the program with one line and exit code 1 where it would abort: libraries that read files
// run out of memory in functions that no exception may leave.
void exit_where_it_would_abort();
