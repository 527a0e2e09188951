// SPDX-License-Identifier: Apache-2.0
// The samplers for comparison: sobol-global's nets, and split samples.
#include <numeric>
#include <string>

#include "../../tests/pathtracer/scenes.h"

namespace {

using Point = std::array<float, 4>;

// Whether 2^m points are a (t, m, s)-net in base 2 in the first s dimensions of `chosen`: evenly
// spread over boxes for all ways to share m - t digits between the dimensions.
bool is_net(const std::vector<Point> &points, int m, int t, const std::vector<size_t> &chosen) {
    const int digits = std::max(m - t, 0);
    int ways = 1;
    for (size_t d = 0; d < chosen.size(); ++d) ways *= digits + 1;
    for (int way = 0; way < ways; ++way) {
        std::vector<int> bits;
        for (int rest = way; bits.size() < chosen.size(); rest /= digits + 1)
            bits.push_back(rest % (digits + 1));
        if (std::accumulate(bits.begin(), bits.end(), 0) != digits) continue;
        std::vector<size_t> counts(size_t{1} << digits);
        for (const Point &p : points) {
            size_t cell = 0;
            for (size_t d = 0; d < chosen.size(); ++d)
                cell = (cell << bits[d]) |
                       static_cast<size_t>(p[chosen[d]] * static_cast<float>(1 << bits[d]));
            ++counts[cell];
        }
        for (const size_t n : counts)
            if (n != points.size() >> digits) return false;
    }
    return true;
}

// In an aligned block of 8 x 8 pixels, the screen positions and times of all samples also form a net.
void test_the_screen_is_a_net() {
    bool built = false; // with Boost
    for (const SamplerEntry &entry : sampler_entries())
        built = built || std::string("sobol-global") == entry.name;
    for (uint64_t seed = 0; built && seed < 3; ++seed) {
        const SamplerPointer sampler = sampler_create("sobol-global", seed);
        for (const auto &[x0, y0] : {std::pair{0, 0}, {-8, 640}, {5000, -16}}) {
            std::vector<Point> points;
            for (int i = 0; i < 256; ++i) {
                const int x = i % 8, y = i / 8 % 8;
                const auto index = static_cast<uint32_t>(4 + i / 64);
                points.push_back(with_path(*sampler, x0 + x, y0 + y, index, [&](const auto &path) {
                    const auto [u, v] = path.ray(0).draw_direction();
                    const auto [time, other] = path.time_wavelength();
                    return Point{(static_cast<float>(x) + u) / 8, (static_cast<float>(y) + v) / 8,
                                 time, other};
                }));
            }
            CHECK(is_net(points, 8, 0, {0, 1}), "positions at %d,%d", x0, y0);
            CHECK(is_net(points, 8, 1, {0, 1, 2}), "positions and time at %d,%d", x0, y0);
            CHECK(is_net(points, 8, 3, {0, 1, 2, 3}), "all four at %d,%d", x0, y0);
        }
        std::vector<Point> own;
        for (uint32_t i = 0; i < 256; ++i)
            own.push_back(
                with_path(*sampler, 7, 9, i, [](const auto &path) { return path.ray(0).draw(); }));
        CHECK(is_net(own, 8, 0, {0, 1}), "a pixel's own positions");
    }
}

// The parts of split samples form one sequence, unless the peer splits in its own way.
void test_split_samples() {
    for (const SamplerEntry &entry : sampler_entries()) {
        if (!entry.peer || std::string(entry.name).rfind("openqmc", 0) == 0) continue;
        const PeerPointer peer = entry.peer(5);
        for (uint32_t i = 0; i < 192; ++i) {
            const PeerPath split = {*peer, -5, 9, i / 3}, whole = {*peer, -5, 9, i};
            CHECK(split.first_light(3, i % 3) == whole.first_light(1, 0), "%s, part %u", entry.name,
                  i);
        }
    }
}

} // namespace

int main() {
    test_the_screen_is_a_net();
    test_split_samples();
    return 0;
}
