// SPDX-License-Identifier: Apache-2.0
// One row per option: default, range, help. set() checks one value, check() combinations; main.cpp checks
// what needs the scene and the files.
#include "options.h"

#include <bn/bn.h>
#include <unistd.h>

#include "files.h"
#include "film.h"
#include "scene.h"

namespace {

constexpr int MAX_EXTENT = 65536; // pixels per side
constexpr double MAX_SPP = 1 << 24, MAX_INDEX = UINT32_MAX, MAX_SEED = 0x1p64;
constexpr double MAX_COORDINATE = 1e15;
constexpr double MAX_OFFSET = 1 << 30; // pixels
constexpr double MIN_FOV = 1e-4;       // degrees away from 0 and from 180

// The type of an option's value.
enum Kind { FLAG, TEXT, FILTER, WHOLE, REAL, STOPS, POINT, OFFSET, EXTENT, REGION };

struct Row {
    const char *name, *value, *otherwise; // `otherwise`: the default
    Kind kind;
    double low, high;
    bool setting;
    const char *help;
};

const Row ROWS[] = {
    {"--scene", "NAME|FILE", "cornell", TEXT, 0, 0, true,
     "the scene (default cornell): a built-in one (see --list), or a .gltf or .glb file"},
    {"--camera", "N", "", WHOLE, 0, MAX_INDEX, false,
     "use the scene's camera number N (default 0); see --list-cameras"},
    {"--eye", "x,y,z", "", POINT, -MAX_COORDINATE, MAX_COORDINATE, false, "position of the camera"},
    {"--target", "x,y,z", "", POINT, -MAX_COORDINATE, MAX_COORDINATE, false,
     "point that the camera looks at"},
    {"--fov", "DEGREES", "", REAL, MIN_FOV, 180 - MIN_FOV, false,
     "vertical angle of view; the default for these three is the scene's camera"},
    {"--lens", "RADIUS", "", REAL, 0, MAX_COORDINATE, true,
     "radius of the camera's lens, in the scene's unit; 0: a pinhole (default: the scene's)"},
    {"--focus", "DISTANCE", "", REAL, 0, MAX_COORDINATE, true,
     "distance from the lens to the plane in focus (default: the scene's, or the target's)"},
    {"--sampler", "NAME", "blue", TEXT, 0, 0, true,
     "the sampler (default blue): see --list; or your own in a shared library, ./FILE.so\n"
     "or ./FILE.so:ARGUMENT (sampler_plugin.h)"},
    {"--spp", "N", "16", WHOLE, 1, MAX_SPP, false, "samples per pixel (default 16)"},
    {"--noise", "LEVEL", "0", REAL, 0, 1, true,
     "take fewer samples where the estimated relative error as displayed is below LEVEL,\n"
     "such as 0.05; --spp is then the maximum (default 1024)"},
    {"--visible-noise", "STEPS", "0", REAL, 0, 255, true,
     "take samples until a viewer sees less noise than STEPS steps of an 8-bit display, such\n"
     "as 1; --spp is then the maximum (default 1024)"},
    {"--min-spp", "N", "", WHOLE, 2, MAX_SPP, true,
     "samples per pixel before a block may stop (default 16; --visible-noise: 4)"},
    {"--declare", "N", "0", WHOLE, 0, MAX_INDEX, true,
     "samples per pixel to tune the sampler \"zorder\" for (default 256)"},
    {"--seed", "N", "0", WHOLE, 0, MAX_SEED, true, "seed of the sampler (default 0)"},
    {"--draw-offset", "dx,dy", "", OFFSET, -MAX_OFFSET, MAX_OFFSET, true,
     "give pixel (x, y) the draws of pixel (x - dx, y - dy), so that noise follows a\n"
     "moving image (default 0,0)"},
    {"--filter", "NAME", "", FILTER, 0, 0, true,
     "the pixel filter: box (default), or gaussian with a radius of 1.5 pixels and a\n"
     "standard deviation of 0.5"},
    {"--first-sample", "N", "0", WHOLE, 0, MAX_INDEX, false,
     "index of the first sample of each pixel (default 0)"},
    {"--size", "WxH", "512x512", EXTENT, 1, MAX_EXTENT, false,
     "size of the image in pixels (default 512x512)"},
    {"--crop", "x0,y0,x1,y1", "", REGION, 0, MAX_EXTENT, false,
     "render only the pixels x0 <= x < x1, y0 <= y < y1; (0,0) is the top left"},
    {"--max-depth", "N", "8", WHOLE, 0, 1024, true,
     "maximum bounces, off surfaces and in fog (default 8); 0 shows only directly visible light"},
    {"--light-samples", "N", "", WHOLE, 1, 256, true,
     "light samples at the first surface of each path (default: set by the scene)"},
    {"--env", "FILE", "", TEXT, 0, 0, true,
     "replace the scene's environment by a latitude-longitude EXR, \"sky\" or \"none\""},
    {"--clamp", "", "0", FLAG, 0, 0, true, "clamp texels of --env that are not finite"},
    {"--photometric", "", "0", FLAG, 0, 0, true,
     "the file's punctual lights are in candela and lux: divide them by 683"},
    {"--threads", "N", "", WHOLE, 1, 1024, false,
     "number of threads (default: the CPUs that it may use)"},
    {"--max-memory", "GIB", "", REAL, 0, 1e6, false,
     "fail before the program uses more memory than this (default: half of the\n"
     "machine's memory; 0: no limit)"},
    {"--resume", "a.exr", "", TEXT, 0, 0, false,
     "continue this image, with its settings, to --spp N samples per pixel"},
    {"--exposure", "EV|auto", "", STOPS, -64, 64, false,
     "exposure of the preview in stops; auto maps the average to middle grey\n"
     "(default: auto for files, 0 for built-in scenes)"},
    {"-o", "out.exr", "", TEXT, 0, 0, false,
     "the image; a preview is written to out.png beside it"},
    {"--quiet", "", "0", FLAG, 0, 0, false, "print only errors and warnings"},
    {"--list", "", "0", FLAG, 0, 0, false, "list scenes and samplers"},
    {"--list-cameras", "", "0", FLAG, 0, 0, false,
     "list the cameras of --scene as --eye, --target, --fov"},
    {"--list-inputs", "", "0", FLAG, 0, 0, false,
     "list the files of --scene and --env, and all files that the scene uses, with\n"
     "their CRC-32 and size"},
    {"--help", "", "0", FLAG, 0, 0, false, "print this text"},
};

const Row &row_of(const std::string &name) {
    const auto row = std::find_if(std::begin(ROWS), std::end(ROWS),
                                  [&](const Row &r) { return r.name == name; });
    if (row == std::end(ROWS)) throw Error("there is no option '", name, "'; see --help");
    return *row;
}

// The numbers in "12x34" or "1,2,3,4"; none if the text contains anything else.
template <typename Number>
std::vector<Number> split(const std::string &text) {
    std::vector<Number> numbers;
    const char *at = text.data(), *const end = at + text.size();
    for (;; ++at) {
        Number number{};
        const auto [stop, error] = std::from_chars(at, end, number);
        if (error != std::errc()) return {};
        numbers.push_back(number);
        if (stop == end) return numbers;
        if (*stop != (text.find('x') != std::string::npos ? 'x' : ',')) return {};
        at = stop;
    }
}

std::string takes(const Row &row) {
    if (row.kind == FILTER) return "box or gaussian";
    if (row.kind == REGION) return "x0,y0,x1,y1 with x0 < x1 and y0 < y1";
    const bool whole = row.kind == WHOLE || row.kind == OFFSET || row.kind == EXTENT;
    return joined(row.value, whole ? ": whole numbers from " : ": numbers from ", shortest(row.low),
                  " to ", row.high < MAX_SEED ? shortest(row.high) : joined(UINT64_MAX));
}

// Whether an option takes this value.
bool fits(const Row &row, const std::string &value) {
    if (row.kind == FLAG) return value == "0" || value == "1";
    if (row.kind == TEXT || (row.kind == STOPS && value == "auto")) return true;
    if (row.kind == FILTER) return value == "box" || value == "gaussian";
    const auto in_range = [&](auto numbers, size_t count) {
        const auto inside = [&](auto number) {
            return double(number) >= row.low && double(number) <= row.high;
        };
        return numbers.size() == count && std::all_of(numbers.begin(), numbers.end(), inside);
    };
    if (row.kind == WHOLE) return in_range(split<uint64_t>(value), 1);
    if (row.kind == OFFSET || row.kind == EXTENT) return in_range(split<int>(value), 2);
    if (row.kind != REGION) return in_range(split<double>(value), row.kind == POINT ? 3 : 1);
    const std::vector<int> c = split<int>(value);
    return in_range(c, 4) && c[0] < c[2] && c[1] < c[3];
}

void check_noise(const Options &o) {
    const auto spp = o.number<uint64_t>("--spp"), least = o.number<uint64_t>("--min-spp");
    if (!o.is_adaptive()) {
        if (o.given("--min-spp")) throw Error("--min-spp needs --noise or --visible-noise");
        return;
    }
    const bool relative = o.number<double>("--noise") > 0;
    const char *const rule = relative ? "--noise" : "--visible-noise";
    if (relative && o.number<double>("--visible-noise") > 0)
        throw Error("--noise and --visible-noise exclude each other; leave out one");
    if (o.has_auto_exposure(o.text("--scene")))
        throw Error(rule, " needs a fixed exposure; set --exposure EV, which other renders print");
    if (o.text("--first-sample") != "0")
        throw Error(rule, " needs the first samples of a pixel; leave out --first-sample");
    if (least > spp) throw Error("--min-spp ", least, " is more than --spp ", spp);
}

} // namespace

