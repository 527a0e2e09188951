// SPDX-License-Identifier: Apache-2.0
// The plug-ins for comparison: global Sobol's nets, split samples, and samplers that read tables. The arguments are the
// folder of the plug-ins and, optionally, the authors' table for quad_optimized.so.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <set>
#include <string>

#include "../../tests/pathtracer/scenes.h"
#include "files.h"

namespace {

using Point = std::array<float, 4>;

std::string folder; // of the plug-ins

SamplerPointer create(const std::string &name, uint64_t seed, uint32_t samples = 0) {
    return sampler_create(folder + "/" + name, seed, samples);
}

// Whether base^m points are a (t, m, s)-net in the first s dimensions of `chosen`: evenly spread over boxes for all ways
// to share m - t digits between the dimensions.
bool is_net(const std::vector<Point> &points, int base, int m, int t,
            const std::vector<size_t> &chosen) {
    const int digits = std::max(m - t, 0);
    const auto power = [base](int exponent) {
        return size_t(std::lround(std::pow(base, exponent)));
    };
    int ways = 1;
    for (size_t d = 0; d < chosen.size(); ++d) ways *= digits + 1;
    for (int way = 0; way < ways; ++way) {
        std::vector<int> shares;
        for (int rest = way; shares.size() < chosen.size(); rest /= digits + 1)
            shares.push_back(rest % (digits + 1));
        if (std::accumulate(shares.begin(), shares.end(), 0) != digits) continue;
        std::vector<size_t> counts(power(digits));
        for (const Point &p : points) {
            size_t cell = 0;
            for (size_t d = 0; d < chosen.size(); ++d)
                cell = cell * power(shares[d]) + size_t(p[chosen[d]] * float(power(shares[d])));
            ++counts[cell];
        }
        for (const size_t n : counts)
            if (n != points.size() / counts.size()) return false;
    }
    return true;
}

// In an aligned block of 8 x 8 pixels, the screen positions and times of all samples also form a net.
void test_the_screen_is_a_net() {
    const bool built = std::filesystem::exists(folder + "/sobol_global.so"); // with Boost
    for (uint64_t seed = 0; built && seed < 3; ++seed) {
        const SamplerPointer sampler = create("sobol_global.so", seed);
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
            CHECK(is_net(points, 2, 8, 0, {0, 1}), "positions at %d,%d", x0, y0);
            CHECK(is_net(points, 2, 8, 1, {0, 1, 2}), "positions and time at %d,%d", x0, y0);
            CHECK(is_net(points, 2, 8, 3, {0, 1, 2, 3}), "all four at %d,%d", x0, y0);
        }
        std::vector<Point> own;
        for (uint32_t i = 0; i < 256; ++i)
            own.push_back(
                with_path(*sampler, 7, 9, i, [](const auto &path) { return path.ray(0).draw(); }));
        CHECK(is_net(own, 2, 8, 0, {0, 1}), "a pixel's own positions");
    }
}

// Whether `count` samples of a pixel fall into different ones of a x b cells, a * b = count.
bool fills_cells(const Sampler &sampler, uint32_t decision, uint32_t a, uint32_t b) {
    std::set<std::pair<uint32_t, uint32_t>> cells;
    for (uint32_t i = 0; i < a * b; ++i) {
        const auto [u, v] = PluginPath(*sampler.plugin, -300, 99, i, decision).draw_direction();
        cells.insert({static_cast<uint32_t>(u * float(a)), static_cast<uint32_t>(v * float(b))});
    }
    return cells.size() == size_t{a} * b;
}

// With any table, consecutive dimensions are nets, if the samples are as many as declared.
void test_cascaded_sobol() {
    const std::string path = "test_plugins_cascaded.txt";
    std::ofstream file(path);
    for (int d = 1; d <= 16; ++d) file << d << (d % 2 != 0 ? " 1 0 1\n" : " 2 1 1 3\n");
    file.close();
    for (const uint32_t samples : {4u, 16u, 64u}) {
        const SamplerPointer sampler = create("cascaded_sobol.so:" + path, 7, samples);
        for (const uint32_t decision : {0u, 4u})
            for (uint32_t a = 1; a <= samples; a *= 2)
                CHECK(fills_cells(*sampler, decision, a, samples / a),
                      "%u samples, decision %u, %u columns", samples, decision, a);
    }
    std::remove(path.c_str());
}

