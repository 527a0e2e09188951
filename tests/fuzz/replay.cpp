// SPDX-License-Identifier: Apache-2.0
// Runs a fuzzer without libFuzzer, with any compiler: `fuzz_NAME CORPUS [COUNT [SEED]]` gives it
// every file of the corpus, which must be read, or refused if its name begins with "refused", then
// COUNT inputs made from them: bytes changed, cut out, repeated and put in from elsewhere. The inputs
// depend on the seed alone.
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

void change(Bytes &bytes, const Bytes &other) {
    static const uint8_t telling[] = {0, 1, 0x7f, 0x80, 0xff, '-', '0', '9', '{', '"', '/', '\n'};
    if (bytes.empty()) bytes.push_back(0);
    const auto at = static_cast<std::ptrdiff_t>(below(bytes.size()));
    const auto count = static_cast<std::ptrdiff_t>(
        std::min(1 + below(24), bytes.size() - static_cast<size_t>(at)));
    uint8_t &byte = bytes[static_cast<size_t>(at)];
    switch (below(7)) {
    case 0:
        byte = static_cast<uint8_t>(byte ^ (1u << below(8)));
        break;
    case 1:
        byte = static_cast<uint8_t>(below(256));
        break;
    case 2:
        byte = telling[below(sizeof telling)];
        break;
    case 3:
        bytes.erase(bytes.begin() + at, bytes.begin() + at + count);
        break;
    case 4: {
        const Bytes piece(bytes.begin() + at, bytes.begin() + at + count);
        bytes.insert(bytes.begin() + at, piece.begin(), piece.end());
        break;
    }
    case 5: {
        const size_t from = below(other.size()), length = below(24);
        const size_t end = std::min(from + length, other.size());
        bytes.insert(bytes.begin() + at, other.begin() + static_cast<std::ptrdiff_t>(from),
                     other.begin() + static_cast<std::ptrdiff_t>(end));
        break;
    }
    default:
        if (below(8) == 0) bytes.resize(static_cast<size_t>(at));
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
        const bool expected = seed.path.filename().string().rfind("refused", 0) != 0;
        if (fuzz_input_was_read == expected) continue;
        std::fprintf(stderr, "%s: %s is %s\n", argv[0], seed.path.c_str(),
                     expected ? "refused" : "read");
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
