// SPDX-License-Identifier: Apache-2.0
// The sampler "sobol4d": sobol4d.h behind the tracer's draws.
#include "sobol4d.h"

#include <algorithm>

#include "sampler.h"

namespace {

class Sobol4d final : public PeerSampler {
  public:
    explicit Sobol4d(uint64_t seed) : PeerSampler(seed), seed_(seed) {}

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        float all[4];
        sobol4d_draw(seed_, x, y, index, key, all);
        std::copy_n(all, dimensions, u);
    }

  private:
    uint64_t seed_;
};

} // namespace

PeerPointer sobol4d_create(uint64_t seed) {
    return std::make_unique<Sobol4d>(seed);
}
