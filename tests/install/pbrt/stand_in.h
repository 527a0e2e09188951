// SPDX-License-Identifier: Apache-2.0
// The pbrt-v4 names that examples/pbrt uses. They allow it to compile without pbrt.
#ifndef STAND_IN_H
#define STAND_IN_H

#include <cstdlib>
#include <optional>
#include <string>

namespace pbrt {

using Float = float;
constexpr Float OneMinusEpsilon = 0.99999994f;

struct Point2i {
    int x = 0, y = 0;
};

struct Point2f {
    Point2f(Float x, Float y) : x(x), y(y) {}
    Float x, y;
};

struct FileLoc;

struct ParameterDictionary {
    int frame = 0;
    int GetOneInt(const std::string &name, int otherwise) const {
        return name == "frame" ? frame : otherwise;
    }
};

struct PBRTOptions {
    int seed = 0;
    bool quickRender = false;
    std::optional<int> pixelSamples;
};
inline PBRTOptions given;
inline PBRTOptions *Options = &given;

template <typename... Args>
[[noreturn]] void ErrorExit(const FileLoc *, const char *, Args...) {
    std::exit(1);
}

template <typename... Args>
std::string StringPrintf(const char *text, Args...) {
    return text;
}

struct Allocator {
    template <typename T, typename... Args>
    T *new_object(Args &&...args) {
        return new T(args...);
    }
};

class BlueSampler;

struct Sampler {
    Sampler(BlueSampler *sampler) : sampler(sampler) {}
    BlueSampler *sampler;
};

} // namespace pbrt

#endif // STAND_IN_H
