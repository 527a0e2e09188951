// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include <charconv>
#include <cmath>
#include <iomanip>
#include <thread>

#include "exr.h"
#include "files.h"

namespace {

constexpr int MAX_EXTENT = 65536; // pixels per side
constexpr uint32_t MAX_SPP = 1u << 24;
constexpr uint32_t MIN_SPP = 2; // for a variance
constexpr uint32_t ADAPTIVE_SPP = 1024;
constexpr double MAX_COORDINATE = 1e15;
constexpr double MIN_FOV = 1e-4; // degrees away from 0 and from 180

// What a value should have been.
struct Wrong {
    std::string takes;
};

// Splits "12x34" or "1,2,3,4" into exactly `count` numbers in [low, high].
template <typename Number>
bool parse_list(const std::string &text, char separator, Number low, Number high, Number *values,
                int count) {
    const char *at = text.data(), *const end = at + text.size();
    for (int i = 0; i < count; ++i) {
        if (i > 0 && (at == end || *at++ != separator)) return false;
        const auto [stop, error] = std::from_chars(at, end, values[i]);
        if (error != std::errc() || !(values[i] >= low && values[i] <= high)) return false;
        at = stop;
    }
    return at == end;
}

std::string written(const std::string &value) {
    return value;
}
template <typename Number>
std::string written(const std::optional<Number> &value) {
    return value ? std::to_string(*value) : "";
}
template <typename Number>
std::string written(Number value) {
    std::ostringstream text;
    text << std::setprecision(9) << value;
    return text.str();
}

struct Table {
    std::vector<OptionRow> rows;

    // Adds an option whose value pictures store under this name, if it is not null.
    template <typename Option>
    void add(OptionRow row, const char *attribute, Option &option) {
        row.attribute = attribute;
        row.text = [&option] { return written(option); };
        rows.push_back(std::move(row));
    }
    void text(const char *name, const char *value, std::string &to, const char *help,
              const char *attribute = nullptr) {
        add({name, value, help, [&to](const std::string &v) { to = v; }}, attribute, to);
    }
    template <typename Option, typename Number>
    void number(const char *name, const char *value, Option &to, Number low, Number high,
                const std::string &takes, const char *help, const char *attribute = nullptr) {
        const auto read = [=, &to](const std::string &v) {
            Number given{};
            if (!parse_list(v, ' ', low, high, &given, 1)) throw Wrong{takes};
            to = given;
        };
        add({name, value, help, read}, attribute, to);
    }
    template <typename Option, typename Number>
    void whole(const char *name, Option &to, Number low, Number high, const char *help,
               const char *attribute = nullptr) {
        number(name, "N", to, low, high,
               "a whole number from " + std::to_string(low) + " to " + std::to_string(high), help,
               attribute);
    }
    void point(const char *name, std::optional<Point3d> &to, const char *help) {
        rows.push_back({name, "x,y,z", help, [&to](const std::string &v) {
                            Point3d p;
                            if (!parse_list(v, ',', -MAX_COORDINATE, MAX_COORDINATE, &p.x, 3))
                                throw Wrong{"a point x,y,z with coordinates of at most 1e15"};
                            to = p;
                        }});
    }
    void flag(const char *name, bool &to, const char *help, const char *attribute = nullptr) {
        add({name, "", help, [&to](const std::string &v) { to = v != "0"; }}, attribute, to);
    }
};

// Of adaptive sampling.
void check_noise(const Options &o) {
    if (!(o.noise.level > 0)) {
        if (o.given.count("--min-spp") > 0)
            throw Error("--min-spp goes with --noise; add it, or leave out --min-spp");
        return;
    }
    if (o.auto_exposure || (!o.exposure && is_scene_file(o.scene)))
        throw Error("--noise has to know the exposure before rendering; set it with --exposure EV");
    if (o.first_sample > 0)
        throw Error(o.given.count("--first-sample") > 0
                        ? "--noise needs the first samples of a pixel; leave out --first-sample, "
                          "and split the picture with --crop"
                        : "--noise needs the first samples of a pixel, but " + o.resume +
                              " begins with sample " + std::to_string(o.first_sample) +
                              "; continue it without --noise");
    if (o.spp <= o.noise.min_spp && o.given.count("--min-spp") == 0 && o.resume.empty())
        throw Error("--noise looks at pixels from --min-spp ", o.noise.min_spp,
                    " on; give more --spp than that, or a smaller --min-spp");
    if (o.noise.min_spp > o.spp && o.given.count("--min-spp") > 0)
        throw Error("--min-spp ", o.noise.min_spp, " is more than --spp ", o.spp);
}

} // namespace

