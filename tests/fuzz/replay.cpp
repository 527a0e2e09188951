// SPDX-License-Identifier: Apache-2.0
// Runs a fuzzer without libFuzzer, with any compiler: `fuzz_gltf CORPUS [COUNT [SEED]]` gives it every
// file of the corpus, which must be read, then COUNT inputs made from them: bytes changed, cut out,
// repeated and put in from elsewhere. The inputs depend on the seed alone.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);
extern bool fuzz_input_was_read;

namespace {

using Bytes = std::vector<uint8_t>;

constexpr size_t LONGEST = 1 << 16;

uint32_t state;

// Marsaglia, "Xorshift RNGs", 2003.
size_t below(size_t limit) {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return limit ? state % limit : 0;
}

struct Seed {
    std::filesystem::path path;
    Bytes bytes;
};

std::vector<Seed> read_corpus(const char *folder) {
    std::vector<std::filesystem::path> paths;
    for (const auto &entry : std::filesystem::directory_iterator(folder))
        paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<Seed> corpus;
    for (const std::filesystem::path &path : paths) {
        std::ifstream file(path, std::ios::binary);
        const std::istreambuf_iterator<char> begin(file), end;
        corpus.push_back({path, {begin, end}});
    }
    return corpus;
}

Bytes piece_of(const Bytes &bytes) {
    const size_t from = below(bytes.size()), end = std::min(from + below(24), bytes.size());
    return {bytes.begin() + std::ptrdiff_t(from), bytes.begin() + std::ptrdiff_t(end)};
}

void change(Bytes &bytes, const Bytes &other) {
    static const uint8_t telling[] = {0, 1, 0x7f, 0x80, 0xff, '-', '0', '9', '{', '"', '/', '\n'};
    if (bytes.empty()) bytes.push_back(0);
    const size_t at = below(bytes.size());
    switch (below(5)) {
    case 0:
        bytes[at] = uint8_t(bytes[at] ^ (1u << below(8)));
        break;
    case 1:
        bytes[at] = telling[below(sizeof telling)];
        break;
    case 2:
        if (below(8) == 0) bytes.resize(at);
        break;
    default: // another piece, or none, in place of one
        const Bytes piece = below(2) ? piece_of(below(2) ? bytes : other) : Bytes();
        const auto begin = bytes.begin() + std::ptrdiff_t(at);
        const size_t cut = std::min(below(24), bytes.size() - at);
        bytes.insert(bytes.erase(begin, begin + std::ptrdiff_t(cut)), piece.begin(), piece.end());
    }
    if (bytes.size() > LONGEST) bytes.resize(LONGEST);
}

// In a block of just its size, so that the address sanitizer sees a byte too far.
void run(const Bytes &bytes) {
    const Bytes exact(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

} // namespace

int main(int argc, char **argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: %s CORPUS [COUNT [SEED]]\n", argv[0]);
        return 1;
    }
    const std::vector<Seed> corpus = read_corpus(argv[1]);
    const long count = argc > 2 ? std::atol(argv[2]) : 0;
    state = argc > 3 ? static_cast<uint32_t>(std::strtoul(argv[3], nullptr, 10)) | 1 : 1;
    if (corpus.empty()) {
        std::fprintf(stderr, "%s: %s is empty\n", argv[0], argv[1]);
        return 1;
    }
    for (const Seed &seed : corpus) {
        fuzz_input_was_read = false;
        run(seed.bytes);
        if (fuzz_input_was_read) continue;
        std::fprintf(stderr, "%s: %s is refused\n", argv[0], seed.path.c_str());
        return 1;
    }
    for (long i = 0; i < count; ++i) {
        Bytes bytes = corpus[below(corpus.size())].bytes;
        const Bytes &other = corpus[below(corpus.size())].bytes;
        for (size_t changes = 1 + below(4); changes > 0; --changes) change(bytes, other);
        run(bytes);
    }
    std::printf("%zu files and %ld inputs made from them\n", corpus.size(), count);
    return 0;
}
