# SPDX-License-Identifier: Apache-2.0
"""The listings of docs/paths.md compile and behave as the page describes."""

import re

from conftest import ROOT, run

GUIDE = (ROOT / "docs" / "paths.md").read_text(encoding="utf-8")
LISTINGS = re.findall(r"^<!-- listing -->\n```cpp\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)

# Prints the number of errors.
MAIN = """
#include <algorithm>
#include <cstdio>
#include <vector>
static float half_density(float) { return 0.5f; }
int main() {
    const bn::Sampler sampler(3);
    int wrong = 0;
    const float cdf[] = {0.25f, 0.5f, 1.0f}, left[] = {0, 0.25f, 0.5f, 0.75f};
    const float two[] = {0.5f, 0.5f}, rows[] = {1, 4}, columns[] = {1, 1, 1, 0, 0, 3};
    double lights[3] = {}, leaves[4] = {}, crossed = 0, below = 0, passed = 0, first = 0, middle = 0, dark = 0;
    double texels[2][3] = {}, directions[4] = {}, places = 0;
    const int samples = 64 * 64 * 16;
    for (int i = 0; i < samples; ++i) {
        const bn::PathSampler path(sampler, i % 64, i / 64 % 64, unsigned(i / 4096));
        bn::RaySampler ray = path.ray(1);
        float point[2];
        lights[choose_light(ray.draw_end_light(), cdf, 3, point)] += 1.0 / samples;
        middle += (point[0] + point[1]) / 2 / samples;
        leaves[descend(ray, left, 2, point)] += 1.0 / samples;
        crossed += (free_flight(ray, 2, half_density, 1) >= 1) / double(samples);
        below += (walk(ray) > 0) / double(samples);
        // The result does not depend on earlier draws.
        passed += passes(ray, 7, 0.25f) / double(samples);
        wrong += passes(ray, 7, 0.25f) != passes(path.ray(1), 7, 0.25f);
        first += first_wavelength(path) / samples;
        dark += !(through_leaves(path, two, 2) > 0) / double(samples);
        const Texel texel = choose_texel(ray.draw_end_light(), rows, columns, 3, 2);
        texels[texel.row][texel.column] += 1.0 / samples;
        const Direction direction = choose_direction(ray, cdf, 3);
        directions[direction.to_light ? direction.light : 3] += 1.0 / samples;
        places += (texel.u + texel.v + direction.u + direction.v) / 4 / samples;
        const Start plain = start(path, false), lens = start(path, true);
        wrong += plain.film[0] != lens.film[0] || plain.light[0] != lens.lens[0] || lens.light[0] == lens.lens[0];
        wrong += shutter_time(path) != path.time_wavelength()[0] || shutter_time(path) == lens.lens[0];
        wrong += trace(sampler, 3, 4, unsigned(i)) != trace(sampler, 3, 4, unsigned(i));
    }
    const auto near = [](double a, double b) { return std::fabs(a - b) < 0.004; };
    wrong += !near(lights[0], 0.25) + !near(lights[1], 0.25) + !near(lights[2], 0.5) + !near(middle, 0.5);
    wrong += !near(leaves[0], 0.125) + !near(leaves[1], 0.125) + !near(leaves[2], 0.5625) + !near(leaves[3], 0.1875);
    wrong += !near(texels[0][0], 0.25) + (texels[0][1] + texels[0][2] > 0) + (texels[1][0] + texels[1][1] > 0) + !near(texels[1][2], 0.75);
    wrong += !near(directions[0], 0.125) + !near(directions[1], 0.125) + !near(directions[2], 0.25) + !near(directions[3], 0.5);
    wrong += !near(places, 0.5) + !near(dark, 0.25);
    // The length is 1, and the density is 0.5.
    wrong += !near(crossed, std::exp(-0.5)) + !near(passed, 0.75) + !near(first, 0.5) + !(below > 0 && below < 1);
    // Branches form one sequence over a pixel's samples, both with a fixed and with a varying branch count.
    for (unsigned way = 0; way < 2; ++way) {
        unsigned taken = 0, branches = 0;
        std::vector<float> all;
        for (unsigned index = 0; index < 16; ++index) {
            const bn::PathSampler path(sampler, 5, 6, index);
            bn::RaySampler ray = path.ray(0);
            const unsigned count = way ? 4 : 1 + index % 7;
            bn::RaySampler again = path.ray(0);
            const bn::Split split = way ? again.next_split(count) : again.next_split_from(branches);
            for (unsigned k = 0; k < count; ++k) all.push_back(split[k].ray(0).draw_direction()[0]);
            branches += count;
            way ? split_(ray, count) : split_by_weight(ray, count, taken);
        }
        wrong += !way && taken != branches;
        // In a (0,2)-sequence, each 32nd of [0, 1) contains one of 32 numbers.
        all.resize(32);
        std::sort(all.begin(), all.end());
        for (unsigned i = 0; i < 32; ++i) wrong += unsigned(32 * all[i]) != i;
    }
    std::printf("%d\\n", wrong);
}
"""


def test_listings(static_library, tmp_path):
    assert len(LISTINGS) == 14
    text = "".join(LISTINGS).replace("float split(", "float split_(")
    includes = "#include <bn/bn.hpp>\n#include <cmath>\n"
    (tmp_path / "main.cpp").write_text(includes + text + MAIN)
    assert run(static_library.compile_cpp(tmp_path / "program", tmp_path / "main.cpp")) == "0\n"
