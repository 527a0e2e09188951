// SPDX-License-Identifier: Apache-2.0
// A rank-1 lattice of each pixel, shifted on the torus by a random amount (Cranley and Patterson, "Randomization of
// Number Theoretic Methods for Multiple Integration", 1976). Samples are taken in the order of the radical inverse of
// their index, so every power of two is a lattice (Hickernell et al., "Extensible Lattice Sequences for Quasi-Monte Carlo
// Quadrature", 2000). Each decision has the same four-dimensional Korobov lattice and a shift of its own.
#include "plugin_class.hpp"

namespace {

// (1, a, a^2, a^3) with the generator of Hickernell et al. for lattices of up to 2^20 points.
constexpr uint32_t GENERATOR = 17797;

uint32_t reversed(uint32_t v) {
    v = v << 16 | v >> 16;
    v = (v & 0x00ff00ffu) << 8 | (v & 0xff00ff00u) >> 8;
    v = (v & 0x0f0f0f0fu) << 4 | (v & 0xf0f0f0f0u) >> 4;
    v = (v & 0x33333333u) << 2 | (v & 0xccccccccu) >> 2;
    return (v & 0x55555555u) << 1 | (v & 0xaaaaaaaau) >> 1;
}

struct Lattice {
    Lattice(uint64_t, uint32_t, const std::string &) {}

    void draw(const Draw &d, float *u) const {
        const uint64_t shift = mix64(d.pixel() + d.decision);
        uint32_t point = reversed(d.index);
        for (uint32_t i = 0; i < d.dimensions; ++i, point *= GENERATOR)
            u[i] = bn_draw_float(point + uint32_t(mix64(shift + (uint64_t{i + 1} << 32))));
    }
};

} // namespace

SAMPLER_PLUGIN(Lattice, 0)