// Each block of 3^m points is a (0, m, 2)-net in both pairs and a (2, m, 4)-net in all four numbers. The authors' table is
// `table`; in ours, degrees 1 and 2 bound t in the quadruples by 1.
void test_quad_optimized(const std::string &table) {
    const std::string path = "test_plugins_quad.txt";
    std::ofstream file(path);
    for (int d = 0; d < 12; ++d) file << "1 1 3 1\n2 1 4 1\n3 1 5 1\n4 2 14 1 1\n";
    file.close();
    const bool ours = table.empty();
    const SamplerPointer sampler = create("quad_optimized.so:" + (ours ? path : table), 7);
    for (const uint32_t decision : {0u, 12u, 28u, 30u}) {
        uint32_t count = 1;
        for (int m = 1; m <= 6; ++m) {
            count *= 3;
            std::vector<Point> points;
            for (uint32_t i = 2 * count; i < 3 * count; ++i)
                points.push_back(PluginPath(*sampler->plugin, -300, 99, i, decision).draw());
            CHECK(is_net(points, 3, m, 0, {0, 1}), "%u points, decision %u", count, decision);
            if (decision % 4 != 0) continue;
            CHECK(is_net(points, 3, m, 0, {2, 3}), "%u points, decision %u", count, decision);
            CHECK(is_net(points, 3, m, ours ? 1 : 2, {0, 1, 2, 3}), "%u points, decision %u", count,
                  decision);
        }
    }
    // The scrambling is nested and differs between pixels: the order within a third says nothing about the next.
    int same = 0;
    for (int x = 0; x < 64; ++x) {
        const auto u = [&](uint32_t i) { return PluginPath(*sampler->plugin, x, 0, i).draw()[0]; };
        same += (u(0) < u(3)) == (u(1) < u(4));
    }
    CHECK(same > 16 && same < 48, "%d of 64 pixels keep the order", same);
    std::remove(path.c_str());
}

// Each dimension of the Halton sequence is stratified in the powers of its prime, alone and in pairs.
void test_halton() {
    for (uint64_t seed = 0; seed < 3; ++seed) {
        const SamplerPointer sampler = create("halton.so", seed);
        CHECK(fills_cells(*sampler, 0, 8, 9) && fills_cells(*sampler, 0, 16, 3), "the position");
        CHECK(fills_cells(*sampler, 4, 23, 29), "the direction of ray 1");
        const SamplerPointer other = create("halton.so", seed + 3);
        const PluginPath one(*sampler->plugin, 5, 7, 2), two(*other->plugin, 5, 7, 2);
        CHECK(one.draw() != two.draw(), "seeds agree");
    }
}

// Every power of two of a pixel's points is a shifted lattice: each dimension is equally spaced.
void test_lattice() {
    const SamplerPointer sampler = create("lattice.so", 4);
    for (const uint32_t count : {1u, 2u, 8u, 64u})
        for (uint32_t d = 0; d < 4; ++d) {
            std::set<uint32_t> cells;
            const float first = PluginPath(*sampler->plugin, 3, -8, 0).draw()[d];
            for (uint32_t i = 0; i < count; ++i) {
                const float u = PluginPath(*sampler->plugin, 3, -8, i).draw()[d] - first;
                cells.insert(static_cast<uint32_t>(std::lround((u + 1) * float(count))) % count);
            }
            CHECK(cells.size() == count, "%u points, dimension %u", count, d);
        }
}

// The parts of split samples form one sequence, unless the plug-in splits in its own way.
void test_split_samples() {
    const SamplerPointer sampler = create("gradient_noise.so", 5);
    for (uint32_t i = 0; i < 192; ++i) {
        const PluginPath split(*sampler->plugin, -5, 9, i / 3), whole(*sampler->plugin, -5, 9, i);
        CHECK(split.first_light(3, i % 3) == whole.first_light(1, 0), "part %u", i);
    }
}