std::vector<std::string> Options::settings() {
    std::vector<std::string> names;
    for (const Row &row : ROWS)
        if (row.setting) names.push_back(row.name);
    return names;
}

std::vector<int> Options::integers(const std::string &name) const {
    return split<int>(text(name));
}

std::optional<Point3d> Options::point(const std::string &name) const {
    const std::vector<double> p = split<double>(text(name));
    return p.empty() ? std::nullopt : std::optional<Point3d>({p[0], p[1], p[2]});
}

Crop Options::crop() const {
    const std::vector<int> size = integers("--size"), c = integers("--crop");
    return c.empty() ? Crop{0, 0, size[0], size[1]} : Crop{c[0], c[1], c[2], c[3]};
}

bool Options::has_auto_exposure(const std::string &scene) const {
    const std::string &exposure = text("--exposure");
    return exposure == "auto" || (exposure.empty() && is_scene_file(scene));
}

void Options::set(const std::string &name, const std::string &value) {
    const Row &row = row_of(name);
    if (!fits(row, value)) throw Error(name, " takes ", takes(row), ", not '", value, "'");
    // Uses the program's number format, so that settings can be compared as strings. Images of older versions
    // lack some settings, whose defaults are therefore empty.
    std::string &own = values_[name] = value;
    if (row.kind == WHOLE) own = std::to_string(split<uint64_t>(value)[0]);
    if (row.kind == REAL) own = shortest(split<double>(value)[0]);
    if (row.kind == OFFSET) {
        const std::vector<int> d = split<int>(value);
        own = d[0] == 0 && d[1] == 0 ? "" : joined(d[0], ",", d[1]);
    }
    if (own == "box" && row.kind == FILTER) own.clear();
}

