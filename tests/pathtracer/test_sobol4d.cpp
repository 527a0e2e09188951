// SPDX-License-Identifier: Apache-2.0
// The sampler sobol4d: Joe and Kuo's directions, nets in four dimensions, uniform, and independent
// between pixels, domains and seeds. And sobol-global, whose nets lie over the screen.
//
// Seeds are fixed; the rates stated are the chances of a false alarm had they been drawn anew.
#include "sobol4d.h"

#include <algorithm>
#include <array>
#include <vector>

#include "check.h"
#include "scenes.h"

namespace {

using Point = std::array<float, 4>;

// Of ray `ray`.
Point point(const Sampler &sampler, int x, int y, uint32_t index, uint32_t ray) {
    return with_path(sampler, x, y, index,
                     [ray](const auto &path) { return path.ray(ray).draw(); });
}

// ---- Directions

// Direction numbers by their recurrence: a polynomial of degree s with the inner coefficients `a`.
std::vector<uint32_t> directions(uint32_t s, uint32_t a, std::vector<uint32_t> m) {
    while (m.size() < 32) {
        const size_t k = m.size();
        uint32_t next = m[k - s] ^ (m[k - s] << s);
        for (uint32_t i = 1; i < s; ++i)
            if ((a >> (s - 1 - i)) & 1u) next ^= m[k - i] << i;
        m.push_back(next);
    }
    for (size_t k = 0; k < 32; ++k) m[k] <<= 31 - k;
    return m;
}

void test_directions_follow_their_recurrences() {
    const std::vector<uint32_t> expected[3] = {directions(1, 0, {1}), directions(2, 1, {1, 3}),
                                               directions(3, 1, {1, 3, 1})};
    for (size_t k = 0; k < 32; ++k) {
        CHECK(sobol4d_directions[k][0] == 0x80000000u >> k, "bit %zu of the first", k);
        for (size_t d = 1; d < 4; ++d)
            CHECK(sobol4d_directions[k][d] == expected[d - 1][k], "bit %zu of dimension %zu", k, d);
    }
}

// ---- Nets

// The smallest t for which 2^m points are a (t, m, s)-net in base 2 in the dimensions of `chosen`.
int quality(const std::vector<Point> &points, int m, const std::vector<int> &chosen) {
    const auto is_net = [&](int t) {
        std::array<int, 4> bits{};
        const auto even = [&] {
            std::vector<int> counts(size_t{1} << (m - t));
            for (const Point &p : points) {
                size_t cell = 0;
                for (const int d : chosen) {
                    const auto i = static_cast<size_t>(d);
                    const float scaled = p[i] * static_cast<float>(1 << bits[i]);
                    cell = (cell << bits[i]) | static_cast<size_t>(scaled);
                }
                ++counts[cell];
            }
            return std::all_of(counts.begin(), counts.end(), [&](int n) { return n == 1 << t; });
        };
        // All ways to share m - t digits between the dimensions.
        const auto all_even = [&](auto &&self, size_t at, int left) -> bool {
            const auto i = static_cast<size_t>(chosen[at]);
            if (at + 1 == chosen.size()) {
                bits[i] = left;
                return even();
            }
            for (bits[i] = 0; bits[i] <= left; ++bits[i])
                if (!self(self, at + 1, left - bits[i])) return false;
            return true;
        };
        return all_even(all_even, 0, m - t);
    };
    int t = 0;
    while (!is_net(t)) ++t;
    return t;
}

int worst_quality(const Sampler &sampler, int m, const std::vector<int> &chosen) {
    int worst = 0;
    for (int trial = 0; trial < 12; ++trial) {
        // Blocks of indices from 0 on, in the middle, and near the end.
        const uint32_t last = static_cast<uint32_t>(PeerSampler::INDEX_LIMIT >> m) - 1;
        const uint32_t block = trial % 3 == 0 ? 0 : trial % 3 == 1 ? 5 : last;
        std::vector<Point> points;
        for (uint32_t i = 0; i < 1u << m; ++i)
            points.push_back(point(sampler, 3 * trial, 7, (block << m) + i, 1));
        worst = std::max(worst, quality(points, m, chosen));
    }
    return worst;
}

void test_blocks_are_nets() {
    const SamplerPointer sobol4d = sampler_named("sobol4d", 1), padded = sampler_named("sobol", 1);
    for (int m = 1; m <= 10; ++m) {
        const int t = worst_quality(*sobol4d, m, {0, 1, 2, 3});
        CHECK(t <= 3, "2^%d points are a (%d,%d,4)-net", m, t, m);
        CHECK(worst_quality(*sobol4d, m, {0, 1}) == 0, "2^%d points, first pair", m);
        for (int d = 0; d < 4; ++d)
            CHECK(worst_quality(*sobol4d, m, {d}) == 0, "2^%d points, dimension %d", m, d);
    }
    // The test sees the difference: padded points are no such net.
    CHECK(worst_quality(*padded, 8, {0, 1, 2, 3}) > 3, "padded points pass as a net");
    CHECK(worst_quality(*padded, 8, {0, 1}) == 0, "padded points are no net in a pair");
}

// Position on the screen and time of all samples of an aligned block of 8 x 8 pixels, as one set.
std::vector<Point> on_screen(const Sampler &sampler, int x0, int y0, uint32_t first,
                             uint32_t count) {
    std::vector<Point> points;
    for (int pixel = 0; pixel < 64; ++pixel) {
        for (uint32_t i = first; i < first + count; ++i) {
            const int x = pixel % 8, y = pixel / 8;
            points.push_back(with_path(sampler, x0 + x, y0 + y, i, [&](const auto &path) {
                const auto place = path.ray(0).draw();
                const auto time = path.time();
                return Point{(static_cast<float>(x) + place[0]) / 8,
                             (static_cast<float>(y) + place[1]) / 8, time[0], time[1]};
            }));
        }
    }
    return points;
}

void test_the_screen_is_a_net() {
    const auto &entries = sampler_entries();
    if (std::none_of(entries.begin(), entries.end(),
                     [](const SamplerEntry &e) { return std::string("sobol-global") == e.name; }))
        return; // built without Boost
    for (uint64_t seed = 0; seed < 3; ++seed) {
        const SamplerPointer sampler = sampler_named("sobol-global", seed);
        for (const auto &[x, y] : {std::pair{0, 0}, {-8, 640}, {5000, -16}}) {
            const std::vector<Point> points = on_screen(*sampler, x, y, 4, 4);
            CHECK(quality(points, 8, {0, 1}) == 0, "positions at %d,%d", x, y);
            CHECK(quality(points, 8, {0, 1, 2}) <= 1, "positions and time at %d,%d", x, y);
            CHECK(quality(points, 8, {0, 1, 2, 3}) <= 3, "all four at %d,%d", x, y);
        }
        std::vector<Point> own;
        for (uint32_t i = 0; i < 256; ++i) own.push_back(point(*sampler, 7, 9, i, 0));
        CHECK(quality(own, 8, {0, 1}) == 0, "a pixel's own positions");
    }
    const SamplerPointer padded = sampler_named("sobol", 1);
    CHECK(quality(on_screen(*padded, 0, 0, 4, 4), 8, {0, 1, 2}) > 1, "padded points pass");
}

// ---- Uniform and independent

constexpr int EXTENT = 256, PIXELS = EXTENT * EXTENT;

// Chi-square over cells that should be equally full, in standard deviations. A single one above 4.5
// has a chance of three in a million; there are fewer than a hundred.
template <typename CellOf>
double unevenness(int cells, const CellOf &cell_of) {
    std::vector<double> counts(static_cast<size_t>(cells));
    for (int y = 0; y < EXTENT; ++y)
        for (int x = 0; x < EXTENT; ++x) ++counts[static_cast<size_t>(cell_of(x, y))];
    const double expected = static_cast<double>(PIXELS) / cells;
    double chi_square = 0;
    for (const double n : counts) chi_square += (n - expected) * (n - expected) / expected;
    return chi_square_deviations(chi_square, cells - 1);
}

// Digit `from` to `from + bits - 1` after the point.
int digits(float u, int from, int bits) {
    return (static_cast<int>(u * (1 << 24)) >> (24 - from - bits)) & ((1 << bits) - 1);
}

void test_uniform_over_pixels() {
    const SamplerPointer sampler = sampler_named("sobol4d", 12);
    for (const uint32_t index : {0u, 1u, 2u, 7u, 1000003u}) {
        const auto at = [&](int x, int y) { return point(*sampler, x - 100, y - 100, index, 2); };
        for (const int from : {0, 8, 16})
            for (size_t d = 0; d < 4; ++d) {
                const double off =
                    unevenness(256, [&](int x, int y) { return digits(at(x, y)[d], from, 8); });
                CHECK(off < 4.5, "index %u, digits from %d of dimension %zu: %g", index, from, d,
                      off);
            }
        const double off = unevenness(4096, [&](int x, int y) {
            const Point p = at(x, y);
            int cell = 0;
            for (const float u : p) cell = 8 * cell + digits(u, 0, 3);
            return cell;
        });
        CHECK(off < 4.5, "index %u, all four: %g", index, off);
    }
}

// The first samples, and the errors of eight samples, of what should have nothing in common: 36
// chi-squares over 64 cells, and as many correlations, beyond 5 / 256 once in two million.
void test_independent() {
    const SamplerPointer sampler = sampler_named("sobol4d", 3), other = sampler_named("sobol4d", 4);
    const auto error = [&](const Sampler &s, int x, int y, uint32_t key, size_t d) {
        double sum = 0;
        for (uint32_t i = 0; i < 8; ++i)
            sum += static_cast<double>(point(s, x, y, i, key)[d]) - 0.5;
        return sum;
    };
    struct Change {
        const char *what;
        int dx, dy;
        uint32_t key;
        const Sampler *from;
    };
    const Change changes[] = {
        {"the pixel beside", 1, 0, 0, sampler.get()},   {"the pixel below", 0, 1, 0, sampler.get()},
        {"a pixel far off", 64, 128, 0, sampler.get()}, {"the next domain", 0, 0, 1, sampler.get()},
        {"another domain", 0, 0, 256, sampler.get()},   {"another seed", 0, 0, 0, other.get()},
    };
    for (const Change &c : changes)
        for (size_t d = 0; d < 4; ++d)
            for (size_t e = d; e < 4; e += 2) {
                const double off = unevenness(64, [&](int x, int y) {
                    const Point p = point(*sampler, x, y, 0, 0);
                    const Point q = point(*c.from, x + c.dx, y + c.dy, 0, c.key);
                    return 8 * digits(p[d], 0, 3) + digits(q[e], 0, 3);
                });
                CHECK(off < 4.5, "%s, dimensions %zu and %zu: %g", c.what, d, e, off);
                double products = 0, squares = 0, others = 0;
                for (int y = 0; y < EXTENT; ++y)
                    for (int x = 0; x < EXTENT; ++x) {
                        const double a = error(*sampler, x, y, 0, d);
                        const double b = error(*c.from, x + c.dx, y + c.dy, c.key, e);
                        products += a * b;
                        squares += a * a;
                        others += b * b;
                    }
                const double r = products / std::sqrt(squares * others);
                CHECK(std::abs(r) < 5.0 / EXTENT, "%s, errors in %zu and %zu: r = %g", c.what, d, e,
                      r);
            }
}

// Where two samples differ in the first digit of a dimension, scrambling makes the following ones
// unrelated, in each dimension by itself: six chi-squares over 64 cells.
void test_dimensions_are_scrambled_apart() {
    const SamplerPointer sampler = sampler_named("sobol4d", 6);
    const auto following = [&](int x, int y, size_t d) {
        const auto digits_of = [&](uint32_t index) {
            return digits(point(*sampler, x, y, index, 0)[d], 1, 3);
        };
        return digits_of(0) ^ digits_of(1);
    };
    for (size_t d = 0; d < 4; ++d)
        for (size_t e = d + 1; e < 4; ++e) {
            const double off = unevenness(
                64, [&](int x, int y) { return 8 * following(x, y, d) + following(x, y, e); });
            CHECK(off < 4.5, "dimensions %zu and %zu: %g", d, e, off);
        }
}

void test_draws_of_two_dimensions_are_the_first_half() {
    const SamplerPointer sampler = sampler_named("sobol4d", 5);
    for (uint32_t i = 0; i < 64; ++i) {
        const PeerPath path(*sampler->peer, -5, 9, i);
        const std::array<float, 2> two = path.ray(7).draw_where();
        const Point four = path.ray(7).draw();
        CHECK(two[0] == four[0] && two[1] == four[1], "sample %u", i);
        for (uint32_t k = 0; k < 3; ++k) {
            const PeerPath whole(*sampler->peer, -5, 9, 3 * i + k);
            CHECK(path.first_light(3, k) == whole.first_light(1, 0), "part %u of %u", k, i);
        }
    }
}

} // namespace

int main() {
    test_directions_follow_their_recurrences();
    test_blocks_are_nets();
    test_the_screen_is_a_net();
    test_uniform_over_pixels();
    test_independent();
    test_dimensions_are_scrambled_apart();
    test_draws_of_two_dimensions_are_the_first_half();
    return 0;
}
