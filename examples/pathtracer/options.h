// SPDX-License-Identifier: Apache-2.0
// The options, in one table from which the command line, --help, the EXR attributes and --resume are
// derived. Values are strings that have been checked; main.cpp gets them as numbers.
#pragma once

#include <charconv>
#include <map>
#include <optional>
#include <set>

#include "image.h"

class Options {
  public:
    // Reads a command line. Throws Error.
    Options(int argc, const char *const *argv);

    // The options that determine the samples: EXR attributes, named without the dashes.
    static std::vector<std::string> settings();
    static std::string help();

    bool given(const std::string &name) const { return given_.count(name) > 0; }
    const std::string &text(const std::string &name) const { return values_.at(name); }
    bool flag(const std::string &name) const { return text(name) == "1"; }
    // Whether blocks stop early.
    bool is_adaptive() const {
        return number<double>("--noise") > 0 || number<double>("--visible-noise") > 0;
    }
    // 0 if the option is absent and has no default.
    template <typename Number>
    Number number(const std::string &name) const {
        Number value{};
        std::from_chars(text(name).data(), text(name).data() + text(name).size(), value);
        return value;
    }
    template <typename Number>
    std::optional<Number> optional(const std::string &name) const {
        return text(name).empty() ? std::nullopt : std::optional(number<Number>(name));
    }
    std::vector<int> integers(const std::string &name) const;
    std::optional<Point3d> point(const std::string &name) const;
    Crop crop() const; // the whole image by default
    // Whether the exposure is derived from the image, for this scene.
    bool has_auto_exposure(const std::string &scene) const;

    // Sets an option that was not passed. Throws Error if the option does not take this value.
    void set(const std::string &name, const std::string &value);
    // Checks that the options, including those of a resumed image, are consistent. Throws Error.
    void check() const;

    std::vector<std::string> merge; // parts to merge instead of rendering

  private:
    std::map<std::string, std::string> values_;
    std::set<std::string> given_;
};
