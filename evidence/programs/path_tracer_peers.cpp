// SPDX-License-Identifier: Apache-2.0
// Other projects' samplers, for comparison.
#include <cmath>
#include <fstream>
#include <iterator>

#include "files.h"
#include "sampler.h"

#if __has_include(<boost/random/sobol.hpp>)
#define BN_WITH_BOOST
#include <boost/random/sobol.hpp>
#endif

#ifdef BN_WITH_OPENQMC
#include <oqmc/latticebn.h>
#include <oqmc/pmjbn.h>
#include <oqmc/sobolbn.h>
#endif

namespace {

// The finaliser of SplitMix64 (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
// Generators", 2014).
uint64_t mix64(uint64_t v) {
    v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9u;
    v = (v ^ (v >> 27)) * 0x94d049bb133111ebu;
    return v ^ (v >> 31);
}

#ifdef BN_WITH_BOOST

// The "sobol-global" sampler: one Sobol' sequence over the whole screen, as in pbrt (Gruenschloss, Raab and
// Keller, "Enumerating Quasi-Monte Carlo Point Sequences in Elementary Intervals", 2012). Its first two
// dimensions give the position on a screen of 4096 x 4096 pixels, which repeats. Every 2^24 points hit each
// pixel exactly once; sample i of a pixel is its point in round i. The other numbers are further dimensions of that
// point: time, lens, first light, then six for each ray. Boost.Random supplies Joe and Kuo's direction
// numbers. Each dimension uses its own Owen scrambling; for the position, the scrambling also differs in each pixel.
// Loops, and rays past the last dimension, use random numbers.

constexpr unsigned SCREEN = 12, BITS = 64; // log2 of the screen's width; digits
constexpr uint32_t DIMENSIONS = 512, PIXELS = (1u << SCREEN) - 1;

class SobolGlobal final : public PeerSampler {
  public:
    explicit SobolGlobal(uint64_t own_seed) : PeerSampler(own_seed), columns_(DIMENSIONS * BITS) {
        boost::random::sobol_engine<uint64_t, BITS> engine(DIMENSIONS);
        for (unsigned bit = 0; bit < BITS; ++bit) {
            // Boost counts in Gray code, so its number 2^k is the sum of columns k and k - 1.
            engine.seed((uint64_t{1} << bit) - 1);
            for (uint32_t d = 0; d < DIMENSIONS; ++d) {
                uint64_t *column = &columns_[d * BITS + bit];
                *column = engine() ^ (bit > 0 ? column[-1] : 0);
            }
        }
        // Gauss-Jordan elimination finds the bits below 2 SCREEN that move a point by one digit.
        uint32_t moves[2 * SCREEN];
        for (unsigned bit = 0; bit < 2 * SCREEN; ++bit) {
            moves[bit] = pixel_of(uint64_t{1} << bit);
            inverse_[bit] = 1u << bit;
        }
        for (unsigned digit = 0; digit < 2 * SCREEN; ++digit) {
            unsigned pivot = digit;
            while (!(moves[pivot] >> digit & 1u)) ++pivot; // positions form a net, so one exists
            std::swap(moves[pivot], moves[digit]);
            std::swap(inverse_[pivot], inverse_[digit]);
            for (unsigned other = 0; other < 2 * SCREEN; ++other) {
                if (other == digit || !(moves[other] >> digit & 1u)) continue;
                moves[other] ^= moves[digit];
                inverse_[other] ^= inverse_[digit];
            }
        }
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        uint64_t point = uint64_t{index} << 2 * SCREEN;
        const uint32_t pixel = (uint32_t(x) & PIXELS) | (uint32_t(y) & PIXELS) << SCREEN;
        const uint32_t missing = pixel ^ shift() ^ pixel_of(point);
        for (unsigned digit = 0; digit < 2 * SCREEN; ++digit)
            if (missing >> digit & 1u) point ^= inverse_[digit];
        for (int half = 0; half < dimensions / 2; ++half) {
            const uint32_t first = dimension_of(key + uint32_t(half));
            if (first + 1 >= DIMENSIONS) {
                bn_sample_2d(generator.get(), x, y, index, key + uint32_t(half), 0, u);
                u += 2;
                continue;
            }
            for (uint32_t d = first; d < first + 2; ++d) {
                uint64_t digits = digits_of(point, d), scrambling = mix64(seed + 1) + d;
                if (d < 2) { // the position: use the digits below those of the pixel
                    digits <<= SCREEN;
                    scrambling += uint64_t{d == 0 ? pixel & PIXELS : pixel >> SCREEN} << 32;
                }
                *u++ = bn_draw_float(bn_owen(uint32_t(digits >> 32),
                                             uint32_t(mix64(scrambling + 0x9e3779b97f4a7c15u))));
            }
        }
    }

