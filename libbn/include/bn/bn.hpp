// SPDX-License-Identifier: Apache-2.0
// libbn for C++17: samplers that own themselves, domains and draws as values. Everything is inline
// over bn.h, which remains the manual; the draws are equal to the bit.
//
//     const bn::Sampler sampler(BN_SAMPLER_BLUE, seed);                // throws bn::Error
//     const bn::Domain light = bn::Domain().child(frame).child(KEY_LIGHT);
//     const auto [s, t] = sampler.sample<2>(x, y, index, light);       // std::array<float, 2>
//
// A Sampler is immutable: all threads may share it. It can be moved but not copied. After a move,
// the old one holds nothing: draw from it no more. Only functions that are not noexcept throw:
// bn::Error with the result of the library, or std::bad_alloc for memory of their own. The rest of
// the library is used as in C; sampler.get() is the bn_sampler.
#ifndef BN_BN_HPP
#define BN_BN_HPP

#if __cplusplus < 201703L && !(defined(_MSVC_LANG) && _MSVC_LANG >= 201703L)
#error "bn.hpp needs C++17 (-std=c++17 or /std:c++17); C++11 can use bn.h"
#else

#include <bn/bn.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bn {

// A result other than BN_SUCCESS. what() names the function and has the text of the result.
class Error : public std::runtime_error {
  public:
    Error(const char *function, bn_result result)
        : std::runtime_error(std::string(function) + ": " + bn_result_string(result)),
          result_(result) {}

    bn_result result() const noexcept { return result_; }

  private:
    bn_result result_;
};

// Throws bn::Error unless the result is BN_SUCCESS. For other functions of bn.h too:
// bn::check("bn_dither", bn_dither(...)).
inline void check(const char *function, bn_result result) {
    if (result != BN_SUCCESS) throw Error(function, result);
}

// The name of one decision of a path. A Domain without arguments is the root.
class Domain {
  public:
    constexpr Domain() noexcept = default;
    constexpr explicit Domain(uint32_t value) noexcept : value_(value) {}

    // bn_domain_child(). Keys 4 k to 4 k + 3 are a family.
    Domain child(uint32_t key) const noexcept { return Domain(bn_domain_child(value_, key)); }

    // For the functions of bn.h, bn_draw.h and shaders.
    constexpr uint32_t value() const noexcept { return value_; }

    friend constexpr bool operator==(Domain a, Domain b) noexcept { return a.value_ == b.value_; }
    friend constexpr bool operator!=(Domain a, Domain b) noexcept { return a.value_ != b.value_; }

  private:
    uint32_t value_ = BN_DOMAIN_ROOT;
};

class Sampler {
  public:
    // All options of bn.h. Throws INVALID_ARGUMENT, BAD_DATA, OUT_OF_MEMORY or UNSUPPORTED, as
    // bn_sampler_create() says. A mask is copied.
    explicit Sampler(const bn_sampler_options &options = bn_sampler_options_default()) {
        check("bn_sampler_create", bn_sampler_create(&options, &sampler_));
    }
    // BN_SAMPLER_..., with the other options at their defaults.
    explicit Sampler(int32_t kind, uint64_t seed = 0) : Sampler(options_of(kind, seed)) {}

    ~Sampler() { bn_sampler_destroy(sampler_); }
    Sampler(Sampler &&other) noexcept : sampler_(std::exchange(other.sampler_, nullptr)) {}
    Sampler &operator=(Sampler &&other) noexcept {
        std::swap(sampler_, other.sampler_);
        return *this;
    }
    Sampler(const Sampler &) = delete;
    Sampler &operator=(const Sampler &) = delete;

