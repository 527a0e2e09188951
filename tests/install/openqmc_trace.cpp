// SPDX-License-Identifier: Apache-2.0
// Renders an image with OpenQMC's oqmc_trace(). Arguments: those of oqmc_trace(), then an output file for 32-bit floats.
#include <cstdio>
#include <cstdlib>
#include <trace.h>
#include <vector.h>
#include <vector>

int main(int argc, char **argv) {
    if (argc != 10) return 2;
    const int width = 128, height = 96;
    std::vector<float3> out(static_cast<std::size_t>(width) * height);
    int number[5];
    for (int k = 0; k < 5; ++k) number[k] = std::atoi(argv[4 + k]);
    if (!oqmc_trace(argv[1], argv[2], argv[3], width, height, number[0], number[1], number[2],
                    number[3], number[4], out.data()))
        return 1;
    std::FILE *file = std::fopen(argv[9], "wb");
    return file == nullptr ||
           std::fwrite(out.data(), sizeof out[0], out.size(), file) != out.size() ||
           std::fclose(file) != 0;
}
