// SPDX-License-Identifier: Apache-2.0
// Samplers of others, which the path tracer shows beside libbn's. A renderer needs nothing of this.
#pragma once

#include <cstdint>
#include <memory>

// A sampler that is not in libbn, for comparison. Each half of a 4-D draw may be a decision with a
// key of its own there: `key` for dimensions 0 and 1, `key + 1` for 2 and 3.
class PeerSampler {
  public:
    static constexpr uint64_t INDEX_LIMIT = uint64_t{1} << 31;

    virtual ~PeerSampler() = default;
    // Like draw() and draw_split() below; only the requested dimensions are written.
    virtual void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
                      float *u) const = 0;
    virtual void draw_split(int32_t x, int32_t y, uint32_t index, uint32_t key, uint32_t count,
                            uint32_t k, float *u) const = 0;
};
using PeerPointer = std::unique_ptr<const PeerSampler>;

// In sobol4d.cpp.
PeerPointer sobol4d_create(uint64_t seed);