// Slices are tiled over the screen and repeat after their number; every pair reads them at its own offset.
void test_slices() {
    const std::string path = "test_peers_slices.bin";
    const uint32_t size[] = {2, 3, 4}; // depth, height, width
    std::vector<float> numbers(2 * 2 * 3 * 4);
    for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = float(i) / 64;
    const auto write = [&](size_t count) {
        std::ofstream file(path, std::ios::binary);
        file.write(reinterpret_cast<const char *>(size), sizeof size);
        file.write(reinterpret_cast<const char *>(numbers.data()), std::streamsize(4 * count));
    };
    write(numbers.size());
    const SamplerPointer sampler = create("slices.so:" + path, 3);
    const auto pair = [&](int x, int y, uint32_t index, uint32_t ray) {
        return PluginPath(*sampler->plugin, x, y, index).ray(ray).draw();
    };
    std::set<float> seen, others;
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x) {
            const std::array<float, 4> u = pair(x, y, 1, 0);
            CHECK(u == pair(x - 8, y + 6, 5, 0), "pixel %d,%d is not tiled", x, y);
            CHECK(u[1] == u[0] + 1.0f / 64 && u[0] >= 24.0f / 64, "%g %g is no pair", u[0], u[1]);
            seen.insert(u[0]);
            others.insert(u[2]);
        }
    CHECK(seen.size() == 12 && others == seen, "%zu pairs in a slice", seen.size());
    write(numbers.size() - 1);
    bool refused = false;
    try {
        create("slices.so:" + path, 3);
    } catch (const Error &) {
        refused = true;
    }
    CHECK(refused, "a short file was accepted");
    std::remove(path.c_str());
}

// The tables of Heitz et al.: the number is a point of the sequence, ranked and scrambled by the pixel's entries.
void test_heitz() {
    // Dimension d of point p is 5 p + d + spp.
    const std::filesystem::path tables = "test_plugins_heitz";
    std::filesystem::create_directory(tables);
    for (const size_t spp : {4, 16}) {
        std::vector<unsigned char> bytes(65536 + 2 * 131072);
        for (size_t i = 0; i < 65536; ++i)
            bytes[i] = static_cast<unsigned char>(5 * (i / 256) + i % 256 + spp);
        for (size_t i = 65536; i < 65536 + 131072; ++i) bytes[i] = 3;
        for (size_t i = 65536 + 131072; i < bytes.size(); ++i) bytes[i] = 1;
        std::ofstream(tables / (std::to_string(spp) + ".bin"), std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    }
    // The tables for the next count that has some, or the largest.
    for (const auto &[samples, spp] : {std::pair{1u, 4u}, {4, 4}, {5, 16}, {99, 16}, {0, 16}}) {
        const SamplerPointer sampler = create("heitz.so:" + tables.string(), 3, samples);
        for (uint32_t index = 0; index < 8; ++index) {
            const PluginPath numbers(*sampler->plugin, 5, 7, index);
            const std::array<float, 4> camera = numbers.ray(0).draw(),
                                       bounce = numbers.ray(1).draw();
            for (uint32_t d = 0; d < 8; ++d) {
                const float u = d < 4 ? camera[d] : bounce[d - 4];
                const float expected = (float((5 * (index ^ 1) + d + spp) ^ 3) + 0.5f) / 256;
                CHECK(u == expected, "point %u, dimension %u: %g, not %g", index, d, u, expected);
            }
        }
    }
    std::filesystem::remove_all(tables);
}

} // namespace

int main(int argc, char **argv) {
    CHECK(argc == 2 || argc == 3, "name the folder of the plug-ins");
    folder = argv[1];
    test_slices();
    test_heitz();
    test_the_screen_is_a_net();
    test_split_samples();
    test_cascaded_sobol();
    test_quad_optimized("");
    if (argc == 3) test_quad_optimized(argv[2]);
    test_halton();
    test_lattice();
    return 0;
}
