// SPDX-License-Identifier: Apache-2.0
// OpenQMC's blue-noise samplers (Framestore, https://github.com/AcademySoftwareFoundation/openqmc, Apache-2.0), used as
// its README recommends: the root is a sampler for one pixel and index, each decision is a child of this root, and split
// light samples come from newDomainSplit(). Each pair of a decision is a child of its own, because only the first two
// numbers of a child are blue. OpenQMC takes no seed, so the frame number is a hash of the seed, which shifts the tables
// by the same amount in all pixels. The argument names the sampler: pmjbn, sobolbn or latticebn. With -4d after it, all four
// numbers of a decision come from one child.
#include <oqmc/latticebn.h>
#include <oqmc/pmjbn.h>
#include <oqmc/sobolbn.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "plugin_class.hpp"

namespace {

struct Peer {
    virtual ~Peer() = default;
    virtual void draw(int32_t x, int32_t y, uint32_t index, uint32_t decision, uint32_t dimensions,
                      float *u) const = 0;
    virtual void split(int32_t x, int32_t y, uint32_t index, uint32_t decision, uint32_t count,
                       uint32_t k, float *u) const = 0;
};

template <typename Native>
class Of final : public Peer {
  public:
    Of(uint64_t seed, bool whole)
        : whole_(whole), frame_(int(mix64(seed + 0x9e3779b97f4a7c15u) >> 34)),
          cache_(Native::cacheSize) {
        Native::initialiseCache(cache_.data());
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t decision, uint32_t dimensions,
              float *u) const override {
        const Native pixel = root(x, y, index);
        if (whole_ && dimensions == 4)
            return pixel.newDomain(int(decision)).template drawSample<4>(u);
        pixel.newDomain(int(decision)).template drawSample<2>(u);
        if (dimensions == 4) pixel.newDomain(int(decision + 1)).template drawSample<2>(u + 2);
    }

    void split(int32_t x, int32_t y, uint32_t index, uint32_t decision, uint32_t count, uint32_t k,
               float *u) const override {
        root(x, y, index)
            .newDomainSplit(int(decision), int(count), int(k))
            .template drawSample<2>(u);
    }

  private:
    Native root(int32_t x, int32_t y, uint32_t index) const {
        return Native(x, y, frame_, int(index), cache_.data());
    }

    bool whole_;
    int frame_; // has 30 bits, because OpenQMC adds the high half of the index to it
    std::vector<char> cache_;
};

struct OpenQmc {
    OpenQmc(uint64_t seed, uint32_t, const std::string &argument) {
        const std::string name = argument.substr(0, argument.find("-4d"));
        const bool whole = name != argument;
        if (name == "pmjbn") peer = std::make_unique<Of<oqmc::PmjBnSampler>>(seed, whole);
        if (name == "sobolbn") peer = std::make_unique<Of<oqmc::SobolBnSampler>>(seed, whole);
        if (name == "latticebn") peer = std::make_unique<Of<oqmc::LatticeBnSampler>>(seed, whole);
        if (!peer) throw std::invalid_argument(argument);
    }

    void draw(uint64_t, int32_t x, int32_t y, uint32_t index, uint32_t decision,
              uint32_t dimensions, float *u) const {
        peer->draw(x, y, index, decision, dimensions, u);
    }

    std::unique_ptr<const Peer> peer;
};

} // namespace

SAMPLER_PLUGIN(OpenQmc, 0)

void sampler_plugin_split(const void *state, uint64_t, int32_t x, int32_t y, uint32_t index,
                          uint32_t decision, uint32_t count, uint32_t k, float *out) {
    static_cast<const OpenQmc *>(state)->peer->split(x, y, index, decision, count, k, out);
}
