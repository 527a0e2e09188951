// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures. Files are encoded in memory: the library's own file streams do not report an
// error in the last write.
#include "exr.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <bn/bn.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>

#include "error.h"
#include "input_file.h"

namespace {

class MemoryStream : public Imf::OStream {
  public:
    explicit MemoryStream(std::vector<char> &bytes) : OStream("memory"), bytes_(bytes) {}
    void write(const char data[], int size) override {
        const size_t end = position_ + static_cast<size_t>(size);
        if (end > bytes_.size()) bytes_.resize(end);
        std::memcpy(bytes_.data() + position_, data, static_cast<size_t>(size));
        position_ = end;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override { position_ = position; }

  private:
    std::vector<char> &bytes_;
    size_t position_ = 0;
};

// A channel of a file: a plane of floats over the data window.
struct Plane {
    const char *name;
    std::vector<float> values;
};

constexpr const char *COUNT = "count";
constexpr int LARGEST = 1 << 24; // pixels along a side of any picture

Imf::Slice slice(Imf::PixelType type, void *values, const Imath::Box2i &window) {
    const auto row = static_cast<size_t>(window.max.x - window.min.x + 1);
    return Imf::Slice::Make(type, values, window, 4, 4 * row);
}

// The layers of a film, except the counts. Values are clamped to the range of float.
std::vector<Plane> film_planes(const Film &film) {
    std::vector<Plane> planes;
    const auto add = [&](const char *name, auto value) {
        planes.push_back({name, {}});
        std::vector<float> &values = planes.back().values;
        values.reserve(film.pixels.size());
        const auto largest = static_cast<double>(std::numeric_limits<float>::max());
        for (const FilmPixel &pixel : film.pixels)
            values.push_back(static_cast<float>(std::clamp(value(pixel), -largest, largest)));
    };
    const auto add_three = [&](std::array<const char *, 3> names, auto value) {
        for (int c = 0; c < 3; ++c)
            add(names[static_cast<size_t>(c)], [&](const FilmPixel &p) { return value(p, c); });
    };
    add_three({"R", "G", "B"}, [](const FilmPixel &p, int c) { return p.radiance[c]; });
    add("A",
        [](const FilmPixel &p) { return p.count ? static_cast<double>(p.hits) / p.count : 0; });
    add_three({"albedo.R", "albedo.G", "albedo.B"},
              [](const FilmPixel &p, int c) { return p.albedo[c]; });
    add_three({"normal.X", "normal.Y", "normal.Z"},
              [](const FilmPixel &p, int c) { return p.normal[c]; });
    add("depth.Z", [](const FilmPixel &p) { return p.depth; });
    add_three({"variance.R", "variance.G", "variance.B"}, film_variance);
    return planes;
}

// The reverse of film_planes(); takes the counts as well.
Film film_of_planes(int full_width, int full_height, const Crop &crop,
                    const std::vector<Plane> &planes, const std::vector<uint32_t> &counts) {
    Film film = film_create(full_width, full_height, crop);
    for (size_t i = 0; i < film.pixels.size(); ++i) {
        FilmPixel &p = film.pixels[i];
        const auto value = [&](size_t plane) {
            return static_cast<double>(planes[plane].values[i]);
        };
        p.count = counts[i];
        p.hits = static_cast<uint32_t>(std::lround(value(3) * p.count));
        p.depth = value(10);
        for (size_t c = 0; c < 3; ++c) {
            p.radiance[c] = value(c);
            p.albedo[c] = value(4 + c);
            p.normal[c] = value(7 + c);
            p.squares[c] = p.count < 2 ? 0 : value(11 + c) * (p.count - 1);
        }
    }
    return film;
}

// Reads and checks the windows of a file. Imf checks that they are not empty.
void read_windows(const Imf::Header &header, int &full_width, int &full_height, Crop &crop) {
    const Imath::Box2i display = header.displayWindow(), data = header.dataWindow();
    const int64_t x0 = data.min.x, y0 = data.min.y, x1 = int64_t{data.max.x} + 1,
                  y1 = int64_t{data.max.y} + 1;
    const int64_t w = int64_t{display.max.x} - display.min.x + 1;
    const int64_t h = int64_t{display.max.y} - display.min.y + 1;
    if (w > LARGEST || h > LARGEST || std::min(x0, y0) < -LARGEST || std::max(x1, y1) > LARGEST ||
        (x1 - x0) * (y1 - y0) > static_cast<int64_t>(4 * MAX_PIXELS))
        throw Error("it is too large");
    full_width = static_cast<int>(w);
    full_height = static_cast<int>(h);
    crop = {static_cast<int>(x0), static_cast<int>(y0), static_cast<int>(x1), static_cast<int>(y1)};
}

Imath::Box2i box(const Crop &crop) {
    return {{crop.x0, crop.y0}, {crop.x1 - 1, crop.y1 - 1}};
}

// The attributes that parts of one picture do not share.
template <typename Attributes, typename Visit>
void own_attributes(Attributes &a, Visit visit) {
    visit("spp", a.spp);
    visit("firstSample", a.first_sample);
    visit("endSample", a.end_sample);
    visit("exposure", a.exposure);
    visit("seconds", a.seconds);
    visit("rays", a.ray_count);
    visit("threads", a.threads);
    visit("samplingShare", a.sampling_share);
}

struct WriteAttribute {
    Imf::Header &header;

