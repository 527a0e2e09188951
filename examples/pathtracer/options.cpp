// SPDX-License-Identifier: Apache-2.0
// The command line: one row per option; numbers are range-checked as they are read.
#include "options.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <thread>

#include "error.h"
#include "exr.h"

namespace {

constexpr int MAX_EXTENT = 65536; // pixels per side
constexpr uint32_t MAX_SPP = 1u << 24;
constexpr uint32_t MIN_SPP = 2; // for a variance
constexpr uint32_t ADAPTIVE_SPP = 1024;
constexpr float MAX_STOPS = 64;
constexpr uint32_t MAX_DEPTH = 1024;
constexpr uint32_t MAX_THREADS = 1024;
constexpr uint32_t MAX_LIGHT_SAMPLES = 256;
constexpr double MAX_SECONDS = 1e7;
constexpr double MIN_GIB = 0.25, MAX_GIB = 1e6;
constexpr double MAX_COORDINATE = 1e15;
constexpr double MIN_FOV = 1e-4; // degrees away from 0 and from 180

// What was given as an option: its name and its value.
struct Given {
    const std::string &name, &text;

    [[noreturn]] void refuse(const std::string &takes) const {
        throw Error(name, " takes ", takes, ", not '", text, "'");
    }
};
using Reader = std::function<void(const Given &)>;

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

// ---- What reads a value into an option

Reader text(std::string &to) {
    return [&](const Given &v) { to = v.text; };
}

template <typename Option, typename Number>
Reader number(Option &to, Number low, Number high, const std::string &takes) {
    return [=, &to](const Given &v) {
        Number value{};
        if (!parse_list(v.text, ' ', low, high, &value, 1)) v.refuse(takes);
        to = value;
    };
}

template <typename Option, typename Number>
Reader whole(Option &to, Number low, Number high) {
    return number(to, low, high,
                  "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
}

Reader point(std::optional<Point3d> &to) {
    return [&](const Given &v) {
        Point3d p;
        if (!parse_list(v.text, ',', -MAX_COORDINATE, MAX_COORDINATE, &p.x, 3))
            v.refuse("a point x,y,z with coordinates of at most 1e15");
        to = p;
    };
}

std::map<std::string, Reader> readers(Options &o) {
    return {
        {"--scene", text(o.scene)},
        {"--camera", whole(o.camera.number, 0u, UINT32_MAX)},
        {"--eye", point(o.camera.eye)},
        {"--target", point(o.camera.target)},
        {"--fov", number(o.camera.fov, MIN_FOV, 180 - MIN_FOV,
                         "the vertical angle of view in degrees, more than 0 and less than 180")},
        {"--sampler", text(o.sampler.name)},
        {"--spp", whole(o.spp, 1u, MAX_SPP)},
        {"--noise", number(o.noise.level, 0.0f, 1.0f,
                           "a relative error from 0, which is off, to 1, such as 0.05")},
        {"--min-spp", whole(o.noise.min_spp, MIN_SPP, MAX_SPP)},
        {"--declare", whole(o.sampler.declared_spp, 0u, UINT32_MAX)},
        {"--mask", text(o.sampler.mask)},
        {"--seed", whole(o.sampler.seed, uint64_t{0}, UINT64_MAX)},
        {"--first-sample", whole(o.first_sample, 0u, UINT32_MAX)},
        {"--size",
         [&](const Given &v) {
             int extents[2];
             if (!parse_list(v.text, 'x', 1, MAX_EXTENT, extents, 2))
                 v.refuse("WIDTHxHEIGHT, each from 1 to " + std::to_string(MAX_EXTENT));
             o.width = extents[0];
             o.height = extents[1];
         }},
        {"--crop",
         [&](const Given &v) {
             int c[4];
             if (!parse_list(v.text, ',', 0, MAX_EXTENT, c, 4) || c[0] >= c[2] || c[1] >= c[3])
                 v.refuse("x0,y0,x1,y1 with x0 < x1 and y0 < y1");
             o.crop = Crop{c[0], c[1], c[2], c[3]};
         }},
        {"--max-depth", whole(o.max_depth, 0u, MAX_DEPTH)},
        {"--light-samples", whole(o.light_samples, 1u, MAX_LIGHT_SAMPLES)},
        {"--lights",
         [&](const Given &v) {
             if (v.text != "coin") v.refuse("coin");
             o.light_samples = 0;
         }},
        {"--env", text(o.environment)},
        {"--threads", whole(o.threads, 1u, MAX_THREADS)},
        {"--max-memory",
         [&](const Given &v) {
             const char *const takes = "GiB, from 0.25 to 1000000, or 0 for no bound";
             number(o.max_memory, 0.0, MAX_GIB, takes)(v);
             if (*o.max_memory > 0 && *o.max_memory < MIN_GIB) v.refuse(takes);
         }},
        {"--resume", text(o.resume)},
        {"--time", number(o.time_limit, std::numeric_limits<double>::min(), MAX_SECONDS,
                          "seconds, more than 0 and at most 10000000")},
        {"--reference", text(o.reference)},
        {"--exposure",
         [&](const Given &v) {
             o.auto_exposure = v.text == "auto";
             o.exposure.reset();
             if (!o.auto_exposure)
                 number(o.exposure, -MAX_STOPS, MAX_STOPS, "stops from -64 to 64, or auto")(v);
         }},
        {"-o", text(o.output)},
    };
}

std::map<std::string, bool &> flags(Options &o) {
    return {
        {"--quiet", o.quiet},
        {"--single-scatter", o.single_scatter},
        {"--photometric", o.photometric},
        {"--clamp", o.clamp},
        {"--allow-outside", o.allow_outside},
        {"--allow-changed", o.allow_changed},
        {"--list", o.list},
        {"--list-cameras", o.list_cameras},
        {"--list-inputs", o.list_inputs},
        {"--help", o.help},
        {"-h", o.help},
    };
}

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

void check_options(const Options &o) {
    if (o.output.empty()) throw Error("name the output with -o out.exr (see --help)");
    if (o.output.size() < 5 || o.output.compare(o.output.size() - 4, 4, ".exr") != 0)
        throw Error("the output must be named something.exr, not '", o.output, "'");
    if (!o.merge.empty()) {
        if (!o.resume.empty()) throw Error("--merge does not render; leave out --resume");
        if (o.noise.level > 0) throw Error("--merge does not render; leave out --noise");
        return;
    }
    if (o.max_depth > MAX_DEPTH || o.light_samples.value_or(1) > MAX_LIGHT_SAMPLES ||
        o.spp > MAX_SPP || !(o.noise.level <= 1) || o.noise.min_spp < MIN_SPP ||
        o.noise.min_spp > MAX_SPP || std::abs(o.exposure.value_or(0)) > MAX_STOPS)
        throw Error(o.resume, " has impossible settings"); // the command line is range-checked
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

const char *options_help() {
    return R"(Usage: pathtracer [options] -o out.exr
       pathtracer --merge a.exr b.exr ... -o out.exr
       pathtracer --resume a.exr --spp N -o out.exr

Renders a scene with one of libbn's samplers to out.exr, and a preview to out.png beside it. Can also
merge pictures of different regions (--crop) or different samples (--first-sample), and continue a
picture that was stopped. When interrupted, it writes the picture so far.

  --scene NAME|FILE      the scene (default cornell): a built-in one (see --list), or a .gltf or .glb file
  --camera N             use the scene's camera number N (default 0); see --list-cameras
  --eye x,y,z            position of the camera
  --target x,y,z         point that the camera looks at
  --fov DEGREES          vertical angle of view; each of these three defaults to that of the scene's camera
  --sampler NAME         the sampler (default blue); see --list
  --spp N                samples per pixel (default 16)
  --noise LEVEL          take fewer samples where the estimated relative error as displayed falls below LEVEL,
                         such as 0.05; --spp is then the most (default 1024). Blocks of 8x8 pixels stop together
  --min-spp N            samples per pixel before --noise may stop a block (default 16)
  --declare N            number of samples per pixel to optimise "zorder" for (default 256); other samplers
                         ignore it
  --mask NAME|FILE       mask for the sampler "mask": builtin (default), neural, or a greyscale PNG
  --seed N               seed of the sampler (default 0)
  --first-sample N       index of the first sample of each pixel (default 0)
  --size WxH             size of the picture in pixels (default 512x512)
  --crop x0,y0,x1,y1     render only the pixels x0 <= x < x1, y0 <= y < y1; (0,0) is the top left
  --max-depth N          bounces, off surfaces and in fog (default 8); 0 shows only light that is seen directly
  --light-samples N      light samples at the first surface of each path (default: set by the scene)
  --lights coin          try no light apart from the path: one direction off each surface, from its material or
                         towards a light, as a coin decides
  --env FILE             replace the scene's environment by a latitude-longitude EXR, "sky" or "none"
  --clamp                bound texels of --env that are not finite, and negative ones
  --photometric          the file's punctual lights are in candela and lux: divide them by 683
  --allow-outside        let a scene file, or the picture of --resume, name files outside its folder
  --allow-changed        let --resume and --merge mix pictures whose files differ in contents
  --single-scatter       leave multiple scattering out of rough materials and of fog
  --threads N            number of threads (default: number of cores)
  --max-memory GIB       end with an error before the program takes more memory than this (default: half of the
                         machine's; 0: no bound)
  --resume a.exr         continue this picture, with its settings, to --spp N samples in each pixel
  --time SECONDS         stop after this time; without --spp there is no other limit
  --reference ref.exr    print the error against this picture: RMSE, plain and after Gaussian filters
  --exposure EV|auto     exposure of the preview in stops; auto maps the average to middle grey
                         (default: auto for files, 0 for built-in scenes)
  --quiet                print only errors, and the error against the reference
  --list                 list scenes and samplers
  --list-cameras         list the cameras of --scene as --eye, --target and --fov
  --list-inputs          list the files of --scene, --env and --mask, and all that the scene names, with their SHA-256
  --help                 print this text
)";
}

Options parse_options(int argc, const char *const *argv) {
    Options options;
    const auto with_value = readers(options);
    const auto without = flags(options);
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        if (name == "--merge") {
            while (i + 1 < argc && argv[i + 1][0] != '-') options.merge.emplace_back(argv[++i]);
            if (options.merge.empty())
                throw Error("--merge needs the pictures to merge; see --help");
        } else if (const auto flag = without.find(name); flag != without.end()) {
            flag->second = true;
        } else {
            const auto option = with_value.find(name);
            if (option == with_value.end())
                throw Error("there is no option '", name, "'; see --help");
            if (i + 1 == argc) throw Error(name, " needs a value; see --help");
            const std::string value = argv[++i];
            if (value.compare(0, 2, "--") == 0 || value == "-o" || value == "-h")
                throw Error(name, " needs a value, not the option '", value,
                            "'; write a file of that name as './", value, "'");
            options.given.insert(name);
            option->second({name, value});
        }
    }
    if (options.noise.level > 0 && options.given.count("--spp") == 0) options.spp = ADAPTIVE_SPP;
    if (options.time_limit > 0 && options.given.count("--spp") == 0) options.spp = MAX_SPP;
    if (!options.help && !options.list && !options.list_cameras && !options.list_inputs &&
        (options.resume.empty() || !options.merge.empty()))
        check_options(options);
    return options;
}
