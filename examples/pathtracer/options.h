// SPDX-License-Identifier: Apache-2.0
// The options, in one table: the command line, --help, the attributes of an EXR and --resume follow
// from it. Values are texts that were checked; main.cpp asks for them as numbers.
#pragma once

#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "math.h"

class Options {
  public:
    // Reads a command line. Throws Error.
    Options(int argc, const char *const *argv);

    // The options that decide samples. EXR files have them as attributes, named without the dashes.
    static const std::vector<std::string> &settings();
    static std::string help();

    bool given(const std::string &name) const { return given_.count(name) > 0; }
    const std::string &text(const std::string &name) const { return values_.at(name); }
    bool flag(const std::string &name) const { return text(name) == "1"; }
    // 0 if the option is neither given nor has a default.
    template <typename Number>
    Number number(const std::string &name) const {
        Number value{};
        std::from_chars(text(name).data(), text(name).data() + text(name).size(), value);
        return value;
    }
    std::vector<int> integers(const std::string &name) const;
    std::optional<Point3d> point(const std::string &name) const;

    // Sets an option that was not given. Throws Error if the option does not take this value.
    void set(const std::string &name, const std::string &value);
    // Checks options against each other; call it once a resumed image's are known. Throws Error.
    void check() const;

    std::vector<std::string> merge; // parts to merge instead of rendering

  private:
    void check_noise() const;

    std::map<std::string, std::string> values_;
    std::set<std::string> given_;
};
