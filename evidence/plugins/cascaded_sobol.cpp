// SPDX-License-Identifier: Apache-2.0
// Cascaded Sobol' sampling (Paulin et al., "Cascaded Sobol' Sampling", 2021), tuned for a power of two of samples: the value
// of each dimension is the index of the next, so consecutive dimensions form nets. The argument is a file with initial
// direction numbers, one line for each dimension: number, degree, polynomial, numbers. The authors' table is
// data/cascaded_sobol_init_tab.dat in https://github.com/loispaulin/CascadedSobol (MIT). Each pixel and dimension has its
// own Owen scrambling.
#include <array>

#include "plugin_class.hpp"

namespace {

using Columns = std::array<uint32_t, 32>; // by the index's bit

// Sobol's recurrence, from `degree` initial numbers. The polynomial's coefficients are in the order of its powers.
Columns columns_of(uint32_t degree, uint32_t polynomial, std::istream &numbers) {
    Columns m{};
    for (uint32_t k = 0; k < 32; ++k) {
        if (k < degree) {
            if (!(numbers >> m[k])) throw std::invalid_argument("numbers");
            continue;
        }
        m[k] = m[k - degree] ^ m[k - degree] << degree;
        for (uint32_t i = 1; i < degree; ++i)
            if (polynomial >> (degree - 1 - i) & 1u) m[k] ^= m[k - i] << i;
    }
    for (uint32_t k = 0; k < 32; ++k) m[k] <<= 31 - k;
    return m;
}

class CascadedSobol {
  public:
    CascadedSobol(uint64_t, uint32_t samples, const std::string &path)
        : dimensions_(read_dimensions(path, 31, 16, columns_of)) {
        while (bits_ < 31 && (1u << bits_) < (samples > 0 ? samples : 256u)) ++bits_;
    }

    void draw(const Draw &d, float *u) const {
        const auto place = [&](uint32_t pair) { return dimension_of(d.decision, pair); };
        draw_pairs(d, uint32_t(dimensions_.size()) - 1, u, place, [&](uint32_t first, float *out) {
            uint32_t value = d.index;
            for (uint32_t i = 0; i < first + 2; ++i) {
                const uint32_t before = i == 0 || bits_ == 0 ? value : value >> (32 - bits_);
                value = 0;
                for (uint32_t k = 0; before >> k > 0; ++k)
                    if (before >> k & 1u) value ^= dimensions_[i][k];
                if (i >= first)
                    out[i - first] = bn_draw_float(bn_owen(value, uint32_t(mix64(d.pixel() + i))));
            }
        });
    }

  private:
    std::vector<Columns> dimensions_;
    uint32_t bits_ = 0; // log2 of the number of samples
};

} // namespace

SAMPLER_PLUGIN(CascadedSobol, 1)
