// SPDX-License-Identifier: Apache-2.0
// Quad-optimised sequences in base 3 (Ostromoukhov et al., "Quad-Optimized Low-Discrepancy Sequences", 2024):
// consecutive pairs are (0,2)-sequences and consecutive quadruples (1,4)- or (2,4)-sequences. The argument is a file with
// initial numbers, one line for each of 48 dimensions: number, degree, polynomial, numbers, written in decimal.
// The authors' table is initIrreducibleGF3.dat in https://github.com/liris-origami/Quad-Optimized-LDS, which states no
// licence. Each pixel and dimension has its own Owen scrambling in base 3, like the authors' samples.
#include <array>

#include "plugin_class.hpp"

namespace {

// A quadruple for the first two pairs of each of 8 groups of four decisions, then a pair for the third of each.
constexpr uint32_t GROUPS = 8, DIMENSIONS = 6 * GROUPS, DIGITS = 20;

using Digits = std::array<uint8_t, DIGITS>; // most significant first
using Columns = std::array<Digits, DIGITS>; // by the index's digit, least significant first

// Sobol's recurrence over GF(3), from `degree` initial numbers. The base-3 digits of `polynomial` are its coefficients.
Columns columns_of(uint32_t degree, uint32_t polynomial, std::istream &numbers) {
    Columns c{};
    for (uint32_t k = 0; k < DIGITS; ++k) {
        if (k < degree) {
            uint64_t number = 0;
            numbers >> number;
            for (uint32_t row = k + 1; row-- > 0; number /= 3) c[k][row] = uint8_t(number % 3);
            if (c[k][k] == 0 || number != 0) throw std::invalid_argument("numbers");
            continue;
        }
        for (uint32_t row = 0; row < DIGITS; ++row) {
            uint32_t sum = row < degree ? 0 : c[k - degree][row - degree];
            for (uint32_t j = degree, rest = polynomial; j > 0; --j, rest /= 3)
                sum += (3 - rest % 3) * c[k - j][row];
            c[k][row] = uint8_t(sum % 3);
        }
    }
    return c;
}

class QuadOptimized {
  public:
    QuadOptimized(uint64_t, uint32_t, const std::string &path)
        : dimensions_(read_dimensions(path, DIGITS, DIMENSIONS, columns_of)) {}

    void draw(const Draw &d, float *u) const {
        const auto place = [&](uint32_t pair) {
            const uint32_t group = d.decision / 4, part = d.decision % 4 + pair;
            if (group >= GROUPS || part > 2) return DIMENSIONS;
            return part < 2 ? 4 * group + 2 * part : 4 * GROUPS + 2 * group;
        };
        draw_pairs(d, DIMENSIONS, u, place, [&](uint32_t first, float *out) {
            for (uint32_t i = first; i < first + 2; ++i)
                *out++ = scrambled(dimensions_[i], d.index, mix64(d.pixel() + i));
        });
    }

  private:
    // The number at `index`; each digit is permuted depending on those before it, by a random one of all six maps.
    static float scrambled(const Columns &columns, uint32_t index, uint64_t key) {
        Digits digits{};
        for (uint32_t k = 0; k < DIGITS && index > 0; ++k, index /= 3)
            for (uint32_t row = 0; row < DIGITS; ++row)
                digits[row] = uint8_t(digits[row] + index % 3 * columns[k][row]); // at most 80
        uint64_t value = 0, before = 0;
        for (const uint8_t sum : digits) {
            const uint64_t random = mix64(key + before), digit = sum % 3u;
            value = 3 * value + (digit * (1 + random % 2) + (random >> 8) % 3) % 3;
            before = 3 * before + digit + 1;
        }
        return bn_draw_float(uint32_t((value << 32) / 3486784401)); // 3^20
    }

    std::vector<Columns> dimensions_;
};

} // namespace

SAMPLER_PLUGIN(QuadOptimized, 0)
