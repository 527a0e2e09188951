// SPDX-License-Identifier: Apache-2.0
// What is thrown when a run cannot go on: one line that says what was wrong and what to do.
#pragma once

#include <stdexcept>

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};
