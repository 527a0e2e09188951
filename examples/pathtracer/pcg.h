// SPDX-License-Identifier: Apache-2.0
// The sampler "pcg": what most small renderers have, one generator that every decision of a path asks
// for its next numbers. It is PCG32 (O'Neill, "PCG: A Family of Simple Fast Space-Efficient
// Statistically Good Algorithms for Random Number Generation", 2014), for comparison; `white` has the
// same error.
#pragma once

#include <bn/bn.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

#include "sobol4d.h"

class Pcg32 {
  public:
    Pcg32(uint64_t state, uint64_t stream) : increment_(2 * stream + 1) {
        state_ = (state + increment_) * 6364136223846793005u + increment_;
    }

    uint32_t next_bits() {
        const uint64_t old = state_;
        state_ = old * 6364136223846793005u + increment_;
        const auto word = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<uint32_t>(old >> 59);
        return word >> turn | word << (-turn & 31u);
    }
    float next_1d() { return static_cast<float>(next_bits() >> 8) * 0x1p-24f; }

    template <size_t N>
    std::array<float, N> next() {
        std::array<float, N> u;
        for (float &number : u) number = next_1d();
        return u;
    }

  private:
    uint64_t state_ = 0, increment_;
};

// One ray of a PcgPath, with the part of bn::Ray that the integrator uses. Every call advances the
// generator of the path, which must outlive it.
class PcgRay {
  public:
    explicit PcgRay(Pcg32 &generator) : generator_(&generator) {}

    std::array<float, 4> draw() const { return generator_->next<4>(); }
    std::array<float, 2> draw_where() const { return generator_->next<2>(); }
    float next_1d() { return generator_->next_1d(); }
    bn::Rng rng(uint32_t) const {
        const std::array<float, 4> u = draw();
        return bn::Rng({{u[0], u[1], u[2], u[3]},
                        {generator_->next_bits(), generator_->next_bits(), generator_->next_bits(),
                         generator_->next_bits()},
                        0});
    }

  private:
    Pcg32 *generator_;
};

// Like bn::Path. A generator of its own for each sample of a pixel, so that threads, tiles and crops
// cannot change a picture.
class PcgPath {
  public:
    PcgPath(uint64_t seed, int32_t x, int32_t y, uint32_t index)
        : generator_(started(
              seed, uint64_t{static_cast<uint32_t>(y)} << 32 | static_cast<uint32_t>(x), index)) {}

    PcgRay ray(uint32_t) const { return PcgRay(generator_); }
    std::array<float, 2> first_light(uint32_t, uint32_t) const { return generator_.next<2>(); }
    std::array<float, 2> time() const { return generator_.next<2>(); }

  private:
    static Pcg32 started(uint64_t seed, uint64_t pixel, uint32_t index) {
        return Pcg32(sobol4d_mix((sobol4d_mix(seed) ^ pixel) + index), pixel);
    }

    mutable Pcg32 generator_;
};
