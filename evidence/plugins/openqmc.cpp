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

#include <variant>

#include "plugin_class.hpp"

namespace {

template <typename Native>
class Of {
  public:
    explicit Of(int frame) : frame_(frame), cache_(Native::cacheSize) {
        Native::initialiseCache(cache_.data());
    }
    Native root(int32_t x, int32_t y, uint32_t index) const {
        return Native(x, y, frame_, int(index), cache_.data());
    }

  private:
    int frame_;
    std::vector<char> cache_;
};

using Any =
    std::variant<Of<oqmc::PmjBnSampler>, Of<oqmc::SobolBnSampler>, Of<oqmc::LatticeBnSampler>>;

Any any_of(const std::string &name, uint64_t seed) {
    // 30 bits, because OpenQMC adds the high half of the index to it
    const int frame = int(mix64(seed + 0x9e3779b97f4a7c15u) >> 34);
    if (name == "pmjbn") return Of<oqmc::PmjBnSampler>(frame);
    if (name == "sobolbn") return Of<oqmc::SobolBnSampler>(frame);
    if (name == "latticebn") return Of<oqmc::LatticeBnSampler>(frame);
    throw std::invalid_argument(name);
}

struct OpenQmc {
    OpenQmc(uint64_t seed, uint32_t, const std::string &argument)
        : peer(any_of(argument.substr(0, argument.find("-4d")), seed)),
          whole(argument.find("-4d") != std::string::npos) {}

    void draw(const Draw &d, float *u) const {
        std::visit(
            [&](const auto &own) {
                const auto pixel = own.root(d.x, d.y, d.index);
                if (whole && d.dimensions == 4)
                    return pixel.newDomain(int(d.decision)).template drawSample<4>(u);
                pixel.newDomain(int(d.decision)).template drawSample<2>(u);
                if (d.dimensions == 4)
                    pixel.newDomain(int(d.decision + 1)).template drawSample<2>(u + 2);
            },
            peer);
    }

    Any peer;
    bool whole;
};

} // namespace

SAMPLER_PLUGIN(OpenQmc, 0)

void sampler_plugin_split(const void *state, uint64_t, int32_t x, int32_t y, uint32_t index,
                          uint32_t decision, uint32_t count, uint32_t k, float *out) {
    std::visit(
        [&](const auto &own) {
            own.root(x, y, index)
                .newDomainSplit(int(decision), int(count), int(k))
                .template drawSample<2>(out);
        },
        static_cast<const OpenQmc *>(state)->peer);
}