  private:
    // The dimension of the two numbers with this key, in the layout of PeerPath.
    static uint32_t dimension_of(uint32_t key) {
        if (key >= 1u << 14) return DIMENSIONS; // loops
        const uint32_t group = key / 4, two = key % 4;
        if (group == 0) return two == 0 ? 0 : 4;                        // position; lens or light
        if (group == PeerPath::CAMERA_KEY / 4) return two == 0 ? 6 : 2; // first light; time
        const uint32_t ray = group < PeerPath::CAMERA_KEY / 4 ? group : group - 1;
        return 8 + 6 * (ray - 1) + 2 * two;
    }

    uint64_t digits_of(uint64_t point, uint32_t dimension) const {
        uint64_t digits = 0;
        for (const uint64_t *column = &columns_[dimension * BITS]; point != 0;
             point >>= 1, ++column)
            if (point & 1u) digits ^= *column;
        return digits;
    }

    // The pixel of a point: the column, with the row in the next higher SCREEN bits.
    uint32_t pixel_of(uint64_t point) const {
        return uint32_t(digits_of(point, 0) >> (BITS - SCREEN)) |
               uint32_t(digits_of(point, 1) >> (BITS - SCREEN)) << SCREEN;
    }

    // Each seed moves a different pixel to (0, 0).
    uint32_t shift() const {
        return uint32_t(mix64(seed + 0x9e3779b97f4a7c15u)) >> (32 - 2 * SCREEN);
    }

    std::vector<uint64_t> columns_; // BITS columns for each dimension
    uint32_t inverse_[2 * SCREEN];
};

#endif
#ifdef BN_WITH_OPENQMC

// OpenQMC's blue-noise samplers (Framestore, https://github.com/AcademySoftwareFoundation/openqmc), used as
// its README recommends: the root is a sampler for one pixel and index, each of a path's decisions is a child
// of this root, and split light samples come from newDomainSplit(). OpenQMC takes no seed, so the frame number is
// a hash of the seed, which shifts the tables by the same amount in all pixels.

template <typename Native>
class OpenQmcSampler final : public PeerSampler {
  public:
    explicit OpenQmcSampler(uint64_t own_seed)
        : PeerSampler(own_seed), frame_(int(mix64(own_seed + 0x9e3779b97f4a7c15u) >> 34)),
          cache_(Native::cacheSize) {
        Native::initialiseCache(cache_.data());
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        const Native pixel = root(x, y, index);
        pixel.newDomain(int(key)).template drawSample<2>(u);
        if (dimensions == 4) pixel.newDomain(int(key + 1)).template drawSample<2>(u + 2);
    }

    void draw_split(int32_t x, int32_t y, uint32_t index, uint32_t key, uint32_t count, uint32_t k,
                    float *u) const override {
        root(x, y, index).newDomainSplit(int(key), int(count), int(k)).template drawSample<2>(u);
    }

  private:
    Native root(int32_t x, int32_t y, uint32_t index) const {
        return Native(x, y, frame_, int(index), cache_.data());
    }

    int frame_; // has 30 bits, because OpenQMC adds the high half of the index to it
    std::vector<char> cache_;
};

#endif

// A whole number of pixels by which a key's numbers are shifted, different for each seed, key and part.
uint32_t shift_of(uint64_t seed, uint32_t key, uint32_t part) {
    return uint32_t(mix64(mix64(seed + 0x9e3779b97f4a7c15u) + (uint64_t{key} << 32 | part))) >> 20;
}

// Interleaved gradient noise (Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare",
// 2014): one regular pattern, shifted by 5.588238 pixels for each index and by other amounts for each number.
class GradientNoise final : public PeerSampler {
  public:
    using PeerSampler::PeerSampler;

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        const double frame = 5.588238 * double(index % 64);
        for (int d = 0; d < dimensions; ++d) {
            const uint32_t number = 2 * uint32_t(d);
            const double at = 0.06711056 * (x + double(shift_of(seed, key, number)) + frame) +
                              0.00583715 * (y + double(shift_of(seed, key, number + 1)) + frame);
            const double wide = 52.9829189 * (at - std::floor(at));
            u[d] = bn_draw_float(uint32_t((wide - std::floor(wide)) * 0x1p32));
        }
    }
};

