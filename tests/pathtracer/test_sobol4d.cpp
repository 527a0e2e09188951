// SPDX-License-Identifier: Apache-2.0
// The sampler sobol4d: Joe and Kuo's directions, nets in four dimensions, and independent
// between pixels, domains and seeds. And sobol-global, whose nets lie over the screen.
//
// Seeds are fixed; the rates stated are the chances of a false alarm had they been drawn anew.
#include "sobol4d.h"

#include <numeric>
#include <string>

#include "scenes.h"

namespace {

using Point = std::array<float, 4>;

// Of ray `ray`.
Point point(const Sampler &sampler, int x, int y, uint32_t index, uint32_t ray) {
    return with_path(sampler, x, y, index,
                     [ray](const auto &path) { return path.ray(ray).draw(); });
}

// ---- Directions

// The polynomials x + 1, x^2 + x + 1 and x^3 + x + 1 after the initial numbers 1; 1, 3; 1, 3, 1.
void test_directions_follow_their_recurrences() {
    const auto &v = sobol4d_directions;
    CHECK(v[0][1] == v[0][0] && v[0][2] == v[0][0] && v[0][3] == v[0][0] &&
              v[1][2] == 0xc0000000u && v[1][3] == 0xc0000000u && v[2][3] == 0x20000000u,
          "the initial numbers");
    for (size_t k = 0; k < 32; ++k) {
        CHECK(v[k][0] == 0x80000000u >> k, "bit %zu of the first", k);
        CHECK(k < 1 || v[k][1] == (v[k - 1][1] ^ v[k - 1][1] >> 1), "bit %zu of the second", k);
        CHECK(k < 2 || v[k][2] == (v[k - 1][2] ^ v[k - 2][2] ^ v[k - 2][2] >> 2),
              "bit %zu of the third", k);
        CHECK(k < 3 || v[k][3] == (v[k - 2][3] ^ v[k - 3][3] ^ v[k - 3][3] >> 3),
              "bit %zu of the fourth", k);
    }
}

// ---- Nets

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

// Of blocks of indices from 0 on, in the middle, and near the end.
bool are_nets(const Sampler &sampler, int m, int t, const std::vector<size_t> &chosen) {
    const uint32_t last = static_cast<uint32_t>(PeerSampler::INDEX_LIMIT >> m) - 1;
    for (int trial = 0; trial < 12; ++trial) {
        const uint32_t block = trial % 3 == 0 ? 0 : trial % 3 == 1 ? 5 : last;
        std::vector<Point> points;
        for (uint32_t i = 0; i < 1u << m; ++i)
            points.push_back(point(sampler, 3 * trial, 7, (block << m) + i, 1));
        if (!is_net(points, m, t, chosen)) return false;
    }
    return true;
}

void test_blocks_are_nets() {
    const SamplerPointer sobol4d = sampler_named("sobol4d", 1), padded = sampler_named("sobol", 1);
    for (int m = 1; m <= 10; ++m) {
        CHECK(are_nets(*sobol4d, m, 3, {0, 1, 2, 3}), "2^%d points", m);
        CHECK(are_nets(*sobol4d, m, 0, {0, 1}), "2^%d points, first pair", m);
        for (size_t d = 0; d < 4; ++d)
            CHECK(are_nets(*sobol4d, m, 0, {d}), "2^%d points, dimension %zu", m, d);
    }
    // The test sees the difference: padded points are no such net.
    CHECK(!are_nets(*padded, 8, 3, {0, 1, 2, 3}), "padded points pass as a net");
}

// Position on the screen and time of all samples of an aligned block of 8 x 8 pixels are a net too.
void test_the_screen_is_a_net() {
    bool built = false; // with Boost
    for (const SamplerEntry &entry : sampler_entries())
        built = built || std::string("sobol-global") == entry.name;
    for (uint64_t seed = 0; built && seed < 3; ++seed) {
        const SamplerPointer sampler = sampler_named("sobol-global", seed);
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
        for (uint32_t i = 0; i < 256; ++i) own.push_back(point(*sampler, 7, 9, i, 0));
        CHECK(is_net(own, 8, 0, {0, 1}), "a pixel's own positions");
    }
}

// ---- Independent

// The first samples of what should have nothing in common: 18 chi-squares over 64 cells.
void test_independent() {
    constexpr int EXTENT = 256, CELLS = 64;
    const SamplerPointer sampler = sampler_named("sobol4d", 3), other = sampler_named("sobol4d", 4);
    const struct {
        const char *what;
        int dx, dy;
        const Sampler *from;
    } changes[] = {{"the pixel beside", 1, 0, sampler.get()},
                   {"the pixel below", 0, 1, sampler.get()},
                   {"another seed", 0, 0, other.get()}};
    const auto eighth = [](float u) { return static_cast<size_t>(8 * u); };
    for (const auto &[what, dx, dy, from] : changes)
        for (size_t d = 0; d < 4; ++d)
            for (size_t e = d; e < 4; e += 2) {
                std::vector<double> counts(CELLS);
                for (int y = 0; y < EXTENT; ++y)
                    for (int x = 0; x < EXTENT; ++x)
                        ++counts[8 * eighth(point(*sampler, x, y, 0, 0)[d]) +
                                 eighth(point(*from, x + dx, y + dy, 0, 0)[e])];
                const double expected = double{EXTENT} * EXTENT / CELLS;
                const double off = unevenness(counts, std::vector<double>(CELLS, expected));
                CHECK(off < 4.5, "%s, dimensions %zu and %zu: %g", what, d, e, off);
            }
}

// Parts of split samples are one sequence.
void test_split_samples() {
    const SamplerPointer sampler = sampler_named("sobol4d", 5);
    for (uint32_t i = 0; i < 192; ++i)
        CHECK(PeerPath(*sampler->peer, -5, 9, i / 3).first_light(3, i % 3) ==
                  PeerPath(*sampler->peer, -5, 9, i).first_light(1, 0),
              "part %u", i);
}

} // namespace

int main() {
    test_directions_follow_their_recurrences();
    test_blocks_are_nets();
    test_the_screen_is_a_net();
    test_independent();
    test_split_samples();
    return 0;
}
