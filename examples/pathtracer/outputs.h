// SPDX-License-Identifier: Apache-2.0
// The files of a picture: the EXR, its preview, and the error over the run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "difference.h"
#include "exr.h"
#include "input_file.h"
#include "options.h"

// The files that the settings of a picture name: scene, environment and mask, as far as they are
// files.
std::vector<NamedFile> setting_files(const Options &options);

// Throws Error if an output is also another output or an input, under any name. Only the --resume
// picture may be replaced by -o. With --resume, call this once the picture's settings are known.
// `read` are inputs that the options do not name.
void check_file_names(const Options &options, const std::vector<NamedFile> &read = {});

class Outputs {
  public:
    // Throws Error unless all files can be written. Construct before the first ray, so that a wrong
    // name costs nothing. `scene` decides the exposure if none is given.
    Outputs(const Options &options, const std::string &scene);

    // Replaces all files at once. Returns the exposure of the preview. Throws Error.
    float write(const Film &film, ExrAttributes attributes,
                const std::vector<ConvergenceRow> &rows) const;

    bool wants_convergence() const { return !csv_.empty(); }

  private:
    std::filesystem::path exr_, png_, csv_; // csv_ may be empty
    std::optional<float> exposure_;         // automatic if empty
};

// Ends the program by a signal, without leaving temporary files behind: a signal handler.
void end_without_temporary_files(int signal);

// Does so for SIGINT, SIGTERM and SIGHUP, except those that are ignored.
void remove_temporary_files_when_killed();
