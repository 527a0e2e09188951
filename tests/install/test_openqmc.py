# SPDX-License-Identifier: Apache-2.0
"""libbn behind OpenQMC's interface: draws and splits match libbn's, and OpenQMC's own trace tool runs with it."""

import os

import numpy as np
import pytest
from conftest import ROOT, run

FOLDER = ROOT / "integrations" / "openqmc"
PROGRAM = r"""
#include <bn_oqmc.h>
#include <bn/bn.hpp>
#include <cstdio>
#include <cstring>
#include <memory>

using Sampler = bn::OpenQmcSampler;

static void expect(bool right, const char *what) {
    if (!right) std::printf("wrong: %s\n", what);
}

static bool equal(const Sampler &sampler, const bn_sampler &own, int x, int y, uint32_t index, uint32_t domain) {
    float four[4], two[2], expected[4];
    std::uint32_t bits[4], ranged[4];
    sampler.drawSample<4>(four);
    sampler.drawSample<2>(two);
    sampler.drawSample<4>(bits);
    sampler.drawSample<4>(10u, ranged);
    bn_sample_4d(&own, x, y, index, domain, expected);
    bool same = std::memcmp(four, expected, sizeof four) == 0 && std::memcmp(two, expected, sizeof two) == 0;
    for (int k = 0; k < 4; ++k) same = same && ranged[k] == std::uint32_t(bits[k] / 4294967296.0 * 10) && ranged[k] < 10;
    return same;
}

int main() {
    std::unique_ptr<unsigned char[]> cache(new unsigned char[Sampler::cacheSize]);
    Sampler::initialiseCache(cache.get());
    const bn_sampler own = bn_sampler_make(0);
    const Sampler pixel(-5, 9, 3, 17, cache.get());
    const uint32_t root = bn_path_stream_domain(3);
    expect(equal(pixel, own, -5, 9, 17, root), "the root");
    expect(equal(pixel.newDomain(7), own, -5, 9, 17, bn_domain_child(root, 7)), "newDomain");
    const uint32_t split = bn_domain_child(bn_domain_child(root, 7), 4);
    expect(equal(pixel.newDomainSplit(7, 4, 2), own, -5, 9, 17 * 4 + 2, split), "newDomainSplit");
    expect(equal(pixel.newDomainSplit(7, 4, 2).newDomain(1), own, -5, 9, 17 * 4 + 2, bn_domain_child(split, 1)), "the domain of a branch");
    const uint32_t child = bn_domain_child(root, 7);
    expect(equal(pixel.newDomainDistrib(7, 2), own, -5, 9, 2, bn_domain_child(child, 17)), "newDomainDistrib");
    expect(equal(pixel.newDomainChain(7, 2), own, -5, 9, 17, bn_domain_child(child, 2)), "newDomainChain");
    Sampler::initialiseCache(cache.get(), 5);
    expect(equal(pixel, bn_sampler_make(5), -5, 9, 17, root), "a seed");
    double sum = 0;
    for (int index = 0; index < 4096; ++index) {
        float rnd[3], sample[3];
        Sampler(1, 2, 0, index, cache.get()).drawRnd<3>(rnd);
        Sampler(1, 2, 0, index, cache.get()).drawSample<3>(sample);
        sum += rnd[0] + rnd[1] + rnd[2];
        expect(rnd[0] != sample[0], "drawRnd returns the same number as drawSample");
    }
    // Every argument that identifies a sample changes its independent numbers.
    const Sampler named[] = {{1, 2, 0, 3, cache.get()}, {2, 2, 0, 3, cache.get()}, {1, 3, 0, 3, cache.get()}, {1, 2, 1, 3, cache.get()},
                             {1, 2, 0, 4, cache.get()}, Sampler(1, 2, 0, 3, cache.get()).newDomain(1)};
    std::uint32_t numbers[6];
    for (int i = 0; i < 6; ++i) {
        std::uint32_t rnd[1];
        named[i].drawRnd<1>(rnd);
        numbers[i] = rnd[0];
        for (int k = 0; k < i; ++k) expect(numbers[k] != numbers[i], "independent numbers are identical");
    }
    expect(sum / 12288 > 0.49 && sum / 12288 < 0.51, "the mean of drawRnd");
    std::puts("done");
}
"""


def test_calls_match_libbn(static_library, tmp_path):
    (tmp_path / "main.cpp").write_text(PROGRAM)
    static_library.compile_cpp(tmp_path / "main", "-std=c++14", f"-I{FOLDER}", tmp_path / "main.cpp")
    assert run(tmp_path / "main") == "done\n"


@pytest.mark.skipif("BN_OPENQMC_TRACES" not in os.environ, reason="BN_OPENQMC_TRACES is not set to a folder with both builds")
def test_openqmc_trace_tool(tmp_path):
    """BN_OPENQMC_TRACES contains two builds of openqmc_trace.cpp: trace_theirs with OpenQMC's samplers, and trace_blue with libbn."""
    ndimage, folder = pytest.importorskip("scipy.ndimage"), os.environ["BN_OPENQMC_TRACES"]
    guide = (FOLDER / "README.md").read_text(encoding="utf-8")

    def image(name, sampler, scene, frame, spp, lights):
        run(f"{folder}/trace_{name}", sampler, scene, "split", frame, spp, lights, 2, 2, tmp_path / "image")
        return np.fromfile(tmp_path / "image", np.float32).reshape(96, 128, 3)

    print("\n| scene | spp | blue | sobolbn |\n| --- | ---: | ---: | ---: |")
    for scene in ("presence", "blur", "box"):
        reference = image("theirs", "sobol", scene, 7, 1024, 1)
        for spp in (1, 4, 16):
            def error(name, sampler):
                errors = [image(name, sampler, scene, frame, spp, 1) - reference for frame in range(3)]
                return np.sqrt(np.mean([ndimage.gaussian_filter(each, (2.1, 2.1, 0)) ** 2 for each in errors]))

            padded = error("theirs", "sobol")
            ours, theirs = error("blue", "sobolbn") / padded, error("theirs", "sobolbn") / padded
            row = f"| {scene} | {spp} | {ours:.2f} | {theirs:.2f} |"
            print(row)
            assert row in guide
            assert scene == "box" or (ours < 0.96 and ours < theirs + 0.02)
