# SPDX-License-Identifier: Apache-2.0
"""The listing of docs/stop.md stops `blue` earlier than white noise, at an image that is close to the right one."""

from conftest import listing, run

# Every pixel averages a half-plane of its pair of numbers; the area below the line is the right value.
PROGRAM = r"""
#include "listing.hpp"
#include <cmath>
#include <cstdio>

int main() {
    const uint32_t side = 96;
    for (const bn_sampler_type type : {BN_SAMPLER_BLUE, BN_SAMPLER_SOBOL, BN_SAMPLER_WHITE}) {
        bn_sampler sampler;
        bn_sampler_init(&sampler, type, 1);
        std::vector<float> sum(side * side * 3);
        const auto add = [&](uint32_t index, std::vector<float> &to) {
            for (uint32_t p = 0; p < side * side; ++p) {
                float u[2];
                bn_sample_2d(&sampler, int32_t(p % side), int32_t(p / side), index, 5, 0, u);
                for (int c = 0; c < 3; ++c) to[3 * p + c] += u[0] + 0.5f * u[1] < 0.7f ? 0.4f : 0.0f;
            }
        };
        const uint32_t count = render_until(1, 4096, side, side, 1, add, sum);
        double mean = 0;
        for (const float value : sum) mean += double(value) / count / double(sum.size());
        std::printf("%u %.5f\n", count, mean);
    }
}
"""


def test_listing(static_library, tmp_path):
    (tmp_path / "listing.hpp").write_text(listing("stop.md", "stop.hpp"))
    (tmp_path / "main.cpp").write_text(PROGRAM)
    lines = run(static_library.compile_cpp(tmp_path / "program", tmp_path / "main.cpp")).split()
    blue, sobol, white = map(int, lines[::2])
    assert 4 <= blue <= sobol <= white / 2 < 4096 / 2
    assert all(abs(float(mean) / (0.4 * 0.45) - 1) < 0.01 for mean in lines[1::2])
