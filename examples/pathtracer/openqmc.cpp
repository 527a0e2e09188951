// SPDX-License-Identifier: Apache-2.0
// OpenQMC's blue-noise samplers (Framestore, https://github.com/AcademySoftwareFoundation/openqmc)
// beside libbn's, in builds with -DBN_OPENQMC=DIR. They are used as its README recommends: the root
// is a sampler for one pixel and index, each decision of a path is a child of it by newDomain(),
// and split light samples of one path come from newDomainSplit().
//
// OpenQMC takes no seed; the frame number re-randomises its patterns. From it and the domain keys
// OpenQMC derives how far its tables are shifted on the screen. The shift is the same for all
// pixels, which keeps their blue noise intact. Here the frame number is a hash of the seed.
#include "sampler.h"

#ifdef BN_WITH_OPENQMC

#include <oqmc/latticebn.h>
#include <oqmc/pmjbn.h>
#include <oqmc/sobolbn.h>

#include "sobol4d.h"

namespace {

// 30 bits, because OpenQMC adds the high half of the index to its frame number, an int.
int frame_of(uint64_t seed) {
    return static_cast<int>(sobol4d_mix(seed + 0x9e3779b97f4a7c15u) >> 34);
}

template <typename Native>
class OpenQmcSampler final : public PeerSampler {
  public:
    explicit OpenQmcSampler(uint64_t own_seed)
        : PeerSampler(own_seed), frame_(frame_of(own_seed)), cache_(Native::cacheSize) {
        Native::initialiseCache(cache_.data());
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        const Native pixel = root(x, y, index);
        pixel.newDomain(static_cast<int>(key)).template drawSample<2>(u);
        if (dimensions == 4)
            pixel.newDomain(static_cast<int>(key + 1)).template drawSample<2>(u + 2);
    }

    void draw_split(int32_t x, int32_t y, uint32_t index, uint32_t key, uint32_t count, uint32_t k,
                    float *u) const override {
        root(x, y, index)
            .newDomainSplit(static_cast<int>(key), static_cast<int>(count), static_cast<int>(k))
            .template drawSample<2>(u);
    }

  private:
    Native root(int32_t x, int32_t y, uint32_t index) const {
        return Native(x, y, frame_, static_cast<int>(index), cache_.data());
    }

    int frame_;
    std::vector<char> cache_;
};

} // namespace

std::vector<SamplerEntry> openqmc_entries() {
    return {
        {"openqmc-pmjbn", "OpenQMC: multi-jittered, blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::PmjBnSampler>>},
        {"openqmc-sobolbn", "OpenQMC: Sobol', blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::SobolBnSampler>>},
        {"openqmc-latticebn", "OpenQMC: rank-1 lattice, blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::LatticeBnSampler>>},
    };
}

#else

std::vector<SamplerEntry> openqmc_entries() {
    return {};
}

#endif
