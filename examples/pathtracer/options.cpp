// SPDX-License-Identifier: Apache-2.0
// The command line: one row per option; numbers are range-checked as they are read.
#include "options.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <thread>

#include "error.h"
#include "exr.h"
#include "scene_file.h"

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

// Parses the whole text as a number in [low, high].
template <typename Number>
bool parse_number(const std::string &text, Number low, Number high, Number &value) {
    const char *end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end && value >= low && value <= high;
}

// Splits "12x34" or "1,2,3,4" into exactly `count` numbers.
template <typename Number>
bool parse_list(const std::string &text, char separator, Number low, Number high, Number *values,
                int count) {
    size_t begin = 0;
    for (int i = 0; i < count; ++i) {
        const size_t end = i + 1 < count ? text.find(separator, begin) : text.size();
        if (end == std::string::npos) return false;
        if (!parse_number(text.substr(begin, end - begin), low, high, values[i])) return false;
        begin = end + 1;
    }
    return true;
}

// What was given as an option: its name and its value.
struct Given {
    const std::string &name, &text;

    [[noreturn]] void refuse(const std::string &takes) const {
        throw Error(name + " takes " + takes + ", not '" + text + "'");
    }
    template <typename Number>
    Number number(Number low, Number high, const std::string &takes) const {
        Number value{};
        if (!parse_number(text, low, high, value)) refuse(takes);
        return value;
    }
    template <typename Number>
    Number whole(Number low, Number high) const {
        return number(low, high,
                      "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    Point3d point() const {
        double v[3];
        if (!parse_list(text, ',', -MAX_COORDINATE, MAX_COORDINATE, v, 3))
            refuse("a point x,y,z with coordinates of at most 1e15");
        return {v[0], v[1], v[2]};
    }
};

const std::map<std::string, bool Options::*> FLAGS = {
    {"--quiet", &Options::quiet},
    {"--single-scatter", &Options::single_scatter},
    {"--photometric", &Options::photometric},
    {"--allow-outside", &Options::allow_outside},
    {"--allow-changed", &Options::allow_changed},
    {"--list", &Options::list},
    {"--list-cameras", &Options::list_cameras},
    {"--list-inputs", &Options::list_inputs},
    {"--help", &Options::help},
    {"-h", &Options::help},
};

const std::map<std::string, void (*)(Options &, const Given &)> WITH_VALUE = {
    {"--scene", [](Options &o, const Given &v) { o.scene = v.text; }},
    {"--camera", [](Options &o, const Given &v) { o.camera.number = v.whole(0u, UINT32_MAX); }},
    {"--eye", [](Options &o, const Given &v) { o.camera.eye = v.point(); }},
    {"--target", [](Options &o, const Given &v) { o.camera.target = v.point(); }},
    {"--fov",
     [](Options &o, const Given &v) {
         o.camera.fov =
             v.number(MIN_FOV, 180 - MIN_FOV,
                      "the vertical angle of view in degrees, more than 0 and less than 180");
     }},
    {"--sampler", [](Options &o, const Given &v) { o.sampler.name = v.text; }},
    {"--spp", [](Options &o, const Given &v) { o.spp = v.whole(1u, MAX_SPP); }},
    {"--noise",
     [](Options &o, const Given &v) {
         o.noise =
             v.number(0.0f, 1.0f, "a relative error from 0, which is off, to 1, such as 0.05");
     }},
    {"--min-spp", [](Options &o, const Given &v) { o.min_spp = v.whole(MIN_SPP, MAX_SPP); }},
    {"--declare",
     [](Options &o, const Given &v) { o.sampler.declared_spp = v.whole(0u, UINT32_MAX); }},
    {"--mask", [](Options &o, const Given &v) { o.sampler.mask = v.text; }},
    {"--seed",
     [](Options &o, const Given &v) { o.sampler.seed = v.whole<uint64_t>(0, UINT64_MAX); }},
    {"--first-sample",
     [](Options &o, const Given &v) { o.first_sample = v.whole(0u, UINT32_MAX); }},
    {"--size",
     [](Options &o, const Given &v) {
         int extents[2];
         if (!parse_list(v.text, 'x', 1, MAX_EXTENT, extents, 2))
             v.refuse("WIDTHxHEIGHT, each from 1 to " + std::to_string(MAX_EXTENT));
         o.width = extents[0];
         o.height = extents[1];
     }},
    {"--crop",
     [](Options &o, const Given &v) {
         int c[4];
         if (!parse_list(v.text, ',', 0, MAX_EXTENT, c, 4) || c[0] >= c[2] || c[1] >= c[3])
             v.refuse("x0,y0,x1,y1 with x0 < x1 and y0 < y1");
         o.crop = Crop{c[0], c[1], c[2], c[3]};
     }},
    {"--max-depth", [](Options &o, const Given &v) { o.max_depth = v.whole(0u, MAX_DEPTH); }},
    {"--light-samples",
     [](Options &o, const Given &v) { o.light_samples = v.whole(1u, MAX_LIGHT_SAMPLES); }},
    {"--lights",
     [](Options &o, const Given &v) {
         if (v.text != "coin") v.refuse("coin");
         o.light_samples = 0;
     }},
    {"--env", [](Options &o, const Given &v) { o.environment = v.text; }},
    {"--threads", [](Options &o, const Given &v) { o.threads = v.whole(1u, MAX_THREADS); }},
    {"--max-memory",
     [](Options &o, const Given &v) {
         o.max_memory = v.number(0.0, MAX_GIB, "GiB, from 0.25 to 1000000, or 0 for no bound");
         if (*o.max_memory > 0 && *o.max_memory < MIN_GIB)
             v.refuse("GiB, from 0.25 to 1000000, or 0 for no bound");
     }},
    {"--resume", [](Options &o, const Given &v) { o.resume = v.text; }},
    {"--time",
     [](Options &o, const Given &v) {
         o.time_limit = v.number(std::numeric_limits<double>::min(), MAX_SECONDS,
                                 "seconds, more than 0 and at most 10000000");
     }},
    {"--reference", [](Options &o, const Given &v) { o.reference = v.text; }},
    {"--exposure",
     [](Options &o, const Given &v) {
         o.auto_exposure = v.text == "auto";
         o.exposure.reset();
         if (!o.auto_exposure)
             o.exposure = v.number(-MAX_STOPS, MAX_STOPS, "stops from -64 to 64, or auto");
     }},
    {"-o", [](Options &o, const Given &v) { o.output = v.text; }},
};

// Of adaptive sampling.
void check_noise(const Options &o) {
    if (!(o.noise > 0)) {
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
    if (o.spp <= o.min_spp && o.given.count("--min-spp") == 0 && o.resume.empty())
        throw Error("--noise looks at pixels from --min-spp " + std::to_string(o.min_spp) +
                    " on; give more --spp than that, or a smaller --min-spp");
    if (o.min_spp > o.spp && o.given.count("--min-spp") > 0)
        throw Error("--min-spp " + std::to_string(o.min_spp) + " is more than --spp " +
                    std::to_string(o.spp));
}

} // namespace

void check_options(const Options &o) {
    if (o.output.empty()) throw Error("name the output with -o out.exr (see --help)");
    if (o.output.size() < 5 || o.output.compare(o.output.size() - 4, 4, ".exr") != 0)
        throw Error("the output must be named something.exr, not '" + o.output + "'");
    if (!o.merge.empty()) {
        if (!o.resume.empty()) throw Error("--merge does not render; leave out --resume");
        if (o.noise > 0) throw Error("--merge does not render; leave out --noise");
        return;
    }
    if (o.max_depth > MAX_DEPTH || o.light_samples.value_or(1) > MAX_LIGHT_SAMPLES ||
        o.spp > MAX_SPP || !(o.noise <= 1) || o.min_spp < MIN_SPP || o.min_spp > MAX_SPP ||
        std::abs(o.exposure.value_or(0)) > MAX_STOPS)
        throw Error(o.resume + " has impossible settings"); // the command line is range-checked
    if (o.given.count("--lights") > 0 && o.given.count("--light-samples") > 0)
        throw Error(
            "--lights coin takes one direction off each surface; leave out --light-samples");
    const Crop crop = o.crop.value_or(Crop{0, 0, o.width, o.height});
    if (crop.x1 > o.width || crop.y1 > o.height)
        throw Error("--crop extends beyond the picture of " + std::to_string(o.width) + "x" +
                    std::to_string(o.height) + " pixels; set --size");
    if (pixel_count(crop) > MAX_PIXELS)
        throw Error("at most " + std::to_string(MAX_PIXELS) +
                    " pixels are rendered at once; render the picture in parts with --crop");
    check_noise(o);
    if (o.first_sample > UINT32_MAX - (o.spp - 1))
        throw Error("--first-sample and --spp run past the last sample, number " +
                    std::to_string(UINT32_MAX));
}

const char *options_help() {
    return R"(Usage: pathtracer [options] -o out.exr
       pathtracer --merge a.exr b.exr ... -o out.exr
       pathtracer --resume a.exr --spp N -o out.exr

Renders a scene with one of libbn's samplers to out.exr, and a preview to out.png beside it. Can also
merge pictures of different regions (--crop) or different samples (--first-sample), and continue a
picture that was stopped. When interrupted, it writes the picture so far.

  --scene NAME|FILE      the scene (default cornell): a built-in one (see --list), or a .gltf, .glb or .obj file
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
    options.threads = std::max(1u, std::thread::hardware_concurrency());
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        if (name == "--merge") {
            while (i + 1 < argc && argv[i + 1][0] != '-') options.merge.emplace_back(argv[++i]);
            if (options.merge.empty())
                throw Error("--merge needs the pictures to merge; see --help");
        } else if (const auto flag = FLAGS.find(name); flag != FLAGS.end()) {
            options.*flag->second = true;
        } else {
            const auto option = WITH_VALUE.find(name);
            if (option == WITH_VALUE.end())
                throw Error("there is no option '" + name + "'; see --help");
            if (i + 1 == argc) throw Error(name + " needs a value; see --help");
            const std::string value = argv[++i];
            if (value.compare(0, 2, "--") == 0 || value == "-o" || value == "-h")
                throw Error(name + " needs a value, not the option '" + value +
                            "'; write a file of that name as './" + value + "'");
            options.given.insert(name);
            option->second(options, {name, value});
        }
    }
    if (options.noise > 0 && options.given.count("--spp") == 0) options.spp = ADAPTIVE_SPP;
    if (options.time_limit > 0 && options.given.count("--spp") == 0) options.spp = MAX_SPP;
    if (!options.help && !options.list && !options.list_cameras && !options.list_inputs &&
        (options.resume.empty() || !options.merge.empty()))
        check_options(options);
    return options;
}
