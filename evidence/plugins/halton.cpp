// SPDX-License-Identifier: Apache-2.0
// The Halton sequence over the whole screen, as in pbrt (Halton, "Algorithm 247: Radical-Inverse Quasi-Random Point
// Sequence", 1964; Gruenschloss, Raab and Keller, "Enumerating Quasi-Monte Carlo Point Sequences in Elementary
// Intervals", 2012). Its first two dimensions, in bases 2 and 3, give the position in tiles of 128 x 243 pixels: every
// 31,104 points hit each pixel of a tile once. Each further dimension uses the next prime and Owen scrambling. Seeds
// shift the tiles and change the scrambling.
#include <array>

#include "plugin_class.hpp"

namespace {

constexpr uint32_t DIMENSIONS = 128, WIDTH = 128, HEIGHT = 243, STRIDE = WIDTH * HEIGHT;

constexpr std::array<uint32_t, DIMENSIONS> primes() {
    std::array<uint32_t, DIMENSIONS> found{};
    uint32_t count = 0;
    for (uint32_t n = 2; count < DIMENSIONS; ++n) {
        bool prime = true;
        for (uint32_t i = 0; i < count && prime; ++i) prime = n % found[i] != 0;
        if (prime) found[count++] = n;
    }
    return found;
}
constexpr std::array<uint32_t, DIMENSIONS> PRIMES = primes();

// The radical inverse of `digits` digits, as a whole number.
uint64_t mirrored(uint64_t v, uint32_t base, uint32_t digits) {
    uint64_t result = 0;
    for (; digits > 0; --digits, v /= base) result = result * base + v % base;
    return result;
}

// A digit's place in a random permutation of 0 .. base - 1: a random affine map, which is one because bases are prime.
uint64_t permuted(uint64_t digit, uint32_t base, uint64_t key) {
    return (digit * (1 + mix64(key) % (base - 1)) + mix64(key + 1)) % base;
}

// The radical inverse, with digits permuted depending on those before them (Owen, "Randomly Permuted (t,m,s)-Nets and
// (t,s)-Sequences", 1995), in [0, 1).
float scrambled(uint64_t index, uint32_t base, uint64_t key) {
    double value = 0, place = 1;
    for (uint64_t before = 0; place > 0x1p-30; index /= base) {
        place /= base;
        value += place * double(permuted(index % base, base, mix64(key + before)));
        before = before * base + index % base + 1;
    }
    return bn_draw_float(uint32_t(value * 0x1p32));
}

struct Halton {
    Halton(uint64_t, uint32_t, const std::string &) {}

    void draw(const Draw &d, float *u) const {
        const uint64_t key = mix64(d.seed + 1);
        const uint64_t column = wrapped(d.x, key, WIDTH), row = wrapped(d.y, key >> 32, HEIGHT);
        // The point is column's mirror image modulo 128, and row's modulo 243 (Chinese remainder theorem: 59 is
        // the inverse of 243 modulo 128, and 131 of 128 modulo 243).
        const uint64_t first =
            (mirrored(column, 2, 7) * HEIGHT * 59 + mirrored(row, 3, 5) * WIDTH * 131) % STRIDE;
        const uint64_t point = first + uint64_t{d.index} * STRIDE;
        const auto place = [&](uint32_t pair) { return dimension_of(d.decision, pair); };
        draw_pairs(d, DIMENSIONS, u, place, [&](uint32_t dimension, float *out) {
            for (uint32_t i = 0; i < 2; ++i) {
                uint64_t own = mix64(key + dimension + i + 1), digits = point;
                if (dimension == 0) { // the position: the digits below those of the pixel
                    digits /= i == 0 ? WIDTH : HEIGHT;
                    own += i == 0 ? column : row;
                }
                out[i] = scrambled(digits, PRIMES[dimension + i], mix64(own));
            }
        });
    }

  private:
    static uint64_t wrapped(int32_t at, uint64_t shift, int64_t size) {
        const int64_t place = (at + int64_t(shift % uint64_t(size))) % size;
        return uint64_t(place < 0 ? place + size : place);
    }
};

} // namespace

SAMPLER_PLUGIN(Halton, 0)