std::vector<OptionRow> option_rows(Options &o) {
    Table t;
    t.text("--scene", "NAME|FILE", o.scene,
           "the scene (default cornell): a built-in one (see --list), or a .gltf or .glb file",
           "scene");
    t.whole("--camera", o.camera.number, 0u, UINT32_MAX,
            "use the scene's camera number N (default 0); see --list-cameras");
    t.point("--eye", o.camera.eye, "position of the camera");
    t.point("--target", o.camera.target, "point that the camera looks at");
    t.number("--fov", "DEGREES", o.camera.fov, MIN_FOV, 180 - MIN_FOV,
             "the vertical angle of view in degrees, more than 0 and less than 180",
             "vertical angle of view; these three default to those of the scene's camera");
    t.text("--sampler", "NAME", o.sampler.name, "the sampler (default blue); see --list",
           "sampler");
    t.whole("--spp", o.spp, 1u, MAX_SPP, "samples per pixel (default 16)");
    t.number("--noise", "LEVEL", o.noise.level, 0.0f, 1.0f,
             "a relative error from 0, which is off, to 1, such as 0.05",
             "take fewer samples where the estimated relative error as displayed is below LEVEL,\n"
             "such as 0.05; --spp is then the most (default 1024)",
             "noise");
    t.whole("--min-spp", o.noise.min_spp, MIN_SPP, MAX_SPP,
            "samples per pixel before --noise may stop a block (default 16)", "minSpp");
    t.whole("--declare", o.sampler.declared_spp, 0u, UINT32_MAX,
            "samples per pixel to optimise the sampler \"zorder\" for (default 256)",
            "declaredSpp");
    t.text("--mask", "NAME|FILE", o.sampler.mask,
           "mask for the sampler \"mask\": builtin (default), neural, or a greyscale PNG", "mask");
    t.whole("--seed", o.sampler.seed, uint64_t{0}, UINT64_MAX, "seed of the sampler (default 0)",
            "seed");
    t.whole("--first-sample", o.first_sample, 0u, UINT32_MAX,
            "index of the first sample of each pixel (default 0)");
    t.rows.push_back({"--size", "WxH", "size of the picture in pixels (default 512x512)",
                      [&o](const std::string &v) {
                          int extents[2];
                          if (!parse_list(v, 'x', 1, MAX_EXTENT, extents, 2))
                              throw Wrong{"WIDTHxHEIGHT, each from 1 to " +
                                          std::to_string(MAX_EXTENT)};
                          o.width = extents[0];
                          o.height = extents[1];
                      }});
    t.rows.push_back({"--crop", "x0,y0,x1,y1",
                      "render only the pixels x0 <= x < x1, y0 <= y < y1; (0,0) is the top left",
                      [&o](const std::string &v) {
                          int c[4];
                          if (!parse_list(v, ',', 0, MAX_EXTENT, c, 4) || c[0] >= c[2] ||
                              c[1] >= c[3])
                              throw Wrong{"x0,y0,x1,y1 with x0 < x1 and y0 < y1"};
                          o.crop = Crop{c[0], c[1], c[2], c[3]};
                      }});
    t.whole(
        "--max-depth", o.max_depth, 0u, 1024u,
        "bounces, off surfaces and in fog (default 8); 0 shows only light that is seen directly",
        "maxDepth");
    t.whole("--light-samples", o.light_samples, 1u, 256u,
            "light samples at the first surface of each path (default: set by the scene)");
    t.rows.push_back({"--lights", "coin",
                      "try no light apart from the path: one direction off each surface, from its\n"
                      "material or towards a light, as a coin decides",
                      [&o](const std::string &v) {
                          if (v != "coin") throw Wrong{"coin"};
                          o.light_samples = 0;
                      }});
    t.text("--env", "FILE", o.environment,
           "replace the scene's environment by a latitude-longitude EXR, \"sky\" or \"none\"",
           "environment");
    t.flag("--clamp", o.clamp, "bound texels of --env that are not finite", "clamp");
    t.flag("--photometric", o.photometric,
           "the file's punctual lights are in candela and lux: divide them by 683", "photometric");
    t.flag("--single-scatter", o.single_scatter,
           "leave multiple scattering out of rough materials and of fog", "singleScatter");
    t.flag("--allow-outside", o.allow_outside,
           "let a scene, or the picture of --resume, name files outside its folder");
    t.flag("--allow-changed", o.allow_changed,
           "let --resume and --merge mix pictures whose files differ in contents");
    t.whole("--threads", o.threads, 1u, 1024u, "number of threads (default: number of cores)");
    t.rows.push_back({"--max-memory", "GIB",
                      "end with an error before the program takes more memory than this (default:\n"
                      "half of the machine's; 0: no bound)",
                      [&o](const std::string &v) {
                          double gib;
                          if (!parse_list(v, ' ', 0.0, 1e6, &gib, 1) || (gib > 0 && gib < 0.25))
                              throw Wrong{"GiB, from 0.25 to 1000000, or 0 for no bound"};
                          o.max_memory = gib;
                      }});
    t.text("--resume", "a.exr", o.resume,
           "continue this picture, with its settings, to --spp N samples in each pixel");
    t.text("--reference", "ref.exr", o.reference,
           "print the error against this picture: RMSE, plain and after Gaussian filters");
    t.rows.push_back({"--exposure", "EV|auto",
                      "exposure of the preview in stops; auto maps the average to middle grey\n"
                      "(default: auto for files, 0 for built-in scenes)",
                      [&o](const std::string &v) {
                          float stops = 0;
                          o.auto_exposure = v == "auto";
                          o.exposure.reset();
                          if (o.auto_exposure) return;
                          if (!parse_list(v, ' ', -64.0f, 64.0f, &stops, 1))
                              throw Wrong{"stops from -64 to 64, or auto"};
                          o.exposure = stops;
                      }});
    t.text("-o", "out.exr", o.output, "the picture; a preview is written to out.png beside it");
    t.flag("--quiet", o.quiet, "print only errors, and the error against the reference");
    t.flag("--list", o.list, "list scenes and samplers");
    t.flag("--list-cameras", o.list_cameras,
           "list the cameras of --scene as --eye, --target, --fov");
    t.flag("--list-inputs", o.list_inputs,
           "list the files of --scene, --env and --mask, and all that the scene names, each with\n"
           "its CRC-32 and size");
    t.flag("--help", o.help, "print this text");
    return t.rows;
}

