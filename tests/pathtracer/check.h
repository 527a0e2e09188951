// SPDX-License-Identifier: Apache-2.0
// Helpers for the C++ tests of the path tracer: CHECK, random numbers, means and a chi-square test.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

// If the condition is false, prints it with a printf-style message and ends the test.
#define CHECK(condition, ...)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            std::fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #condition);                   \
            std::fprintf(stderr, __VA_ARGS__);                                                     \
            std::fputc('\n', stderr);                                                              \
            std::exit(1);                                                                          \
        }                                                                                          \
    } while (0)

// SplitMix64. Returns uniform multiples of 2^-24 in [0, 1), like libbn's draws.
struct Random {
    uint64_t state;
    float operator()() {
        uint64_t z = (state += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return float((z ^ (z >> 31)) >> 40) / (1 << 24);
    }
};

// The mean of many values, and its standard error if the values are independent.
struct Mean {
    double sum = 0, squares = 0;
    int count = 0;
    void add(double value) {
        sum += value;
        squares += value * value;
        ++count;
    }
    double mean() const { return sum / count; }
    double error() const {
        return std::sqrt(std::max(squares / count - mean() * mean(), 0.0) / (count - 1));
    }
};

// Allows a difference of five standard errors, which chance exceeds less than once in a million.
inline void check_mean(const Mean &found, double expected, const char *what) {
    CHECK(std::abs(found.mean() - expected) <= 5 * found.error() + 1e-5 * expected,
          "%s: %g +- %g, should be %g", what, found.mean(), found.error(), expected);
}

// The chi-square statistic of the counts, converted to standard deviations above its mean by the
// Wilson-Hilferty transformation. Chance exceeds 4.5 about three times in a million. Cells whose
// expected count is below ten are merged into one.
inline double unevenness(const std::vector<double> &counted, const std::vector<double> &expected) {
    double chi_square = 0, rest_counted = 0, rest_expected = 0;
    int cells = -1;
    const auto add = [&](double n, double mean) {
        chi_square += (n - mean) * (n - mean) / mean;
        ++cells;
    };
    for (size_t i = 0; i < expected.size(); ++i) {
        if (expected[i] >= 10) {
            add(counted[i], expected[i]);
        } else {
            rest_counted += counted[i];
            rest_expected += expected[i];
        }
    }
    if (rest_expected >= 10) add(rest_counted, rest_expected);
    if (cells < 1) return 0;
    const double d = cells;
    return (std::cbrt(chi_square / d) - (1 - 2 / (9 * d))) / std::sqrt(2 / (9 * d));
}
