// SPDX-License-Identifier: Apache-2.0
// Pairs of numbers from slices that are tiled over the screen, one slice for each index. The argument is a file with depth,
// height and width as 32-bit integers, then [depth][height][width][2] floats. Each pair of a path reads the
// slices at its own offset.
#include <algorithm>
#include <iterator>

#include "plugin_class.hpp"

namespace {

class Slices {
  public:
    Slices(uint64_t, uint32_t, const std::string &path) {
        std::ifstream file(path, std::ios::binary);
        const std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
        if (bytes.size() <= sizeof size_) throw std::invalid_argument(path);
        std::copy_n(bytes.data(), sizeof size_, reinterpret_cast<char *>(size_));
        numbers_.resize((bytes.size() - sizeof size_) / sizeof(float));
        if (numbers_.size() != size_t{2} * size_[0] * size_[1] * size_[2])
            throw std::invalid_argument(path);
        std::copy_n(bytes.data() + sizeof size_, numbers_.size() * sizeof(float),
                    reinterpret_cast<char *>(numbers_.data()));
    }

    void draw(const Draw &d, float *u) const {
        const auto [depth, height, width] = size_;
        for (uint32_t half = 0; half < d.dimensions / 2; ++half) {
            const uint32_t own = d.decision + half;
            const uint32_t row = wrapped(d.y, shift_of(d.seed, own, 1), height);
            const uint32_t column = wrapped(d.x, shift_of(d.seed, own, 0), width);
            const float *pair =
                &numbers_[2 * ((size_t{d.index % depth} * height + row) * width + column)];
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

} // namespace

SAMPLER_PLUGIN(Slices, 0)