Options::Options(int argc, const char *const *argv) {
    for (const Row &row : ROWS) values_[row.name] = row.otherwise;
    values_["--threads"] = std::to_string(bn_thread_count());
    const double bytes = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    values_["--max-memory"] = shortest(0.5 * bytes / (1024 * 1024 * 1024));
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i] == std::string("-h") ? "--help" : argv[i];
        if (name == "--merge") {
            while (i + 1 < argc && argv[i + 1][0] != '-') merge.emplace_back(argv[++i]);
            if (merge.empty()) throw Error("--merge needs the images to merge; see --help");
            continue;
        }
        std::string value = "1";
        if (row_of(name).kind != FLAG) {
            if (i + 1 == argc) throw Error(name, " needs a value; see --help");
            value = argv[++i];
            if (value.compare(0, 2, "--") == 0 || value == "-o" || value == "-h")
                throw Error(name, " needs a value, not '", value, "'; name a file './", value, "'");
        }
        set(name, value);
        given_.insert(name);
    }
    if (is_adaptive() && !given("--spp")) values_["--spp"] = "1024";
    if (!given("--min-spp"))
        values_["--min-spp"] = number<double>("--visible-noise") > 0 ? "4" : "16";
    if (text("--resume").empty() || !merge.empty()) check();
}

std::string Options::help() {
    std::string help = R"(Usage: pathtracer [options] -o out.exr
       pathtracer --merge a.exr b.exr ... -o out.exr
       pathtracer --resume a.exr --spp N -o out.exr

Renders a scene with one of libbn's samplers to out.exr, and a preview to out.png beside it. Can also
merge images of different regions (--crop) or different samples (--first-sample), and continue an
image that was stopped. When interrupted, it writes the image so far.

)";
    for (const Row &row : ROWS) {
        std::istringstream lines(row.help);
        std::string left = std::string("  ") + row.name + " " + row.value;
        for (std::string line; std::getline(lines, line); left.clear()) {
            left.resize(std::max(left.size() + 1, size_t{25}), ' ');
            help += left + line + "\n";
        }
    }
    return help;
}

void Options::check() const {
    for (const char *name : {"--help", "--list", "--list-cameras", "--list-inputs"})
        if (flag(name)) return;
    const std::string &output = text("-o");
    if (output.empty()) throw Error("name the output with -o out.exr (see --help)");
    if (output.size() < 5 || output.compare(output.size() - 4, 4, ".exr") != 0)
        throw Error("the output must be named something.exr, not '", output, "'");
    if (!merge.empty()) {
        for (const char *name : {"--resume", "--noise", "--visible-noise"})
            if (given(name)) throw Error("--merge does not render; leave out ", name);
        return;
    }
    const std::vector<int> size = integers("--size");
    const Crop c = crop();
    if (c.x1 > size[0] || c.y1 > size[1])
        throw Error("--crop extends beyond the --size of ", size[0], "x", size[1]);
    if (pixel_count(c) > MAX_PIXELS)
        throw Error("at most ", MAX_PIXELS, " pixels are rendered at once; use --crop");
    check_noise(*this);
}
