// SPDX-License-Identifier: Apache-2.0
// The time of OpenQMC's draws, inlined and used as in its README: one sampler for each pixel and index,
// newDomain() for each decision, and drawSample(). The first draw fills its tables and is not timed.
#include "bench_openqmc.h"

#include <oqmc/latticebn.h>
#include <oqmc/pmjbn.h>
#include <oqmc/sobolbn.h>

#include <vector>

namespace {

template <typename Sampler>
const void *cache() {
    static const std::vector<char> filled = [] {
        std::vector<char> memory(Sampler::cacheSize);
        Sampler::initialiseCache(memory.data());
        return memory;
    }();
    return filled.data();
}

template <typename Sampler>
float draw(int32_t y0, int32_t width, int32_t height, uint32_t indices, uint32_t domains) {
    const void *tables = cache<Sampler>();
    float sum = 0;
    for (int32_t y = y0; y < y0 + height; ++y) {
        for (int32_t x = 0; x < width; ++x) {
            for (uint32_t index = 0; index < indices; ++index) {
                const Sampler root(x, y, 0, static_cast<int>(index), tables);
                for (uint32_t key = 0; key < domains; ++key) {
                    float u[4] = {};
                    root.newDomain(static_cast<int>(key)).template drawSample<4>(u);
                    sum += u[0] + u[1] + u[2] + u[3];
                }
            }
        }
    }
    return sum;
}

template <typename Sampler>
constexpr bench_peer peer(const char *name) {
    return {name, draw<Sampler>};
}

} // namespace

const bench_peer bench_peers[BENCH_PEERS] = {
    peer<oqmc::PmjBnSampler>("openqmc-pmjbn"),
    peer<oqmc::SobolBnSampler>("openqmc-sobolbn"),
    peer<oqmc::LatticeBnSampler>("openqmc-latticebn"),
};
