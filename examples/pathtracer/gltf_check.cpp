// SPDX-License-Identifier: Apache-2.0
// Checks a file before tinygltf parses it: tinygltf recurses into nested values, builds large
// structures from short texts, and copies the binary chunk for each buffer that uses it. The check
// is one pass over the text and does not change it.
#include <algorithm>

#include "gltf_parts.h"

namespace {

constexpr int MAX_NESTING = 256;
// Three characters can become a material of 2300 bytes or another object of up to 900; two
// characters, a value of 180.
constexpr size_t MAX_MATERIALS = size_t{1} << 16;
constexpr size_t MAX_OBJECTS = size_t{1} << 20;
constexpr size_t MAX_VALUES = size_t{1} << 23;

void check_count(size_t count, size_t most, const char *what) {
    if (count > most) throw Error("has more than " + std::to_string(most) + " " + what);
}

// Scans JSON character by character. Invalid JSON is left to the parser.
class JsonScan {
  public:
    void scan(const char *text, size_t size) {
        for (size_t i = 0; i < size; ++i) {
            const char c = text[i];
            if (c == '"') {
                i = skip_string(text, size, i + 1);
            } else if (c == '{' || c == '[') {
                open(c);
            } else if (c == '}' || c == ']') {
                close();
            } else if (c == ':') {
                key_ = string_;
                if (is_escaped_ && (depth_ == 1 || is_in_buffer()))
                    throw Error("has an escaped member name, which is not read");
            }
            if (c == ',' || c == ':' || c == '{') is_value_ = c == ':';
            if (c == ',' || c == '[') check_count(++values_, MAX_VALUES, "JSON values");
        }
    }

    // Entries of `buffers` without a URI: their bytes are the binary chunk's.
    size_t buffers_without_file() const { return buffers_without_file_; }
    // The first entries of `extensionsRequired`.
    const std::vector<std::string> &required() const { return required_; }

  private:
    bool is_in_buffer() const { return in_buffers_ && depth_ == 3; }

    // Returns the position of the quote that closes the string starting at `begin`.
    size_t skip_string(const char *text, size_t size, size_t begin) {
        is_escaped_ = false;
        size_t end = begin;
        for (; end < size && text[end] != '"'; ++end)
            if (text[end] == '\\') {
                is_escaped_ = true;
                ++end;
            }
        end = std::min(end, size);
        if (is_value_ && is_in_buffer() && key_ == "uri") has_file_ = end > begin;
        string_.assign(text + begin, std::min<size_t>(end - begin, 20)); // enough to compare
        if (in_required_ && depth_ == 2 && required_.size() < 64)
            required_.emplace_back(text + begin, std::min<size_t>(end - begin, 200));
        return end;
    }

    void open(char c) {
        if (++depth_ > MAX_NESTING) throw Error("is not glTF: its JSON is nested too deeply");
        if (depth_ == 2) {
            in_buffers_ = c == '[' && key_ == "buffers";
            in_materials_ = c == '[' && key_ == "materials";
            in_required_ = c == '[' && key_ == "extensionsRequired";
        }
        if (is_in_buffer()) has_file_ = false;
        if (c == '{') check_count(++objects_, MAX_OBJECTS, "JSON objects");
        if (depth_ == 3 && in_materials_) check_count(++materials_, MAX_MATERIALS, "materials");
    }

    void close() {
        if (is_in_buffer() && !has_file_) ++buffers_without_file_;
        --depth_;
    }

    int depth_ = 0;
    std::string string_, key_; // the most recent ones
    bool is_escaped_ = false;  // the most recent string has an escape
    bool is_value_ = false;    // a string here is a value, not a key
    bool in_materials_ = false, in_buffers_ = false, has_file_ = false, in_required_ = false;
    std::vector<std::string> required_;
    size_t materials_ = 0, objects_ = 0, values_ = 0, buffers_without_file_ = 0;
};

} // namespace

void gltf_check_text(const char *text, size_t size) {
    JsonScan().scan(text, size);
}

void gltf_check_binary(const std::vector<unsigned char> &bytes) {
    const auto word = [&](size_t at) {
        return static_cast<uint64_t>(bytes[at]) | static_cast<uint64_t>(bytes[at + 1]) << 8 |
               static_cast<uint64_t>(bytes[at + 2]) << 16 |
               static_cast<uint64_t>(bytes[at + 3]) << 24;
    };
    if (bytes.size() < 20) throw Error("is cut short: it ends within its header");
    if (word(4) != 2) throw Error("is not of glTF version 2");
    const uint64_t size = bytes.size();
    if (word(8) < 20 || word(8) > size)
        throw Error("is cut short: its header says it has " + std::to_string(word(8)) + " bytes");
    uint64_t at = 12;
    while (at + 8 <= word(8)) {
        if (word(at) > word(8) - at - 8) throw Error("is cut short: a chunk goes beyond its end");
        at += 8 + word(at);
    }
    JsonScan json;
    json.scan(reinterpret_cast<const char *>(bytes.data()) + 20, word(12));
    // Some extensions keep the data of buffers elsewhere: name them.
    if (json.buffers_without_file() > 1) {
        gltf_check_required(json.required());
        throw Error("has more than one buffer without a URI");
    }
}
