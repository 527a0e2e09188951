// SPDX-License-Identifier: Apache-2.0
// Makes a plug-in (sampler_plugin.h) of a C++ class with a constructor (seed, samples, argument) and a member function
// draw(const Draw &, out). A constructor that throws refuses its arguments.
#pragma once

#include <bn/bn.hpp>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sampler_plugin.h"

// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
// Generators", 2014).
inline uint64_t mix64(uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

// The arguments of sampler_plugin_draw().
struct Draw {
    uint64_t seed;
    int32_t x, y;
    uint32_t index, decision, dimensions;

    // A hash of the seed and the pixel.
    uint64_t pixel() const {
        return mix64(mix64(seed + 1) + (uint64_t{uint32_t(x)} << 32 | uint32_t(y)));
    }
};

// A whole number of pixels by which a decision's numbers are shifted, different for each seed, decision and part.
inline uint32_t shift_of(uint64_t seed, uint32_t decision, uint32_t part) {
    return uint32_t(mix64(mix64(seed + 0x9e3779b97f4a7c15u) + (uint64_t{decision} << 32 | part))) >>
           20;
}

// The first of the two dimensions of a decision's pair (0, 1) in a sequence that serves whole paths: 0 position, 2 time
// and wavelength, 4 lens or light, 6 first light, then direction, light and lobe of each ray. UINT32_MAX for loops.
inline uint32_t dimension_of(uint32_t decision, uint32_t pair) {
    const uint32_t slot = decision / 4, part = decision % 4 + pair;
    if (decision >= 1u << 14) return UINT32_MAX;
    if (slot == 0) return part == 0 ? 0 : 4;
    if (slot == 3) return part == 0 ? 6 : 2;
    return 8 + 6 * (slot < 3 ? slot - 1 : slot - 2) + 2 * part;
}

// Draws pair by pair: take(first, u) writes the numbers in the dimensions `first` and first + 1 of a sequence, which
// place(pair) chooses. A pair whose `first` is not below `count` has independent numbers.
template <typename Place, typename Take>
void draw_pairs(const Draw &d, uint32_t count, float *u, const Place &place, const Take &take) {
    for (uint32_t pair = 0; pair < d.dimensions / 2; ++pair, u += 2) {
        const uint32_t first = place(pair);
        if (first < count) {
            take(first, u);
        } else {
            const bn::Sampler white(bn::Type::white, d.seed);
            bn_sample_2d(white.get(), d.x, d.y, d.index, d.decision + pair, 0, u);
        }
    }
}

// Reads initial direction numbers: a line for each dimension with its number, degree, polynomial and numbers, of which
// columns_of(degree, polynomial, numbers) makes columns. A heading may precede the first.
template <typename Columns>
std::vector<Columns> read_dimensions(const std::string &path, uint32_t most_degree, size_t least,
                                     Columns (*columns_of)(uint32_t, uint32_t, std::istream &)) {
    std::ifstream file(path);
    std::vector<Columns> found;
    uint32_t number, degree, polynomial;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        if (!(words >> number >> degree >> polynomial) && found.empty()) continue; // a heading
        if (!words || degree == 0 || degree > most_degree) throw std::invalid_argument(line);
        found.push_back(columns_of(degree, polynomial, words));
    }
    if (found.size() < least) throw std::invalid_argument(path);
    return found;
}

#define SAMPLER_PLUGIN(Type, tuned)                                                                \
    uint32_t sampler_plugin_version() {                                                            \
        return SAMPLER_PLUGIN_VERSION;                                                             \
    }                                                                                              \
    uint32_t sampler_plugin_is_tuned() {                                                           \
        return tuned;                                                                              \
    }                                                                                              \
    void *sampler_plugin_create(uint64_t seed, uint32_t samples, const char *argument) {           \
        try {                                                                                      \
            return new Type(seed, samples, std::string(argument));                                 \
        } catch (...) {                                                                            \
            return nullptr;                                                                        \
        }                                                                                          \
    }                                                                                              \
    void sampler_plugin_destroy(void *state) {                                                     \
        delete static_cast<Type *>(state);                                                         \
    }                                                                                              \
    void sampler_plugin_draw(const void *state, uint64_t seed, int32_t x, int32_t y,               \
                             uint32_t index, uint32_t decision, uint32_t dimensions, float *out) { \
        static_cast<const Type *>(state)->draw({seed, x, y, index, decision, dimensions}, out);    \
    }