    // The first N dimensions, 1 to 4, of sample `index` of pixel (x, y) in a domain.
    template <std::size_t N = 4>
    std::array<float, N> sample(int32_t x, int32_t y, uint32_t index,
                                Domain domain = Domain()) const noexcept {
        static_assert(N >= 1 && N <= 4,
                      "a domain has four dimensions; draw more from its children");
        std::array<float, N> out{};
        if constexpr (N == 4) {
            bn_sample_4d(sampler_, x, y, index, domain.value(), out.data());
        } else if constexpr (N == 2) {
            bn_sample_2d(sampler_, x, y, index, domain.value(), out.data());
        } else if constexpr (N == 1) {
            out[0] = bn_sample_1d(sampler_, x, y, index, domain.value());
        } else {
            const std::array<float, 4> all = sample<4>(x, y, index, domain);
            for (std::size_t i = 0; i < N; ++i) out[i] = all[i];
        }
        return out;
    }

    // One pair of dimensions alone: (0, 1) with pair 0, (2, 3) with pair 1.
    std::array<float, 2> sample_pair(int32_t x, int32_t y, uint32_t index, Domain domain,
                                     uint32_t pair) const noexcept {
        std::array<float, 2> out{};
        bn_sample_pair(sampler_, x, y, index, domain.value(), pair, out.data());
        return out;
    }

    // All four dimensions, 32 random bits each.
    std::array<uint32_t, 4> sample_u32(int32_t x, int32_t y, uint32_t index,
                                       Domain domain = Domain()) const noexcept {
        std::array<uint32_t, 4> out{};
        bn_sample_4d_u32(sampler_, x, y, index, domain.value(), out.data());
        return out;
    }

    // bn_sample_many(): the first N dimensions for all lanes of a wavefront, to out[count][N]. The
    // domains are values of Domain. Throws INVALID_ARGUMENT for a null pointer, unless count is 0.
    template <std::size_t N = 4>
    void sample_many(std::size_t count, const int32_t *x, const int32_t *y, const uint32_t *index,
                     const uint32_t *domain, float *out) const {
        static_assert(N >= 1 && N <= 4,
                      "a domain has four dimensions; draw more from its children");
        check("bn_sample_many",
              bn_sample_many(sampler_, count, x, y, index, domain, N, out, count * N));
    }

    // bn_sample_many_pair(): one pair of dimensions, 0 or 1, to out[count][2]. Throws
    // INVALID_ARGUMENT for another pair too.
    void sample_many_pair(std::size_t count, const int32_t *x, const int32_t *y,
                          const uint32_t *index, const uint32_t *domain, uint32_t pair,
                          float *out) const {
        check("bn_sample_many_pair",
              bn_sample_many_pair(sampler_, count, x, y, index, domain, pair, out, count * 2));
    }

    // bn_sample_block(): [height][width][index_count][4]. Throws INVALID_ARGUMENT for a zero extent
    // or a block past the last coordinate or index, and OUT_OF_MEMORY if it is too large to count.
    std::vector<float> block(int32_t x0, int32_t y0, uint32_t width, uint32_t height,
                             uint32_t first_index, uint32_t index_count,
                             Domain domain = Domain()) const {
        std::size_t count = 4;
        for (const uint32_t extent : {width, height, index_count}) {
            if (extent != 0 && count > out_max / extent)
                throw Error("bn_sample_block", BN_ERROR_OUT_OF_MEMORY);
            count *= extent;
        }
        std::vector<float> out(count);
        float none = 0; // an empty vector may have no address, which is another mistake
        check("bn_sample_block",
              bn_sample_block(sampler_, x0, y0, width, height, first_index, index_count,
                              domain.value(), out.empty() ? &none : out.data(), out.size()));
        return out;
    }

    // For the functions of bn.h and bn_draw.h. The Sampler keeps it.
    const bn_sampler *get() const noexcept { return sampler_; }

  private:
    static constexpr std::size_t out_max = static_cast<std::size_t>(-1) / 2 / sizeof(float);

    static bn_sampler_options options_of(int32_t kind, uint64_t seed) {
        bn_sampler_options options = bn_sampler_options_default();
        options.kind = kind;
        options.seed = seed;
        return options;
    }

    bn_sampler *sampler_ = nullptr;
};

} // namespace bn

#endif // C++17
#endif
