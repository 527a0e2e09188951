// SPDX-License-Identifier: Apache-2.0
// OpenEXR pictures. Files are encoded in memory: the library's own file streams do not report an
// error of the last write.
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

#include <cstring>

#include "error.h"

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

Imf::FrameBuffer frame_buffer(std::vector<float> &rgb, const Imath::Box2i &window) {
    const size_t pixel = 3 * sizeof(float);
    const size_t row = pixel * static_cast<size_t>(window.max.x - window.min.x + 1);
    Imf::FrameBuffer buffer;
    const char *const names[3] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c)
        buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, rgb.data() + c, window, pixel, row));
    return buffer;
}

} // namespace

std::vector<char> exr_encode(const Image &image, const ExrAttributes &attributes) {
    const Crop &crop = image.crop;
    const Imath::Box2i display({0, 0}, {image.full_width - 1, image.full_height - 1});
    const Imath::Box2i data({crop.x0, crop.y0}, {crop.x1 - 1, crop.y1 - 1});
    Imf::Header header(display, data, 1, {0, 0}, 1, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);
    for (const char *name : {"R", "G", "B"})
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));

    // EXR integers have 32 bits with a sign; what may not fit is text.
    const auto text = [&](const char *name, const std::string &value) {
        header.insert(name, Imf::StringAttribute(value));
    };
    const auto count = [&](const char *name, uint32_t value) {
        header.insert(name, Imf::IntAttribute(static_cast<int>(value)));
    };
    const auto real = [&](const char *name, double value) {
        header.insert(name, Imf::FloatAttribute(static_cast<float>(value)));
    };
    text("scene", attributes.scene);
    text("sampler", attributes.sampler);
    count("spp", attributes.spp);
    text("declaredSpp", std::to_string(attributes.declared_spp));
    text("firstSample", std::to_string(attributes.first_sample));
    text("seed", std::to_string(attributes.seed));
    count("maxDepth", attributes.max_depth);
    real("seconds", attributes.seconds);
    text("rays", std::to_string(attributes.ray_count));
    count("threads", attributes.threads);
    text("software", std::string("libbn pathtracer ") + bn_version_string());
    text("bnVersion", bn_version_string()); // the name "version" is the file format's own

    std::vector<char> bytes;
    try {
        MemoryStream stream(bytes);
        Imf::OutputFile file(stream, header);
        std::vector<float> rgb = image.rgb; // slices are not const
        file.setFrameBuffer(frame_buffer(rgb, data));
        file.writePixels(height(crop));
    } catch (const std::exception &error) {
        throw Error(std::string("the picture cannot be encoded: ") + error.what());
    }
    return bytes;
}

Image exr_read(const std::string &path) {
    try {
        Imf::InputFile file(path.c_str());
        const Imath::Box2i display = file.header().displayWindow();
        const Imath::Box2i data = file.header().dataWindow();
        for (const char *name : {"R", "G", "B"})
            if (!file.header().channels().findChannel(name))
                throw Error(std::string("it has no channel ") + name);
        Image image{display.max.x - display.min.x + 1,
                    display.max.y - display.min.y + 1,
                    {data.min.x, data.min.y, data.max.x + 1, data.max.y + 1},
                    {}};
        image.rgb.resize(3 * pixel_count(image.crop));
        file.setFrameBuffer(frame_buffer(image.rgb, data));
        file.readPixels(data.min.y, data.max.y);
        return image;
    } catch (const std::exception &error) {
        throw Error("cannot read the EXR file " + path + ": " + error.what());
    }
}
