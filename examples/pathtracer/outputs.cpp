// SPDX-License-Identifier: Apache-2.0
// The files of a picture. The preview's name is derived from the EXR's, so it is the one most
// likely to clash unexpectedly.
#include "outputs.h"

#include "error.h"
#include "exposure.h"
#include "output_file.h"
#include "png_image.h"
#include "scene_file.h"

namespace {

std::filesystem::path preview_path(const std::filesystem::path &exr) {
    return std::filesystem::path(exr).replace_extension(".png");
}

std::vector<NamedFile> output_files(const Options &options) {
    std::vector<NamedFile> files = {{"-o", options.output},
                                    {"the preview of -o", preview_path(options.output)}};
    if (!options.convergence.empty()) files.push_back({"--convergence", options.convergence});
    return files;
}

std::vector<NamedFile> input_files(const Options &options) {
    std::vector<NamedFile> files;
    for (const std::string &part : options.merge) files.push_back({"--merge", part});
    if (!options.reference.empty()) files.push_back({"--reference", options.reference});
    if (!options.resume.empty()) files.push_back({"--resume", options.resume});
    if (!options.merge.empty()) return files;
    for (const NamedFile &file : setting_files(options)) files.push_back(file);
    return files;
}

} // namespace

std::vector<NamedFile> setting_files(const Options &options) {
    return named_files(options.scene, options.environment, options.sampler.mask);
}

void check_file_names(const Options &options, const std::vector<NamedFile> &read) {
    std::vector<NamedFile> inputs = input_files(options);
    inputs.insert(inputs.end(), read.begin(), read.end());
    const std::vector<NamedFile> outputs = output_files(options);
    const auto other_name = [](const NamedFile &one, const NamedFile &other) {
        return one.path == other.path ? "" : " (as " + other.path.string() + ")";
    };
    for (size_t i = 0; i < outputs.size(); ++i) {
        for (size_t k = 0; k < i; ++k)
            if (is_same_file(outputs[i].path, outputs[k].path))
                throw Error(outputs[k].role + " and " + outputs[i].role + " would both write " +
                            outputs[k].path.string() + other_name(outputs[k], outputs[i]) +
                            "; give one of them another name");
        for (const NamedFile &input : inputs) {
            if (outputs[i].role == "-o" && input.role == "--resume") continue;
            if (is_same_file(outputs[i].path, input.path))
                throw Error(outputs[i].role + " would overwrite " + outputs[i].path.string() +
                            ", which " + input.role + " reads" + other_name(outputs[i], input) +
                            "; give the output another name");
        }
    }
}

Outputs::Outputs(const Options &options, const std::string &scene)
    : exr_(options.output), png_(preview_path(options.output)), csv_(options.convergence),
      exposure_(options.exposure) {
    if (!exposure_ && !options.auto_exposure && !is_scene_file(scene)) exposure_ = 0.0f;
    check_writable(exr_);
    check_writable(png_);
    if (!csv_.empty()) check_writable(csv_);
}

float Outputs::write(const Film &film, ExrAttributes attributes,
                     const std::vector<ConvergenceRow> &rows) const {
    attributes.exposure = exposure_.value_or(0);
    if (!exposure_) attributes.exposure = auto_exposure(film);
    std::vector<std::pair<std::filesystem::path, std::vector<char>>> files = {
        {exr_, exr_encode(film, attributes)},
        {png_, png_encode_preview(film_image(film), attributes.exposure)}};
    if (!csv_.empty()) files.push_back({csv_, convergence_csv(rows)});
    write_files(files);
    return attributes.exposure;
}