void option_read(const OptionRow &row, const std::string &value) {
    try {
        row.read(value);
    } catch (const Wrong &wrong) {
        throw Error(row.name, " takes ", wrong.takes, ", not '", value, "'");
    }
}

void check_options(const Options &o) {
    if (o.output.empty()) throw Error("name the output with -o out.exr (see --help)");
    if (o.output.size() < 5 || o.output.compare(o.output.size() - 4, 4, ".exr") != 0)
        throw Error("the output must be named something.exr, not '", o.output, "'");
    if (!o.merge.empty()) {
        for (const char *name : {"--resume", "--noise"})
            if (o.given.count(name) > 0) throw Error("--merge does not render; leave out ", name);
        return;
    }
    if (o.given.count("--lights") > 0 && o.given.count("--light-samples") > 0)
        throw Error(
            "--lights coin takes one direction off each surface; leave out --light-samples");
    const Crop crop = o.crop.value_or(Crop{0, 0, o.width, o.height});
    if (crop.x1 > o.width || crop.y1 > o.height)
        throw Error("--crop extends beyond the picture of ", o.width, "x", o.height,
                    " pixels; set --size");
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("at most ", MAX_PIXELS,
                    " pixels are rendered at once; render the picture in parts with --crop");
    check_noise(o);
    if (o.first_sample > UINT32_MAX - (o.spp - 1))
        throw Error("--first-sample and --spp run past the last sample, number ", UINT32_MAX);
}

std::string options_help() {
    std::string help = R"(Usage: pathtracer [options] -o out.exr
       pathtracer --merge a.exr b.exr ... -o out.exr
       pathtracer --resume a.exr --spp N -o out.exr

Renders a scene with one of libbn's samplers to out.exr, and a preview to out.png beside it. Can also
merge pictures of different regions (--crop) or different samples (--first-sample), and continue a
picture that was stopped. When interrupted, it writes the picture so far.

)";
    Options unused;
    for (const OptionRow &row : option_rows(unused)) {
        std::istringstream lines(row.help);
        std::string left = "  " + row.name + " " + row.value;
        for (std::string line; std::getline(lines, line); left.clear()) {
            left.resize(std::max(left.size() + 1, size_t{25}), ' ');
            help += left + line + "\n";
        }
    }
    return help;
}

Options parse_options(int argc, const char *const *argv) {
    Options options;
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    const std::vector<OptionRow> rows = option_rows(options);
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i] == std::string("-h") ? "--help" : argv[i];
        if (name == "--merge") {
            while (i + 1 < argc && argv[i + 1][0] != '-') options.merge.emplace_back(argv[++i]);
            if (options.merge.empty())
                throw Error("--merge needs the pictures to merge; see --help");
            continue;
        }
        const auto row = std::find_if(rows.begin(), rows.end(),
                                      [&](const OptionRow &r) { return r.name == name; });
        if (row == rows.end()) throw Error("there is no option '", name, "'; see --help");
        std::string value;
        if (!row->value.empty()) {
            if (i + 1 == argc) throw Error(name, " needs a value; see --help");
            value = argv[++i];
            if (value.compare(0, 2, "--") == 0 || value == "-o" || value == "-h")
                throw Error(name, " needs a value, not the option '", value,
                            "'; write a file of that name as './", value, "'");
        }
        options.given.insert(name);
        option_read(*row, value);
    }
    if (options.noise.level > 0 && options.given.count("--spp") == 0) options.spp = ADAPTIVE_SPP;
    if (!options.help && !options.list && !options.list_cameras && !options.list_inputs &&
        (options.resume.empty() || !options.merge.empty()))
        check_options(options);
    return options;
}
