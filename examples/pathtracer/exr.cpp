// SPDX-License-Identifier: Apache-2.0
// OpenEXR images. Files are encoded in memory, because OpenEXR's own file streams do not report an
// error in the last write.
#include "film.h"

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfEnvmap.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>
#include <bn/bn.h>

#include <limits>
#include <new>

#include "files.h"

namespace {

constexpr const char *COUNT = "count";
constexpr int LARGEST = 1 << 24; // pixels per side of any image

// The layers of a film, except the counts. Only images made with --visible-noise have the last four.
constexpr std::array<const char *, 18> LAYERS = {
    "R",          "G",        "B",        "albedo.R", "albedo.G",   "albedo.B",
    "normal.X",   "normal.Y", "normal.Z", "depth.Z",  "variance.R", "variance.G",
    "variance.B", "A",        "half.R",   "half.G",   "half.B",     "noise"};
constexpr size_t NOISE_LAYERS = 4;

size_t layer_count(const ExrHead &head) {
    const auto found = head.settings.find("visible-noise");
    const bool measured = found != head.settings.end() && found->second != "0";
    return LAYERS.size() - (measured ? 0 : NOISE_LAYERS);
}

// The values of a pixel whose squares have been converted to variances, and its share of hits.
std::array<double *, LAYERS.size()> values_of(FilmPixel &p, double &share) {
    double *const r = &p.radiance.x, *const a = &p.albedo.x, *const n = &p.normal.x,
                  *const v = &p.squares.x, *const h = &p.half.x;
    return {r,        r + 1, r + 2, a,     a + 1,  a + 2, n,     n + 1, n + 2,
            &p.depth, v,     v + 1, v + 2, &share, h,     h + 1, h + 2, &p.noise};
}

Imath::Box2i box(const Crop &crop) {
    return {{crop.x0, crop.y0}, {crop.x1 - 1, crop.y1 - 1}};
}

// The layers of a crop, plane by plane, and their addresses for OpenEXR.
struct Planes {
    std::vector<float> values;
    std::vector<uint32_t> counts;
    Imf::FrameBuffer buffer;

    Planes(const Crop &crop, size_t layers)
        : values(layers * pixel_count(crop)), counts(pixel_count(crop)) {
        const auto add = [&](const char *name, Imf::PixelType type, void *plane) {
            const size_t row = 4 * size_t(width(crop));
            buffer.insert(name, Imf::Slice::Make(type, plane, box(crop), 4, row));
        };
        for (size_t i = 0; i < layers; ++i)
            add(LAYERS[i], Imf::FLOAT, values.data() + i * counts.size());
        add(COUNT, Imf::UINT, counts.data());
    }
};

// Reads and checks the windows of a file. Imf checks that they are not empty.
Window read_window(const Imf::Header &header) {
    const Imath::Box2i display = header.displayWindow(), data = header.dataWindow();
    const int64_t x0 = data.min.x, y0 = data.min.y, x1 = int64_t{data.max.x} + 1,
                  y1 = int64_t{data.max.y} + 1;
    const int64_t w = int64_t{display.max.x} - display.min.x + 1;
    const int64_t h = int64_t{display.max.y} - display.min.y + 1;
    if (w > LARGEST || h > LARGEST || std::min(x0, y0) < -LARGEST || std::max(x1, y1) > LARGEST ||
        (x1 - x0) * (y1 - y0) > int64_t(4 * MAX_PIXELS))
        throw Error("it is too large");
    return {int(w), int(h), {int(x0), int(y0), int(x1), int(y1)}};
}

template <typename Statistics, typename Visit>
void visit_statistics(Statistics &s, Visit visit) {
    visit("spp", s.spp);
    visit("firstSample", s.first_sample);
    visit("endSample", s.end_sample);
    visit("exposure", s.exposure);
    visit("seconds", s.seconds);
    visit("rays", s.ray_count);
    visit("threads", s.threads);
}

ExrHead read_head(const Imf::Header &header) {
    ExrHead head{read_window(header)};
    for (auto at = header.begin(); at != header.end(); ++at)
        if (const auto *text = dynamic_cast<const Imf::StringAttribute *>(&at.attribute()))
            head.settings[at.name()] = text->value();
    ImageStatistics &s = head.statistics;
    visit_statistics(s, [&](const char *name, auto &value) {
        const auto found = head.settings.find(name);
        if (found == head.settings.end())
            throw Error("it was not written by this program: it has no ", name);
        const std::string text = found->second;
        const char *const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (error != std::errc() || stop != end || !std::isfinite(double(value)))
            throw Error("its ", name, " is '", text, "'");
        head.settings.erase(found);
    });
    if (s.end_sample < s.first_sample || s.end_sample > uint64_t{1} << 32)
        throw Error("its firstSample or endSample are impossible");
    for (const char *other : {"software", "name", "type"}) head.settings.erase(other);
    return head;
}

template <typename Read>
auto reading(const std::string &path, Read read) {
    try {
        // OpenEXR allocates before it reads, so a damaged header may request any amount of memory.
        Imf::Header::setMaxImageSize(LARGEST, LARGEST);
        check_regular(path);
        return read();
    } catch (const std::bad_alloc &) {
        throw Error("cannot read the EXR file ", path, ": it needs more than --max-memory allows");
    } catch (const std::exception &error) {
        throw Error("cannot read the EXR file ", path, ": ", error.what());
    }
}

} // namespace

