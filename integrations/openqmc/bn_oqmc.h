// SPDX-License-Identifier: Apache-2.0
// libbn's `blue` sampler behind OpenQMC's sampler interface, for renderers built on OpenQMC. OpenQMC itself is
// not needed. Requires C++14 and libbn. README.md lists how each call maps to libbn.
#ifndef BN_OQMC_H
#define BN_OQMC_H

#include <bn/bn_draw.h>
#include <bn/bn_path.h>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace bn {

// The four numbers of one domain, for one sample of a pixel. A 24-byte value: pass it by value.
class OpenQmcSampler {
  public:
    // The memory that initialiseCache() fills. Keep it while samplers are in use.
    static constexpr std::size_t cacheSize = sizeof(bn_sampler);

    static void initialiseCache(void *cache) { initialiseCache(cache, 0); }
    // Different seeds give independent images.
    static void initialiseCache(void *cache, uint64_t seed) {
        assert(cache != nullptr);
        *static_cast<bn_sampler *>(cache) = bn_sampler_make(seed);
    }

    // Empty: assign a sampler before you draw.
    OpenQmcSampler() = default;
    // Sample `index` (0, 1, 2 ...) of pixel (x, y) in frame `frame` of an animation. If you average frames, pass frame
    // 0 and continue the index across frames: the mean is then as good as a single frame that uses all the samples.
    OpenQmcSampler(int x, int y, int frame, int index, const void *cache)
        : sampler_(static_cast<const bn_sampler *>(cache)),
          path_(bn_path_start(x, y, static_cast<uint32_t>(index), static_cast<uint32_t>(frame))) {
        assert(cache != nullptr && index >= 0);
    }

    // Domains with keys 4*k to 4*k + 3 are stratified together. Use them for decisions whose effects multiply.
    OpenQmcSampler newDomain(int key) const {
        return with(path_.index, bn_domain_child(path_.domain, static_cast<uint32_t>(key)));
    }

    // Branch `index` of `size`. All branches of all samples of the pixel form one sequence.
    OpenQmcSampler newDomainSplit(int key, int size, int index) const {
        assert(size > 0 && index >= 0);
        const bn_path branch =
            bn_path_branch(path_, bn_domain_child(path_.domain, static_cast<uint32_t>(key)),
                           static_cast<uint32_t>(size), static_cast<uint32_t>(index));
        return with(branch.index, branch.domain);
    }

    // Branch `index` of a variable number. The branches of each sample form a sequence.
    OpenQmcSampler newDomainDistrib(int key, int index) const {
        assert(index >= 0);
        const uint32_t domain = bn_domain_child(path_.domain, static_cast<uint32_t>(key));
        return with(static_cast<uint32_t>(index), bn_domain_child(domain, path_.index));
    }

    // Branch `index` of a variable number. Each branch forms a sequence over the samples of the pixel.
    OpenQmcSampler newDomainChain(int key, int index) const {
        return newDomain(key).newDomain(index);
    }

    // Size is 1 to 4. Use dimensions (0, 1) and (2, 3) as pairs for 2-D decisions. Integers are below 2^32 or `range`;
    // floats are in [0, 1).
    template <int Size>
    void drawSample(std::uint32_t sample[Size]) const {
        std::uint32_t bits[4];
        bn_draw_4d_u32(sampler_, path_.x, path_.y, path_.index, path_.domain, bits);
        store<Size>(bits, sample);
    }
    template <int Size>
    void drawSample(std::uint32_t range, std::uint32_t sample[Size]) const {
        drawSample<Size>(sample);
        below<Size>(range, sample);
    }
    template <int Size>
    void drawSample(float sample[Size]) const {
        std::uint32_t bits[Size];
        drawSample<Size>(bits);
        floats<Size>(bits, sample);
    }

    // Independent random numbers, unrelated to drawSample().
    template <int Size>
    void drawRnd(std::uint32_t rnd[Size]) const {
        const bn_uint4 v =
            bn_draw_white_bits(bn_draw_seed(sampler_), static_cast<uint32_t>(path_.x),
                               static_cast<uint32_t>(path_.y), path_.index, path_.domain);
        const std::uint32_t bits[4] = {v.x, v.y, v.z, v.w};
        store<Size>(bits, rnd);
    }
    template <int Size>
    void drawRnd(std::uint32_t range, std::uint32_t rnd[Size]) const {
        drawRnd<Size>(rnd);
        below<Size>(range, rnd);
    }
    template <int Size>
    void drawRnd(float rnd[Size]) const {
        std::uint32_t bits[Size];
        drawRnd<Size>(bits);
        floats<Size>(bits, rnd);
    }

  private:
    OpenQmcSampler with(uint32_t index, uint32_t domain) const {
        OpenQmcSampler other = *this;
        other.path_.index = index;
        other.path_.domain = domain;
        return other;
    }

    template <int Size>
    static void store(const std::uint32_t bits[4], std::uint32_t out[Size]) {
        static_assert(Size >= 1 && Size <= 4, "a domain has four dimensions");
        for (int k = 0; k < Size; ++k) out[k] = bits[k];
    }

    template <int Size>
    static void floats(const std::uint32_t bits[Size], float out[Size]) {
        for (int k = 0; k < Size; ++k) out[k] = bn_draw_float(bits[k]);
    }

    template <int Size>
    static void below(std::uint32_t range, std::uint32_t out[Size]) {
        assert(range > 0);
        for (int k = 0; k < Size; ++k)
            out[k] = static_cast<std::uint32_t>(std::uint64_t{out[k]} * range >> 32);
    }

    const bn_sampler *sampler_ = nullptr;
    bn_path path_{};
};

} // namespace bn

#endif
