// SPDX-License-Identifier: Apache-2.0
// Runs a fuzzer without libFuzzer, with any compiler: `fuzz_gltf CORPUS COUNT` gives it every file of the
// corpus, which must be read, then COUNT inputs made from them, always the same.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);
extern bool fuzz_input_was_read;

using Bytes = std::vector<uint8_t>;

// Replaces up to 24 bytes by another piece of up to 24 bytes, sets one byte, or cuts off the end.
static void change(Bytes &bytes, std::mt19937 &random) {
    if (bytes.empty()) return;
    const auto place = [&] { return bytes.begin() + std::ptrdiff_t(random() % bytes.size()); };
    const auto piece = [&](Bytes::iterator from) {
        return from + std::min<std::ptrdiff_t>(random() % 24, bytes.end() - from);
    };
    static const uint8_t telling[] = {0, 1, 0x7f, 0x80, 0xff, '-', '0', '9', '{', '"', '/', '\n'};
    const unsigned way = random() % 16;
    if (way == 0) bytes.erase(place(), bytes.end());
    if (way > 0 && way < 12) *place() = telling[random() % sizeof telling];
    if (way < 12) return;
    const auto from = place();
    const Bytes copy(from, piece(from));
    const auto at = place();
    bytes.insert(bytes.erase(at, piece(at)), copy.begin(), copy.end());
}

int main(int argc, char **argv) {
    if (argc != 3) return std::fprintf(stderr, "usage: %s CORPUS COUNT\n", argv[0]), 1;
    std::vector<std::filesystem::path> paths;
    for (const auto &entry : std::filesystem::directory_iterator(argv[1]))
        paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<Bytes> corpus;
    for (const auto &path : paths) {
        std::ifstream file(path, std::ios::binary);
        corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
        fuzz_input_was_read = false;
        LLVMFuzzerTestOneInput(corpus.back().data(), corpus.back().size());
        if (!fuzz_input_was_read) return std::fprintf(stderr, "%s is refused\n", path.c_str()), 1;
    }
    std::mt19937 random;
    for (int left = std::atoi(argv[2]); left > 0; --left) {
        Bytes bytes = corpus[random() % corpus.size()];
        for (size_t changes = 1 + random() % 3; changes > 0; --changes) change(bytes, random);
        bytes.shrink_to_fit(); // the address sanitizer sees a byte too far
        LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    }
    return corpus.empty();
}
