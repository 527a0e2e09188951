/* SPDX-License-Identifier: Apache-2.0
 * Runs device code on the host. The including file defines answer(), which computes the results of one case as described
 * in shader_cases.c. The program compares all cases and prints how many words differ. */
#include <stdio.h>
#include <stdlib.h>

#include <string>
#include <vector>

static void answer(const uint32_t *words, const float *cdf, const uint32_t *asked,
                   uint32_t *result);

template <class T>
static std::vector<T> contents(const std::string &path) {
    std::vector<T> all(1 << 23);
    FILE *file = fopen(path.c_str(), "rb");
    if (file == nullptr) {
        fprintf(stderr, "cannot read %s\n", path.c_str());
        exit(2);
    }
    all.resize(fread(all.data(), sizeof(T), all.size(), file));
    fclose(file);
    return all;
}

int main(int, char **arguments) {
    const std::string folder = arguments[1];
    const auto words = contents<uint32_t>(folder + "/words.bin");
    const auto cdf = contents<float>(folder + "/cdf.bin");
    const auto cases = contents<uint32_t>(folder + "/cases.bin");
    const auto expected = contents<uint32_t>(folder + "/expected.bin");
    if (cases.empty() || expected.size() != cases.size()) return 2;
    size_t wrong = 0;
    for (size_t at = 0; at < cases.size(); at += 16) {
        uint32_t result[16] = {};
        answer(words.data(), cdf.data(), &cases[at], result);
        for (size_t i = 0; i < 16; ++i) wrong += result[i] != expected[at + i];
    }
    printf("%zu cases, %zu wrong words\n", cases.size() / 16, wrong);
    return wrong == 0 ? 0 : 1;
}
