// SPDX-License-Identifier: Apache-2.0
// Checks the header of an OpenEXR file before the library reads it: the library allocates whatever
// memory the header asks for, however small the file is.
#include "exr_check.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>

#include "error.h"
#include "input_file.h"

namespace {

// Bytes that any file may ask for, and the most that one byte of a file may expand to: deflate
// reaches 1032, and methods that encode uniform blocks reach more.
constexpr double SPARE_BYTES = 1 << 24;
constexpr double MOST_EXPANSION = 8192;
constexpr uint32_t MULTI_PART = 0x1000;
constexpr std::array<double, 10> BLOCK_ROWS = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

class HeaderReader {
  public:
    explicit HeaderReader(const InputFile &file) : file_(file) {}

    uint64_t left() const { return file_.size() - std::min(place_, file_.size()); }

    void bytes(void *to, size_t count) {
        if (file_.read(place_, to, count) != count) throw Error("it is cut short");
        place_ += count;
    }
    template <typename Number>
    Number number() {
        unsigned char raw[4] = {0, 0, 0, 0};
        bytes(raw, sizeof(Number));
        const uint32_t value = raw[0] | static_cast<uint32_t>(raw[1]) << 8 |
                               static_cast<uint32_t>(raw[2]) << 16 |
                               static_cast<uint32_t>(raw[3]) << 24;
        return static_cast<Number>(value);
    }
    std::string text() {
        char raw[256];
        const size_t count = file_.read(place_, raw, sizeof raw);
        const void *end = std::memchr(raw, 0, count);
        if (!end)
            throw Error(count < sizeof raw ? "it is cut short"
                                           : "its header has an unterminated name");
        const auto length = static_cast<size_t>(static_cast<const char *>(end) - raw);
        place_ += length + 1;
        return {raw, length};
    }
    uint64_t place() const { return place_; }
    void go_to(uint64_t place) { place_ = place; }

  private:
    const InputFile &file_;
    uint64_t place_ = 0;
};

struct Claims {
    double width = 0, height = 0, bytes_per_pixel = 0, tile_pixels = 0, block_rows = 1;
};

double extent(int32_t low, int32_t high) {
    return static_cast<double>(high) - low + 1;
}

Error damaged() {
    return Error("its header is damaged");
}

// The bytes per pixel of a channel list, which must end at `end`.
double channel_bytes(HeaderReader &header, uint64_t end) {
    double bytes = 0;
    while (!header.text().empty()) {
        const auto type = header.number<uint32_t>();
        bytes += type == 1 ? 2 : 4; // half is 2 bytes, float and uint 4
        header.go_to(header.place() + 12);
    }
    if (header.place() != end) throw damaged();
    return bytes;
}

// The library parses values of these types by their contents, whatever size the header states: with
// a wrong size, it would continue elsewhere in the file than the checks here.
void check_value(HeaderReader &header, const std::string &type, uint64_t size) {
    constexpr std::pair<const char *, uint64_t> FIXED[] = {
        {"box2i", 16},      {"box2f", 16},    {"chromaticities", 32},
        {"compression", 1}, {"double", 8},    {"envmap", 1},
        {"float", 4},       {"int", 4},       {"keycode", 28},
        {"m33f", 36},       {"lineOrder", 1}, {"m33d", 72},
        {"m44f", 64},       {"m44d", 128},    {"rational", 8},
        {"tiledesc", 9},    {"timecode", 8},  {"v2i", 8},
        {"v2f", 8},         {"v2d", 16},      {"v3i", 12},
        {"v3f", 12},        {"v3d", 24},      {"deepImageState", 1}};
    for (const auto &[name, bytes] : FIXED)
        if (type == name && size != bytes) throw damaged();
    const uint64_t begin = header.place(), end = begin + size;
    if (type == "chlist") {
        channel_bytes(header, end);
    } else if (type == "preview") {
        const uint64_t width = header.number<uint32_t>();
        if (size < 8 || (size - 8) / 4 != width * header.number<uint32_t>()) throw damaged();
    } else if (type == "stringvector") {
        while (header.place() < end) {
            const uint64_t length = header.number<uint32_t>();
            header.go_to(header.place() + length);
        }
        if (header.place() != end) throw damaged();
    }
    header.go_to(begin);
}

// Reads one header. Returns false if it is empty, which ends the headers of a multi-part file.
bool read_claims(HeaderReader &header, Claims &claims) {
    bool any = false;
    for (std::string name = header.text(); !name.empty(); name = header.text()) {
        any = true;
        const std::string type = header.text();
        const auto size = header.number<uint32_t>();
        if (size > header.left()) throw Error("it is cut short, or not an EXR file");
        check_value(header, type, size);
        const uint64_t end = header.place() + size;
        if (name == "dataWindow" && type == "box2i") {
            const auto x0 = header.number<int32_t>(), y0 = header.number<int32_t>();
            claims.width = extent(x0, header.number<int32_t>());
            claims.height = extent(y0, header.number<int32_t>());
        } else if (type == "chlist") {
            claims.bytes_per_pixel = channel_bytes(header, end);
        } else if (type == "tiledesc") {
            const double x = header.number<uint32_t>();
            claims.tile_pixels = x * header.number<uint32_t>();
        } else if (type == "compression") {
            const size_t method = header.number<uint8_t>();
            if (method < BLOCK_ROWS.size()) claims.block_rows = BLOCK_ROWS[method];
        } else if (name == "chunkCount" && type == "int") {
            if (header.number<uint32_t>() > header.left() / 8) throw Error("it is cut short");
        }
        header.go_to(end);
    }
    return any;
}

} // namespace

void exr_check(const std::string &path) {
    const InputFile file(path);
    HeaderReader header(file);
    if (file.size() < 8 || header.number<uint32_t>() != 20000630) return; // the library rejects it
    const bool has_parts = (header.number<uint32_t>() & MULTI_PART) != 0;
    const auto size = static_cast<double>(file.size());
    double needed = 0;
    Claims claims;
    while (read_claims(header, claims)) {
        const double rows = std::max(claims.height, claims.block_rows);
        needed += claims.bytes_per_pixel * std::max(claims.width * rows, claims.tile_pixels);
        // The file holds an 8-byte offset for each block of rows.
        const bool is_short =
            claims.tile_pixels == 0 && claims.height / claims.block_rows * 8 > size;
        if (is_short || needed > SPARE_BYTES + MOST_EXPANSION * size)
            throw Error("it claims " + std::to_string(static_cast<int64_t>(claims.width)) + "x" +
                        std::to_string(static_cast<int64_t>(claims.height)) +
                        " pixels, more than its " + std::to_string(file.size()) +
                        " bytes can hold");
        if (!has_parts) break;
        claims = {};
    }
}