    void operator()(const char *name, const std::string &text) const {
        header.insert(name, Imf::StringAttribute(text));
    }
    void operator()(const char *name, uint32_t value) const {
        header.insert(name, Imf::IntAttribute(static_cast<int>(value)));
    }
    // Does not fit the format's integers, signed 32-bit.
    void operator()(const char *name, uint64_t value) const {
        (*this)(name, std::to_string(value));
    }
    void operator()(const char *name, double value) const {
        header.insert(name, Imf::FloatAttribute(static_cast<float>(value)));
    }
    void operator()(const char *name, float value) const {
        (*this)(name, static_cast<double>(value));
    }
    void operator()(const char *name, bool value) const { (*this)(name, uint32_t{value}); }
};

struct ReadAttribute {
    const Imf::Header &header;

    template <typename Attribute>
    auto found(const char *name) const {
        const auto *attribute = header.findTypedAttribute<Attribute>(name);
        if (!attribute)
            throw Error(std::string("it was not written by this program: it has no ") + name);
        return attribute->value();
    }
    void operator()(const char *name, std::string &text) const {
        text = found<Imf::StringAttribute>(name);
    }
    void operator()(const char *name, uint32_t &value) const {
        const int number = found<Imf::IntAttribute>(name);
        if (number < 0) throw Error(std::string("its ") + name + " is negative");
        value = static_cast<uint32_t>(number);
    }
    void operator()(const char *name, uint64_t &value) const {
        const auto text = found<Imf::StringAttribute>(name);
        const char *end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (error != std::errc() || stop != end)
            throw Error(std::string("its ") + name + " is '" + printable(text) + "'");
    }
    void operator()(const char *name, float &value) const {
        value = found<Imf::FloatAttribute>(name);
        if (!std::isfinite(value)) throw Error(std::string("its ") + name + " is not finite");
    }
    void operator()(const char *name, double &value) const { // of time
        float number = 0;
        (*this)(name, number);
        if (number < 0) throw Error(std::string("its ") + name + " is negative");
        value = static_cast<double>(number);
    }
    void operator()(const char *name, bool &value) const {
        uint32_t number = 0;
        (*this)(name, number);
        value = number != 0;
    }
};

ExrHead read_head(const Imf::Header &header) {
    ExrHead head{};
    read_windows(header, head.full_width, head.full_height, head.crop);
    ExrAttributes &a = head.attributes;
    exr_settings(a, ReadAttribute{header});
    own_attributes(a, ReadAttribute{header});
    if (a.end_sample < a.first_sample || a.end_sample > uint64_t{1} << 32)
        throw Error("its firstSample or endSample are impossible");
    return head;
}

// Runs a reader and turns its errors into one line with the file's name.
template <typename Read>
auto reading(const std::string &path, Read read) {
    try {
        // The library allocates before it reads: a damaged header asks for anything.
        Imf::Header::setMaxImageSize(LARGEST, LARGEST);
        check_regular(path);
        return read();
    } catch (const std::bad_alloc &) {
        throw Error("cannot read the EXR file " + path +
                    ": it needs more memory than there is, or than --max-memory allows");
    } catch (const std::exception &error) {
        throw Error("cannot read the EXR file " + path + ": " + error.what());
    }
}

} // namespace

std::vector<char> exr_encode(const Film &film, const ExrAttributes &attributes) {
    const Imath::Box2i display({0, 0}, {film.full_width - 1, film.full_height - 1});
    const Imath::Box2i data = box(film.crop);
    Imf::Header header(display, data, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);

    const WriteAttribute write{header};
    exr_settings(attributes, write);
    own_attributes(attributes, write);
    write("software", std::string("libbn pathtracer ") + bn_version_string());
    write("bnVersion", std::string(bn_version_string())); // the format itself uses "version"

    std::vector<Plane> planes = film_planes(film);
    std::vector<uint32_t> counts;
    counts.reserve(film.pixels.size());
    for (const FilmPixel &pixel : film.pixels) counts.push_back(pixel.count);
    Imf::FrameBuffer buffer;
    for (Plane &plane : planes) {
        header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
        buffer.insert(plane.name, slice(Imf::FLOAT, plane.values.data(), data));
    }
    header.channels().insert(COUNT, Imf::Channel(Imf::UINT));
    buffer.insert(COUNT, slice(Imf::UINT, counts.data(), data));

    std::vector<char> bytes;
    try {
        MemoryStream stream(bytes);
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(height(film.crop));
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const std::exception &error) {
        throw Error(std::string("the picture cannot be encoded: ") + error.what());
    }
    return bytes;
}

Image exr_read(const std::string &path) {
    return reading(path, [&] {
        Imf::InputFile file(path.c_str());
        Image image{};
        read_windows(file.header(), image.full_width, image.full_height, image.crop);
        const size_t pixel = 3 * sizeof(float);
        const size_t row = pixel * static_cast<size_t>(width(image.crop));
        image.rgb.resize(3 * pixel_count(image.crop));
        Imf::FrameBuffer buffer;
        const char *const names[3] = {"R", "G", "B"};
        for (size_t c = 0; c < 3; ++c) {
            if (!file.header().channels().findChannel(names[c]))
                throw Error(std::string("it has no channel ") + names[c]);
            buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, image.rgb.data() + c,
                                                     box(image.crop), pixel, row));
        }
        file.setFrameBuffer(buffer);
        file.readPixels(image.crop.y0, image.crop.y1 - 1);
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
        const Imath::Box2i data = box(head.crop);
        std::vector<Plane> planes =
            film_planes(film_create(head.full_width, head.full_height, head.crop));
        std::vector<uint32_t> counts(pixel_count(head.crop));
        Imf::FrameBuffer buffer;
        for (Plane &plane : planes)
            buffer.insert(plane.name, slice(Imf::FLOAT, plane.values.data(), data));
        buffer.insert(COUNT, slice(Imf::UINT, counts.data(), data));
        for (auto channel = buffer.begin(); channel != buffer.end(); ++channel)
            if (!file.header().channels().findChannel(channel.name()))
                throw Error(std::string("it has no channel ") + channel.name());
        file.setFrameBuffer(buffer);
        file.readPixels(data.min.y, data.max.y);

        const uint64_t most = head.attributes.end_sample - head.attributes.first_sample;
        for (const uint32_t count : counts)
            if (count > most) throw Error("it has more samples than its attributes say");
        for (const Plane &plane : planes)
            for (const float v : plane.values)
                if (!std::isfinite(v))
                    throw Error(std::string("its channel ") + plane.name +
                                " has a value that is not finite");
        for (const float v : planes[3].values)
            if (!(v >= 0 && v <= 1)) throw Error("its channel A has a value outside [0, 1]");
        return film_of_planes(head.full_width, head.full_height, head.crop, planes, counts);
    });
}
