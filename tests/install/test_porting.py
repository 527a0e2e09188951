# SPDX-License-Identifier: Apache-2.0
"""The listings of docs/porting.md compile, draw what the library draws, and its check tells mistakes apart."""

import os
import re

import pytest
from conftest import ROOT, run

GUIDE = (ROOT / "docs" / "porting.md").read_text(encoding="utf-8")
FLAGS = ("-Wall", "-Wextra", "-Werror", "-O1")

# What MISTAKE is, and what the guide calls it.
MISTAKES = {
    "none": "none",
    "index from 1": "the index starts at 1",
    "index from 1000": "the index starts at 1000",
    "index over the picture": "the index counts the samples of the picture",
    "index stuck at 0": "the index stays at 0",
    "domain per sample": "a counter of domains that is not reset for each sample",
    "domain or seed per pixel": "a seed or a domain hashed from the pixel",
    "pixel number": "x is the number of the pixel, y is 0",
    "tile coordinates": "x, y in tiles of 16 x 16",
    "exchanged in tiles": "x and y exchanged inside tiles of 16 x 16",
    "shared domain": "two decisions share a domain",
    "sobol": "`BN_SAMPLER_SOBOL` in place of `BLUE`",
    "white": "`BN_SAMPLER_WHITE`",
}


def listing(name):
    (text,) = re.findall(rf"^<!-- listing: {re.escape(name)} -->\n```\w+\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    return text


@pytest.fixture(scope="module")
def build(static_library, tmp_path_factory):
    """Compiles texts {name: text}, as C or C++ by their names, links them with the library and returns the program."""
    def build(**files):
        folder = tmp_path_factory.mktemp("listing")
        for name, text in files.items():
            (folder / name.replace("_dot_", ".")).write_text(text)
        sources = sorted(path for path in folder.iterdir() if path.suffix in (".c", ".cpp"))
        compiler = [os.environ.get("CXX", "c++"), "-std=c++17"] if sources[0].suffix == ".cpp" else [
            os.environ.get("CC", "cc"), "-std=c99"]
        run(*compiler, *FLAGS, *static_library.pkg_config("--cflags"), *sources, "-o", folder / "program",
            *static_library.pkg_config("--libs", "--static"), "-lm")
        return folder / "program"

    return build


@pytest.fixture(scope="module")
def check(build):
    mistakes = (ROOT / "tests" / "install" / "porting_mistakes.c").read_text()
    program = build(check_dot_c=listing("check.c"), mistakes_dot_c=mistakes)

    def check(mistake, **settings):
        printed = run(program, env={**os.environ, "MISTAKE": mistake, **settings})
        return re.findall(r"-?[\d.]+$", printed, re.MULTILINE)

    return check


def test_the_table_is_what_the_check_prints(check):
    rows = ["| mistake | 1 spp | 4 spp | 16 spp | repeats | shared |", "| --- | ---: | ---: | ---: | ---: | ---: |"]
    rows += [f"| {name} | {' | '.join(check(mistake)).replace('-0.00', '0.00')} |" for mistake, name in MISTAKES.items()]
    table = GUIDE.split("<!-- table: tests/install/test_porting.py -->\n\n")[1].split("\n\n<!--")[0]
    assert table == "\n".join(rows)


def limits():
    """The least and the greatest of each figure that the guide allows: three errors, repeats, shared."""
    text = " ".join(GUIDE.split("A correct\n")[1].split("Where in these")[0].split())
    number = r"(-?[\d.]*\d)"
    found = re.search(rf"{number} to {number} at 1 spp, {number} to {number} at 4 and {number} to {number} at 16, "
                      rf"up to {number} repeats, and \*shared\* between {number} and {number}", text).groups()
    numbers = [float(number) for number in found[:6] + ("0",) + found[6:]]
    return list(zip(numbers[::2], numbers[1::2]))


@pytest.mark.parametrize("layout", ["next ray", "second pair", "grandchild"])
def test_correct_integrations_are_within_the_limits(check, layout):
    """With BN_SEEDS=100 and -s it prints the extremes that the guide names."""
    seeds = range(int(os.environ.get("BN_SEEDS", "4")))
    figures = list(zip(*([float(number) for number in check("none", SEED=str(seed), LAYOUT=layout)] for seed in seeds)))
    print(f"\n{layout}: " + ", ".join(f"{min(found) + 0:g} to {max(found) + 0:g}" for found in figures))
    assert all(least <= min(found) and max(found) <= most for (least, most), found in zip(limits(), figures)), figures


@pytest.mark.parametrize("mistake", [mistake for mistake in MISTAKES if mistake not in ("none", "index from 1000")])
def test_the_check_notices(check, mistake):
    """With one of eight seeds. Samples from 1000 on are too blue for it."""
    assert any(float(found) > most for seed in range(8) for found, (_, most) in zip(check(mistake, SEED=str(seed)), limits()))


COUNTER = """
#include <cstdio>
#include "counter.hpp"
int main() {
    bn_sampler *sampler;
    if (bn_sampler_create(nullptr, &sampler) != BN_SUCCESS) return 1;
    CounterSampler counter(sampler);
    const uint32_t singles = bn_domain_child(BN_DOMAIN_ROOT, 1u << 20);
    int wrong = 0;
    for (int x = 0; x < 40; ++x) {
        float u[2], own[4];
        counter.start(x, 3, 5);
        for (uint32_t k = 0; k < 6; ++k) {
            if (k == 4) counter.start_ray(7);
            const uint32_t pair = k < 4 ? k : 10 + k, single = k < 4 ? k : 108 + k;
            counter.next_2d(u);
            bn_sample_4d(sampler, x, 3, 5, bn_domain_child(BN_DOMAIN_ROOT, pair / 2), own);
            wrong += u[0] != own[pair % 2 * 2] || u[1] != own[pair % 2 * 2 + 1];
            wrong += counter.next_1d() != bn_sample_1d(sampler, x, 3, 5, bn_domain_child(singles, single));
        }
    }
    std::printf("%d\\n", wrong);
    bn_sampler_destroy(sampler);
    return 0;
}
"""


def test_counter(build):
    assert run(build(counter_dot_hpp=listing("counter.hpp"), main_dot_cpp=COUNTER)) == "0\n"


WAVEFRONT = """
#include <cstdio>
#include "wavefront.hpp"
int main() {
    bn_sampler *sampler;
    if (bn_sampler_create(nullptr, &sampler) != BN_SUCCESS) return 1;
    Lanes lanes;
    int wrong = !draw_stage(sampler, lanes);
    for (int lane = 0; lane < 101; ++lane) {
        lanes.x.push_back(lane * 7 % 40 - 9);
        lanes.y.push_back(lane / 3);
        lanes.index.push_back(uint32_t(lane * lane));
        lanes.depth.push_back(uint32_t(lane % 5));
    }
    wrong += !draw_stage(sampler, lanes) || lanes.u.size() != 404;
    for (size_t lane = 0; lane < 101; ++lane) {
        float own[4];
        bn_sample_4d(sampler, lanes.x[lane], lanes.y[lane], lanes.index[lane],
                     bn_domain_child(BN_DOMAIN_ROOT, lanes.depth[lane]), own);
        for (size_t d = 0; d < 4; ++d) wrong += lanes.u[4 * lane + d] != own[d];
    }
    std::printf("%d\\n", wrong);
    bn_sampler_destroy(sampler);
    return 0;
}
"""


def test_wavefront(build):
    assert run(build(wavefront_dot_hpp=listing("wavefront.hpp"), main_dot_cpp=WAVEFRONT)) == "0\n"


LIGHTS = """
#include <stdio.h>
#include "lights.h"
int main(void) {
    const float cdf[] = {0.125f, 0.125f, 0.25f, 0.5f, 0.625f, 0.75f, 1.0f};
    const float below[] = {0, 0.125f, 0.125f, 0.25f, 0.5f, 0.625f, 0.75f};
    const uint32_t triangles[] = {1, 5, 2, 3, 4, 12, 100};
    int wrong = 0;
    for (int i = 0; i < 1 << 24; i += 7) {
        uint32_t triangle;
        const float before = (float)i / (1 << 24);
        float u[2] = {before, 0.5f};
        const uint32_t k = pick(cdf, triangles, 7, u, &triangle);
        const float back = ((float)triangle + u[0]) / (float)triangles[k] * (cdf[k] - below[k]) + below[k];
        wrong += !(u[0] >= 0 && u[0] < 1) || u[1] != 0.5f || k == 1 || triangle >= triangles[k];
        wrong += back < before - 1e-6f || back > before + 1e-6f;
    }
    printf("%d\\n", wrong);
    return 0;
}
"""


def test_choice_of_a_light(build):
    assert run(build(lights_dot_h=listing("lights.h"), main_dot_c=LIGHTS)) == "0\n"


# The few names of Cycles that its listing uses, then a comparison with the library.
CYCLES = """
#include <bn/bn.h>
#include <cstdio>
#include <cstring>
#include <vector>
typedef unsigned uint;
struct float3 { float x, y, z; };
struct float4 { float x, y, z, w; };
struct Globals { std::vector<float> sample_pattern_lut; };
typedef const Globals *KernelGlobals;
enum { PRNG_FILTER = 0, PRNG_LENS_TIME = 1, PRNG_TERMINATE = 0, PRNG_LIGHT = 1, PRNG_SURFACE_BSDF = 3, PRNG_BOUNCE_NUM = 16 };
#define ccl_device_inline [[maybe_unused]] static inline
#define kernel_data_fetch(name, index) kg->name[index]
static float3 make_float3(float x, float y, float z) { return {x, y, z}; }
static float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }
static uint __float_as_uint(float f) { uint u; std::memcpy(&u, &f, 4); return u; }
static uint reverse_integer_bits(uint v) {
    uint r = 0;
    for (int i = 0; i < 32; ++i) r |= (v >> i & 1) << (31 - i);
    return r;
}
#include "cycles.h"
int main() {
    bn_sampler *sampler;
    size_t count;
    if (bn_sampler_create(nullptr, &sampler) != BN_SUCCESS) return 1;
    bn_sampler_table_words(sampler, nullptr, 0, &count);
    Globals globals;
    globals.sample_pattern_lut.resize(count);
    bn_sampler_table_words(sampler, reinterpret_cast<uint32_t *>(globals.sample_pattern_lut.data()), count, nullptr);
    const struct { int dimension; uint32_t key; int half; } decisions[] = {
        {PRNG_FILTER, 0, 0}, {PRNG_LENS_TIME, 3, 0}, {16 + PRNG_LIGHT, 0, 1}, {16 + PRNG_SURFACE_BSDF, 1, 0},
        {32 + PRNG_LIGHT, 1, 1}, {48 + PRNG_LIGHT, 2, 1}, {48 + PRNG_SURFACE_BSDF, 4, 0}};
    int wrong = 0;
    for (int x = 0; x < 50; ++x)
        for (const auto &d : decisions) {
            float own[4];
            bn_sample_4d(sampler, x, 900, 300, bn_domain_child(BN_DOMAIN_ROOT, d.key), own);
            const float3 u = path_rng_3D(&globals, path_rng_pixel_init(&globals, 0, x, 900), 300, d.dimension);
            wrong += u.x != own[2 * d.half] || u.y != own[2 * d.half + 1] || u.z == own[0] || u.z == own[2];
        }
    std::printf("%d\\n", wrong);
    bn_sampler_destroy(sampler);
    return 0;
}
"""


def test_cycles(build):
    assert run(build(cycles_dot_h=listing("cycles.h"), main_dot_cpp=CYCLES)) == "0\n"


def test_links_are_there():
    links = re.findall(r"\]\(([^)#]+)", GUIDE)
    assert [link for link in links if "://" not in link and not (ROOT / "docs" / link).exists()] == []
