// SPDX-License-Identifier: Apache-2.0
// The "sobol-global" sampler: one Sobol' sequence over the whole screen, as in pbrt (Gruenschloss, Raab and
// Keller, "Enumerating Quasi-Monte Carlo Point Sequences in Elementary Intervals", 2012). Its first two
// dimensions give the position on a screen of 4096 x 4096 pixels, which repeats. Every 2^24 points hit each
// pixel exactly once; sample i of a pixel is its point in round i. The other numbers are further dimensions of that
// point: time, lens, first light, then six for each ray. Boost.Random supplies Joe and Kuo's direction
// numbers. Each dimension uses its own Owen scrambling; for the position, the scrambling also differs in each pixel.
// Loops, and rays past the last dimension, use random numbers.
#include <boost/random/sobol.hpp>

#include <utility>
#include <vector>

#include "plugin_class.hpp"

namespace {

constexpr unsigned SCREEN = 12, BITS = 64; // log2 of the screen's width; digits
constexpr uint32_t DIMENSIONS = 512, PIXELS = (1u << SCREEN) - 1;

class SobolGlobal {
  public:
    SobolGlobal(uint64_t, uint32_t, const std::string &) : columns_(DIMENSIONS * BITS) {
        boost::random::sobol_engine<uint64_t, BITS> engine(DIMENSIONS);
        for (unsigned bit = 0; bit < BITS; ++bit) {
            // Boost counts in Gray code, so its number 2^k is the sum of columns k and k - 1.
            engine.seed((uint64_t{1} << bit) - 1);
            for (uint32_t d = 0; d < DIMENSIONS; ++d) {
                uint64_t *column = &columns_[d * BITS + bit];
                *column = engine() ^ (bit > 0 ? column[-1] : 0);
            }
        }
        // Gauss-Jordan elimination finds the bits below 2 SCREEN that move a point by one digit.
        uint32_t moves[2 * SCREEN];
        for (unsigned bit = 0; bit < 2 * SCREEN; ++bit) {
            moves[bit] = pixel_of(uint64_t{1} << bit);
            inverse_[bit] = 1u << bit;
        }
        for (unsigned digit = 0; digit < 2 * SCREEN; ++digit) {
            unsigned pivot = digit;
            while (!(moves[pivot] >> digit & 1u)) ++pivot; // positions form a net, so one exists
            std::swap(moves[pivot], moves[digit]);
            std::swap(inverse_[pivot], inverse_[digit]);
            for (unsigned other = 0; other < 2 * SCREEN; ++other) {
                if (other == digit || !(moves[other] >> digit & 1u)) continue;
                moves[other] ^= moves[digit];
                inverse_[other] ^= inverse_[digit];
            }
        }
    }

    void draw(const Draw &d, float *u) const {
        uint64_t point = uint64_t{d.index} << 2 * SCREEN;
        const uint32_t pixel = (uint32_t(d.x) & PIXELS) | (uint32_t(d.y) & PIXELS) << SCREEN;
        const uint32_t missing = pixel ^ shift(d.seed) ^ pixel_of(point);
        for (unsigned digit = 0; digit < 2 * SCREEN; ++digit)
            if (missing >> digit & 1u) point ^= inverse_[digit];
        const auto place = [&](uint32_t pair) { return dimension_of(d.decision, pair); };
        draw_pairs(d, DIMENSIONS, u, place, [&](uint32_t first, float *out) {
            for (uint32_t i = first; i < first + 2; ++i) {
                uint64_t digits = digits_of(point, i), scrambling = mix64(d.seed + 1) + i;
                if (i < 2) { // the position: use the digits below those of the pixel
                    digits <<= SCREEN;
                    scrambling += uint64_t{i == 0 ? pixel & PIXELS : pixel >> SCREEN} << 32;
                }
                *out++ = bn_draw_float(bn_owen(uint32_t(digits >> 32),
                                               uint32_t(mix64(scrambling + 0x9e3779b97f4a7c15u))));
            }
        });
    }

  private:
    uint64_t digits_of(uint64_t point, uint32_t dimension) const {
        uint64_t digits = 0;
        for (const uint64_t *column = &columns_[dimension * BITS]; point != 0;
             point >>= 1, ++column)
            if (point & 1u) digits ^= *column;
        return digits;
    }

    // The pixel of a point: the column, with the row in the next higher SCREEN bits.
    uint32_t pixel_of(uint64_t point) const {
        return uint32_t(digits_of(point, 0) >> (BITS - SCREEN)) |
               uint32_t(digits_of(point, 1) >> (BITS - SCREEN)) << SCREEN;
    }

    // Each seed moves a different pixel to (0, 0).
    static uint32_t shift(uint64_t seed) {
        return uint32_t(mix64(seed + 0x9e3779b97f4a7c15u)) >> (32 - 2 * SCREEN);
    }

    std::vector<uint64_t> columns_; // BITS columns for each dimension
    uint32_t inverse_[2 * SCREEN];
};

} // namespace

SAMPLER_PLUGIN(SobolGlobal, 0)
