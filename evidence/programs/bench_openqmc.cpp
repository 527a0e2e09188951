// SPDX-License-Identifier: Apache-2.0
// OpenQMC in the benchmarks, used as in its README: one sampler for each pixel and index,
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
void read_row(uint32_t seed, uint32_t parent, uint32_t key, int32_t y, int32_t width,
              uint32_t count, float *out) {
    // The frame number re-randomises the sampler, as in the path tracer's adapter.
    const int frame = static_cast<int>((seed * 0x9e3779b9u) >> 2);
    for (int32_t x = 0; x < width; ++x) {
        for (uint32_t index = 0; index < count; ++index, out += 4) {
            const Sampler root(x, y, frame, static_cast<int>(index), cache<Sampler>());
            root.newDomain(static_cast<int>(parent))
                .newDomain(static_cast<int>(key))
                .template drawSample<4>(out);
        }
    }
}

template <typename Sampler>
constexpr bench_peer peer(const char *name) {
    return {name, draw<Sampler>, read_row<Sampler>};
}

} // namespace

const bench_peer bench_peers[BENCH_PEERS] = {
    peer<oqmc::PmjBnSampler>("openqmc-pmjbn"),
    peer<oqmc::SobolBnSampler>("openqmc-sobolbn"),
    peer<oqmc::LatticeBnSampler>("openqmc-latticebn"),
};
