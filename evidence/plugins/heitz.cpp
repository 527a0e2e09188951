// SPDX-License-Identifier: Apache-2.0
// The sampler of Heitz, Belcour, Ostromoukhov, Coeurjolly and Iehl ("A Low-Discrepancy Sampler that Distributes Monte
// Carlo Errors as a Blue Noise in Screen Space", 2019). The argument is a folder with files 1.bin, 2.bin, 4.bin ..., which
// samplers/heitz.py writes: one byte for each entry of the authors' tables for that sample count, which are 256 points
// with 256 dimensions, and a scrambling and a ranking tile of 128 x 128 pixels with eight dimensions each. A path's first
// eight dimensions are those that the authors optimised: pixel position, light, and direction and light of ray 1. Seeds
// shift the tile.
#include <iterator>

#include "plugin_class.hpp"

namespace {

class Heitz {
  public:
    // Reads the tables for the next power of two, or the largest there are.
    Heitz(uint64_t, uint32_t samples, const std::string &folder) {
        for (uint32_t spp = 1; spp <= POINTS; spp *= 2) {
            std::ifstream file(folder + "/" + std::to_string(spp) + ".bin", std::ios::binary);
            if (!file) continue;
            tables_.assign(std::istreambuf_iterator<char>(file), {});
            if (samples > 0 && samples <= spp) break;
        }
        if (tables_.size() != RANKS + TILE) throw std::invalid_argument(folder);
    }

    void draw(const Draw &d, float *u) const {
        const uint32_t column = (uint32_t(d.x) + shift_of(d.seed, 0, 0)) % SIDE;
        const uint32_t row = (uint32_t(d.y) + shift_of(d.seed, 0, 1)) % SIDE;
        const auto place = [&](uint32_t pair) {
            return d.index < POINTS ? dimension_of(d.decision + pair) : POINTS;
        };
        draw_pairs(d, POINTS, u, place, [&](uint32_t first, float *out) {
            for (uint32_t i = first; i < first + 2; ++i) {
                const size_t own = 8 * (row * SIDE + column) + i % 8;
                const uint32_t point = d.index ^ entry(RANKS + own);
                *out++ =
                    float(entry(POINTS * point + i) ^ entry(SCRAMBLING + own)) / 256 + 0.5f / 256;
            }
        });
    }

  private:
    static constexpr uint32_t SIDE = 128, POINTS = 256;
    static constexpr size_t TILE = size_t{8} * SIDE * SIDE, SCRAMBLING = size_t{POINTS} * POINTS,
                            RANKS = SCRAMBLING + TILE;

    // The first of the two dimensions of a decision; POINTS if there are none.
    static uint32_t dimension_of(uint32_t decision) {
        if (decision >= 1u << 14) return POINTS; // loops
        const uint32_t slot = decision / 4, part = decision % 4;
        if (slot == 0) return part == 0 ? 0 : 2;  // position; lens or light
        if (slot == 3) return part == 0 ? 8 : 10; // first light; time
        if (slot == 1 && part < 2) return 4 + 2 * part;
        return 12 + 6 * (slot < 3 ? slot - 1 : slot - 2) + 2 * part;
    }

    uint32_t entry(size_t at) const { return static_cast<unsigned char>(tables_[at]); }

    std::vector<char> tables_;
};

} // namespace

SAMPLER_PLUGIN(Heitz, 1)
