// SPDX-License-Identifier: Apache-2.0
// Interleaved gradient noise (Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare",
// 2014): one regular pattern, shifted by 5.588238 pixels for each index and by other amounts for each number.
#include <cmath>

#include "plugin_class.hpp"

namespace {

class GradientNoise {
  public:
    GradientNoise(uint64_t, uint32_t, const std::string &) {}

    void draw(uint64_t seed, int32_t x, int32_t y, uint32_t index, uint32_t decision,
              uint32_t dimensions, float *u) const {
        const double frame = 5.588238 * double(index % 64);
        for (uint32_t d = 0; d < dimensions; ++d) {
            const uint32_t number = 2 * d;
            const double at =
                0.06711056 * (x + double(shift_of(seed, decision, number)) + frame) +
                0.00583715 * (y + double(shift_of(seed, decision, number + 1)) + frame);
            const double wide = 52.9829189 * (at - std::floor(at));
            u[d] = bn_draw_float(uint32_t((wide - std::floor(wide)) * 0x1p32));
        }
    }
};

} // namespace

SAMPLER_PLUGIN(GradientNoise, 0)
