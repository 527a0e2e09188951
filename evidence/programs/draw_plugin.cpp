// SPDX-License-Identifier: Apache-2.0
// Prints the numbers of a plug-in (sampler_plugin.h) for scripts/bench:
//
//     draw_plugin NAME SEED SAMPLES DECISION DIMENSIONS SIZE FIRST COUNT
//
// writes float32 [SIZE rows][SIZE pixels][COUNT][DIMENSIONS] to standard output, from sample FIRST on. SAMPLES is what the
// plug-in is tuned for, or 0.
//
//     draw_plugin NAME
//
// prints nanoseconds per four-dimensional draw on one core: the minimum of many short measurements, in the order of
// bench_draws.c.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "files.h"
#include "plugin.h"

namespace {

double nanoseconds(const Plugin &plugin) {
    constexpr int ROUNDS = 400, WIDTH = 64, HEIGHT = 4, INDICES = 16, DECISIONS = 6;
    double least = 1e30;
    for (int round = 0; round < ROUNDS; ++round) {
        const auto start = std::chrono::steady_clock::now();
        float u[4];
        for (int i = 0; i < WIDTH * HEIGHT; ++i)
            for (uint32_t index = 0; index < INDICES; ++index)
                for (uint32_t ray = 0; ray < DECISIONS; ++ray)
                    plugin.draw(plugin.state.get(), plugin.seed, i % WIDTH,
                                round % 16 * HEIGHT + i / WIDTH, index,
                                PluginPath::ray_decision(ray), 4, u);
        const std::chrono::duration<double, std::nano> used =
            std::chrono::steady_clock::now() - start;
        least = std::min(least, used.count() / (WIDTH * HEIGHT * INDICES * DECISIONS));
    }
    return least;
}

int print_numbers(char **argv) {
    uint32_t given[7];
    for (int i = 0; i < 7; ++i) given[i] = uint32_t(std::stoul(argv[2 + i]));
    const auto [seed, samples, decision, dimensions, size, first, count] = given;
    const Plugin plugin = plugin_load(argv[1], seed, samples);
    std::vector<float> row(size_t{size} * count * dimensions);
    for (uint32_t y = 0; y < size; ++y) {
        float *u = row.data();
        for (uint32_t i = 0; i < size * count; ++i, u += dimensions) {
            plugin.draw(plugin.state.get(), seed, int32_t(i / count), int32_t(y), first + i % count,
                        decision, dimensions, u);
        }
        if (std::fwrite(row.data(), sizeof(float), row.size(), stdout) != row.size()) return 1;
    }
    return std::fflush(stdout) == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char **argv) {
    try {
        if (argc == 9) return print_numbers(argv);
        if (argc != 2)
            throw Error(
                "usage: draw_plugin NAME [SEED SAMPLES DECISION DIMENSIONS SIZE FIRST COUNT]");
        std::printf("%.2f\n", nanoseconds(plugin_load(argv[1], 0, 0)));
        return 0;
    } catch (const std::exception &error) {
        say(error.what());
        return 1;
    }
}
