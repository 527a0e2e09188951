// SPDX-License-Identifier: Apache-2.0
// What the tests of the path tracer's parts share: CHECK, random numbers, chi-square.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

// Prints what is wrong, with printf arguments for the values, and ends the test.
#define CHECK(condition, ...)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            std::fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #condition);                   \
            std::fprintf(stderr, __VA_ARGS__);                                                     \
            std::fputc('\n', stderr);                                                              \
            std::exit(1);                                                                          \
        }                                                                                          \
    } while (0)

// SplitMix64: uniform numbers in [0, 1), multiples of 2^-24 as libbn draws them.
struct Random {
    uint64_t state;
    float operator()() {
        uint64_t z = (state += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<float>((z ^ (z >> 31)) >> 40) / (1 << 24);
    }
};

// How many standard deviations a chi-square value lies above its mean, by the cube root of Wilson
// and Hilferty: 4.5 is passed by chance about three times in a million.
inline double chi_square_deviations(double chi_square, int degrees) {
    const double d = degrees;
    return (std::cbrt(chi_square / d) - (1 - 2 / (9 * d))) / std::sqrt(2 / (9 * d));
}