std::string exr_encode(const Film &film, const ExrHead &head) {
    const Imath::Box2i display({0, 0}, {film.full_width - 1, film.full_height - 1});
    const Imath::Box2i data = box(film.crop);
    Imf::Header header(display, data, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);

    const auto text = [&](const std::string &name, const std::string &value) {
        header.insert(name, Imf::StringAttribute(value));
    };
    visit_statistics(head.statistics,
                     [&](const char *name, auto value) { text(name, shortest(value)); });
    for (const auto &[name, value] : head.settings) text(name, value);
    text("software", std::string("libbn pathtracer ") + bn_version_string());

    const size_t layers = layer_count(head);
    Planes planes(film.crop, layers);
    const size_t count = film.pixels.size();
    const auto largest = double(std::numeric_limits<float>::max());
    for (size_t i = 0; i < count; ++i) {
        FilmPixel p = film.pixels[i];
        p.squares = film_variance(p);
        double share = p.count ? double(p.hits) / p.count : 0;
        const auto values = values_of(p, share);
        for (size_t k = 0; k < layers; ++k)
            planes.values[k * count + i] = float(std::clamp(*values[k], -largest, largest));
        planes.counts[i] = p.count;
    }
    for (auto plane = planes.buffer.begin(); plane != planes.buffer.end(); ++plane)
        header.channels().insert(plane.name(), Imf::Channel(plane.slice().type));

    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header); // writes its table of rows last
        file.setFrameBuffer(planes.buffer);
        file.writePixels(height(film.crop));
    }
    return stream.str();
}

Image exr_read(const std::string &path) {
    return reading(path, [&] {
        Imf::InputFile file(path.c_str());
        Image image{read_window(file.header()), {}};
        const size_t pixel = sizeof(Vec3);
        const size_t row = pixel * size_t(width(image.crop));
        image.rgb.resize(pixel_count(image.crop));
        Imf::FrameBuffer buffer;
        const char *const names[3] = {"R", "G", "B"};
        for (size_t c = 0; c < 3; ++c) {
            if (!file.header().channels().findChannel(names[c]))
                throw Error("it has no channel ", names[c]);
            buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, &image.rgb[0].x + c,
                                                     box(image.crop), pixel, row));
        }
        if (Imf::hasEnvmap(file.header()) && Imf::envmap(file.header()) == Imf::ENVMAP_CUBE)
            throw Error("it is a cube map; convert it to latitude-longitude, as exrenvmap does");
        file.setFrameBuffer(buffer);
        file.readPixels(image.crop.y0, image.crop.y1 - 1);
        const Imath::V2i corner = file.header().displayWindow().min;
        image.crop = {image.crop.x0 - corner.x, image.crop.y0 - corner.y, image.crop.x1 - corner.x,
                      image.crop.y1 - corner.y};
        if (Imf::hasChromaticities(file.header())) {
            const Imath::M44f to_rec709 =
                Imf::RGBtoXYZ(Imf::chromaticities(file.header()), 1) * Imf::XYZtoRGB({}, 1);
            for (Vec3 &v : image.rgb) {
                const Imath::V3f rgb = Imath::V3f(v.x, v.y, v.z) * to_rec709;
                if (is_finite(v)) v = {rgb.x, rgb.y, rgb.z};
            }
        }
        return image;
    });
}

ExrHead exr_read_head(const std::string &path) {
    return reading(path, [&] { return read_head(Imf::InputFile(path.c_str()).header()); });
}

Film exr_read_film(const std::string &path) {
    return reading(path, [&] {
        Imf::InputFile file(path.c_str());
        const ExrHead head = read_head(file.header());
        if (pixel_count(head.crop) > MAX_PIXELS) throw Error("it is too large");
        Film film = film_create(head.full_width, head.full_height, head.crop);
        const size_t layers = layer_count(head);
        Planes planes(head.crop, layers);
        for (auto plane = planes.buffer.begin(); plane != planes.buffer.end(); ++plane)
            if (!file.header().channels().findChannel(plane.name()))
                throw Error("it has no channel ", plane.name());
        file.setFrameBuffer(planes.buffer);
        file.readPixels(head.crop.y0, head.crop.y1 - 1);

        const uint64_t most = head.statistics.end_sample - head.statistics.first_sample;
        for (size_t i = 0; i < film.pixels.size(); ++i) {
            if (planes.counts[i] > most) throw Error("it has more samples than its attributes say");
            FilmPixel &p = film.pixels[i];
            p.count = planes.counts[i];
            double share = 0;
            const auto values = values_of(p, share);
            for (size_t k = 0; k < layers; ++k) {
                *values[k] = double(planes.values[k * film.pixels.size() + i]);
                if (!std::isfinite(*values[k]))
                    throw Error("its channel ", LAYERS[k], " has a value that is not finite");
            }
            p.squares *= p.count < 2 ? 0 : p.count - 1;
            if (!(share >= 0 && share <= 1))
                throw Error("its channel A has a value outside [0, 1]");
            p.hits = uint32_t(std::lround(share * p.count));
        }
        return film;
    });
}
