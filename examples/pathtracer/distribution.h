// SPDX-License-Identifier: Apache-2.0
// Chooses one of n items with probability proportional to its weight, by inversion, in O(log n).
// Unlike an alias table, inversion is monotonic: stratified numbers stay stratified and blue noise
// stays blue. Draws and the limits between items are multiples of 2^-24, so the stated
// probabilities are exact. Every weight above zero gets at least one step of 2^-24.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

constexpr float DRAW_STEP = 1.0f / (1 << 24);

// Writes count + 1 limits, from 0 to 1. Weights must be finite and non-negative; if all are zero,
// the first item is always chosen. At most 2^23 weights.
inline void distribution_build(const double *weights, size_t count, float *limits) {
    double total = 0;
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        total += weights[i];
        used += weights[i] > 0 ? 1 : 0;
    }
    const double shared = static_cast<double>((1u << 24) - used); // steps left after one each
    double sum = 0;
    size_t before = 0;
    limits[0] = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += weights[i];
        before += weights[i] > 0 ? 1 : 0;
        const double share = total > 0 ? std::min(sum / total, 1.0) : 0;
        const auto steps = static_cast<uint32_t>(share * shared) + static_cast<uint32_t>(before);
        limits[i + 1] = static_cast<float>(steps) * DRAW_STEP;
    }
    // Rounding may leave a step over. It must not go to trailing items of weight zero.
    size_t last = count;
    while (last > 1 && !(weights[last - 1] > 0)) --last;
    for (size_t i = last; i <= count; ++i) limits[i] = 1;
}

struct Choice {
    size_t index;
    float rest;        // where the number falls between the item's limits, in [0, 1)
    float probability; // of choosing this item
};

inline Choice distribution_choose(const float *limits, size_t count, float u) {
    const float *above = std::upper_bound(limits + 1, limits + count, u);
    const float low = above[-1], width = *above - low;
    // Use the middle of the step, so items only a few steps wide are not always hit at their start.
    const float rest = std::min((u - low + 0.5f * DRAW_STEP) / width, 1 - DRAW_STEP);
    return {static_cast<size_t>(above - 1 - limits), rest, width};
}
