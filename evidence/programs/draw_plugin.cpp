// SPDX-License-Identifier: Apache-2.0
// Writes the numbers of a plug-in (sampler_plugin.h) to standard output as float32 [SIZE rows][SIZE pixels][COUNT][DIMENSIONS],
// from sample FIRST and pixel (X, Y) on:
//
//     draw_plugin NAME SEED SAMPLES DECISION DIMENSIONS SIZE FIRST COUNT X Y
//
// SAMPLES is what the plug-in is tuned for, or 0.
#include <cstdio>
#include <vector>

#include "files.h"
#include "plugin.h"

static int run(int argc, char **argv) {
    if (argc != 11)
        throw Error(
            "usage: draw_plugin NAME SEED SAMPLES DECISION DIMENSIONS SIZE FIRST COUNT X Y");
    int32_t given[9];
    for (int i = 0; i < 9; ++i) given[i] = int32_t(std::stoll(argv[2 + i]));
    const auto [seed, samples, decision, dimensions, size, first, count, x0, y0] = given;
    const Plugin plugin = plugin_load(argv[1], uint32_t(seed), uint32_t(samples));
    std::vector<float> row(size_t(size) * size_t(count) * size_t(dimensions));
    for (int32_t y = y0; y < y0 + size; ++y) {
        float *u = row.data();
        for (int32_t i = 0; i < size * count; ++i, u += dimensions)
            plugin.draw(plugin.state.get(), plugin.seed, x0 + i / count, y,
                        uint32_t(first + i % count), uint32_t(decision), uint32_t(dimensions), u);
        if (std::fwrite(row.data(), sizeof(float), row.size(), stdout) != row.size())
            throw Error("cannot write the numbers");
    }
    if (std::fflush(stdout) != 0) throw Error("cannot write the numbers");
    return 0;
}

int main(int argc, char **argv) {
    return run_or_say(run, argc, argv);
}