std::vector<char> bytes_of(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// Throws Error unless a file that scripts/bench writes has the right size.
void check_size(const std::string &path, bool right) {
    if (!right) throw Error(path, " is not a file that scripts/bench wrote for this sampler");
}

// Pairs of numbers from slices that are tiled over the screen, one slice for each index. The file holds depth,
// height and width as 32-bit integers, and then [depth][height][width][2] floats. Each pair of a path reads the
// slices at its own offset.
class Slices final : public PeerSampler {
  public:
    Slices(uint64_t own_seed, const std::string &path) : PeerSampler(own_seed) {
        const std::vector<char> bytes = bytes_of(path);
        check_size(path, bytes.size() > sizeof size_);
        std::copy_n(bytes.data(), sizeof size_, reinterpret_cast<char *>(size_));
        numbers_.resize((bytes.size() - sizeof size_) / sizeof(float));
        check_size(path, numbers_.size() == size_t{2} * size_[0] * size_[1] * size_[2]);
        std::copy_n(bytes.data() + sizeof size_, numbers_.size() * sizeof(float),
                    reinterpret_cast<char *>(numbers_.data()));
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        const auto [depth, height, width] = size_;
        for (int half = 0; half < dimensions / 2; ++half) {
            const uint32_t own = key + uint32_t(half);
            const uint32_t row = wrapped(y, shift_of(seed, own, 1), height);
            const uint32_t column = wrapped(x, shift_of(seed, own, 0), width);
            const float *pair =
                &numbers_[2 * ((size_t{index % depth} * height + row) * width + column)];
            u = std::copy_n(pair, 2, u);
        }
    }

  private:
    static uint32_t wrapped(int32_t at, uint32_t shift, uint32_t size) {
        const int64_t place = (int64_t{at} + shift) % int64_t{size};
        return uint32_t(place < 0 ? place + size : place);
    }

    uint32_t size_[3]; // depth, height, width
    std::vector<float> numbers_;
};

// The sampler of Heitz, Belcour, Ostromoukhov, Coeurjolly and Iehl ("A Low-Discrepancy Sampler that Distributes
// Monte Carlo Errors as a Blue Noise in Screen Space", 2019). The file holds one byte for each entry of the
// authors' tables for one sample count: 256 points with 256 dimensions, and a scrambling and a ranking tile of
// 128 x 128 pixels with eight dimensions each. A path's first eight dimensions are those that the authors
// optimised: pixel position, light, and direction and light of ray 1. Seeds shift the tile.
class Heitz final : public PeerSampler {
  public:
    Heitz(uint64_t own_seed, const std::string &path)
        : PeerSampler(own_seed), tables_(bytes_of(path)) {
        check_size(path, tables_.size() == RANKS + TILE);
    }

    void draw(int32_t x, int32_t y, uint32_t index, uint32_t key, int dimensions,
              float *u) const override {
        const uint32_t column = (uint32_t(x) + shift_of(seed, 0, 0)) % SIDE;
        const uint32_t row = (uint32_t(y) + shift_of(seed, 0, 1)) % SIDE;
        for (int half = 0; half < dimensions / 2; ++half, u += 2) {
            const uint32_t first = dimension_of(key + uint32_t(half));
            if (first >= POINTS || index >= POINTS) {
                bn_sample_2d(generator.get(), x, y, index, key + uint32_t(half), 0, u);
                continue;
            }
            for (uint32_t d = first; d < first + 2; ++d) {
                const size_t own = 8 * (row * SIDE + column) + d % 8;
                const uint32_t point = index ^ entry(RANKS + own);
                u[d - first] =
                    float(entry(POINTS * point + d) ^ entry(SCRAMBLING + own)) / 256 + 0.5f / 256;
            }
        }
    }

  private:
    static constexpr uint32_t SIDE = 128, POINTS = 256;
    static constexpr size_t TILE = size_t{8} * SIDE * SIDE, SCRAMBLING = size_t{POINTS} * POINTS,
                            RANKS = SCRAMBLING + TILE;

    // The dimension of the two numbers with this key, in the layout of PeerPath; POINTS if there is none.
    static uint32_t dimension_of(uint32_t key) {
        if (key >= 1u << 14) return POINTS; // loops
        const uint32_t group = key / 4, two = key % 4;
        if (group == 0) return two == 0 ? 0 : 2;                         // position; lens or light
        if (group == PeerPath::CAMERA_KEY / 4) return two == 0 ? 8 : 10; // first light; time
        const uint32_t ray = group < PeerPath::CAMERA_KEY / 4 ? group : group - 1;
        if (ray == 1 && two < 2) return 4 + 2 * two;
        return 12 + 6 * (ray - 1) + 2 * two;
    }

    uint32_t entry(size_t at) const { return static_cast<unsigned char>(tables_[at]); }

    std::vector<char> tables_;
};

} // namespace

PeerPointer peer_from_file(const std::string &name, const std::string &path, uint64_t seed) {
    if (name == "slices") return std::make_unique<Slices>(seed, path);
    if (name == "heitz") return std::make_unique<Heitz>(seed, path);
    throw Error("only the samplers 'slices' and 'heitz' read a file, not '", name, "'");
}

std::vector<SamplerEntry> peer_entries() {
    return {
        {"gradient-noise", "interleaved gradient noise, for comparison", 0,
         create_peer<GradientNoise>},
#ifdef BN_WITH_BOOST
        {"sobol-global", "one Sobol' sequence over the screen, for comparison", BN_SAMPLER_WHITE,
         create_peer<SobolGlobal>},
#endif
#ifdef BN_WITH_OPENQMC
        {"openqmc-pmjbn", "OpenQMC: multi-jittered, blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::PmjBnSampler>>},
        {"openqmc-sobolbn", "OpenQMC: Sobol', blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::SobolBnSampler>>},
        {"openqmc-latticebn", "OpenQMC: rank-1 lattice, blue noise", 0,
         create_peer<OpenQmcSampler<oqmc::LatticeBnSampler>>},
#endif
    };
}
