// SPDX-License-Identifier: Apache-2.0
// The files of a picture: the EXR and its preview.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "exr.h"
#include "input_file.h"
#include "options.h"

// The files that the settings of a picture name: scene, environment and mask, as far as they are
// files.
std::vector<NamedFile> setting_files(const Options &options);

// Throws Error if an output is also the other output, the reference, or one of `inputs`, under any
// name. Only the --resume picture may be replaced by -o.
void check_file_names(const Options &options, std::vector<NamedFile> inputs);

class Outputs {
  public:
    // Throws Error unless all files can be written. Construct before the first ray, so that a wrong
    // name costs nothing. `scene` decides the exposure if none is given.
    Outputs(const Options &options, const std::string &scene);

    // Replaces all files at once. Throws Error.
    void write(const Film &film, ExrAttributes attributes) const;

  private:
    std::filesystem::path exr_, png_;
    std::optional<float> exposure_; // automatic if empty
};
