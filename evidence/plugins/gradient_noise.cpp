// SPDX-License-Identifier: Apache-2.0
// Interleaved gradient noise (Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare",
// 2014): one regular pattern, shifted by 5.588238 pixels for each index and by other amounts for each number.
#include <cmath>

#include "plugin_class.hpp"

namespace {

class GradientNoise {
  public:
    GradientNoise(uint64_t, uint32_t, const std::string &) {}

    void draw(const Draw &d, float *u) const {
        const double frame = 5.588238 * double(d.index % 64);
        for (uint32_t i = 0; i < d.dimensions; ++i) {
            const double at =
                0.06711056 * (d.x + double(shift_of(d.seed, d.decision, 2 * i)) + frame) +
                0.00583715 * (d.y + double(shift_of(d.seed, d.decision, 2 * i + 1)) + frame);
            const double wide = 52.9829189 * (at - std::floor(at));
            u[i] = bn_draw_float(uint32_t((wide - std::floor(wide)) * 0x1p32));
        }
    }
};

} // namespace

SAMPLER_PLUGIN(GradientNoise, 0)
