# SPDX-License-Identifier: Apache-2.0
"""The guides' code compiles and behaves as they say, and the commands and API examples of the package's pages run."""

import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import CXX, ROOT, listing, run

PAGES = {name: (ROOT / name).read_text(encoding="utf-8") for name in
         ("docs/masks.md", "docs/paths.md", "docs/porting.md", "docs/realtime.md", "bindings/README.md", "bindings/api.md")}
# The parts of a renderer that the fragments use.
RENDERER = """
struct Lanes { const uint32_t *pixel, *index, *depth; std::array<float, 4> *u; };
void shade(float, std::array<float, 2>);
"""
NAMES = {"int": ("x", "y", "small_x", "small_y"), "unsigned": ("index", "depth", "frame", "n", "width"), "std::size_t": ("count",),
         "const Lanes &": ("lanes",), "uint64_t": ("seed",), "const bn::Sampler &": ("sampler",), "const bn::PathSampler &": ("path",)}


def fragments(page):
    """A page's unnamed C++ listings. Other tests compile the named ones."""
    found = re.findall(r"(<!-- listing[^\n]*\n)?^( *)```cpp\n(.*?)^ *```$", PAGES[page], re.MULTILINE | re.DOTALL)
    return [text for name, _, text in found if not name]


def test_fragments_compile(tmp_path):
    code = listing("porting.md", "counted.hpp") + RENDERER
    for i, text in enumerate(fragments("docs/porting.md") + fragments("docs/realtime.md")):
        names = NAMES if "Get1D" not in text else {"BlueSampler &": ("sampler",)}
        parameters = ", ".join(f"[[maybe_unused]] {type} {name}" for type, group in names.items() for name in group
                               if not re.search(rf"bn::\w+ {name}\(", text))
        code += f"void fragment{i}({parameters}) {{\n{text}}}\n"
    (tmp_path / "fragments.cpp").write_text(code)
    run(CXX, "-std=c++17", "-Wall", "-Wextra", "-Werror", "-Wno-unused-variable", "-Wno-unused-but-set-variable",
        "-I", ROOT / "libbn/include", "-fsyntax-only", tmp_path / "fragments.cpp")


@pytest.mark.parametrize("text", re.findall(r"```python\n(.*?)```", PAGES["bindings/api.md"], re.DOTALL))
def test_api_examples_run(text, tmp_path, monkeypatch):
    bluenoise = pytest.importorskip("bluenoise")
    monkeypatch.chdir(tmp_path)
    exec(text, {"bluenoise": bluenoise, "np": np, "sampler": bluenoise.Sampler()})


def test_commands_run(tmp_path):
    image = pytest.importorskip("PIL.Image")
    OpenEXR = pytest.importorskip("OpenEXR")
    for name in ("scipy", "bluenoise"):
        pytest.importorskip(name)
    image.effect_noise((40, 30), 50).convert("RGB").save(tmp_path / "photo.jpg")
    image.effect_noise((16, 16), 50).save(tmp_path / "texture.png")
    for seed, name in enumerate(("first", "second")):
        light = np.random.default_rng(seed).random((30, 40), np.float32)
        with OpenEXR.File({"type": OpenEXR.scanlineimage}, dict.fromkeys("RGB", light)) as file:
            file.write(str(tmp_path / f"{name}.exr"))
    commands = re.findall(r"^bluenoise .*", PAGES["bindings/README.md"], re.MULTILINE)
    assert len(commands) >= 7
    program = f"{sys.executable} -m bluenoise"
    for command in commands:
        small = command.split("#")[0].replace("--size 128", "--size 16").replace("--count 4000", "--count 40")  # for speed
        run("bash", "-o", "pipefail", "-c", re.sub(r"\bbluenoise\b", program, small), cwd=tmp_path)
    assert {Path(name).stem for name in os.listdir(tmp_path)} == {
        "photo", "texture", "mask", "rgba", "out", "points", "stipples", "first", "second", "noise"}


# ---- docs/masks.md

MODEL_PROGRAM = """
#include <stdio.h>
int main(void) {
    static uint32_t ranks[64 * 64];
    bn_sampler sampler = bn_sampler_make(1);
    const int made = sampler_of_model("/nowhere.onnx", 1, ranks, &sampler);
    printf("%d %d\\n", made, sampler.type == BN_SAMPLER_BLUE);
}
"""


def test_masks_keep_the_sampler_if_the_model_is_missing(static_library, tmp_path):
    (text,) = re.findall(r"```c\n(.*?)```", PAGES["docs/masks.md"], re.DOTALL)
    (tmp_path / "main.c").write_text(text + MODEL_PROGRAM)
    static_library.compile(tmp_path / "main.c", tmp_path / "program")
    assert run(tmp_path / "program") == "0 1\n"


@pytest.mark.parametrize("text", re.findall(r"```python\n(.*?)```", PAGES["docs/masks.md"], re.DOTALL))
def test_masks_in_python(text, tmp_path, monkeypatch):
    bluenoise = pytest.importorskip("bluenoise")
    if "neural(" in text:  # tests/python/test_neural.py runs it
        return
    monkeypatch.chdir(tmp_path)
    exec(text.replace("(64, 64)", "(16, 16)"), {"bluenoise": bluenoise})  # for speed
    for name in re.findall(r'save\("([^"]+)"', text):
        assert bluenoise.load(name, rank=True).shape[-2:] == (16, 16)


# ---- docs/stop.md

# Every pixel averages a half-plane of its pair of numbers; the area below the line is the right value.
STOP_PROGRAM = r"""
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


def test_stop(static_library, tmp_path):
    """`blue` stops earlier than white noise, at an image that is close to the right one."""
    (tmp_path / "listing.hpp").write_text(listing("stop.md", "stop.hpp"))
    (tmp_path / "main.cpp").write_text(STOP_PROGRAM)
    lines = run(static_library.compile_cpp(tmp_path / "program", tmp_path / "main.cpp")).split()
    blue, sobol, white = map(int, lines[::2])
    assert 4 <= blue <= sobol <= white / 2 < 4096 / 2
    assert all(abs(float(mean) / (0.4 * 0.45) - 1) < 0.01 for mean in lines[1::2])


# ---- docs/paths.md

# Prints the number of errors.
PATHS_MAIN = """
#include <algorithm>
#include <cstdio>
#include <vector>
static float half_density(float) { return 0.5f; }
int main() {
    const bn::Sampler sampler(3);
    int wrong = 0;
    const float cdf[] = {0.25f, 0.5f, 1.0f}, left[] = {0, 0.25f, 0.5f, 0.75f};
    const float two[] = {0.5f, 0.5f}, rows[] = {1, 4}, columns[] = {1, 1, 1, 0, 0, 3};
    double lights[3] = {}, leaves[4] = {}, crossed = 0, below = 0, passed = 0, first = 0, middle = 0, dark = 0;
    double texels[2][3] = {}, directions[4] = {}, places = 0;
    const int samples = 64 * 64 * 16;
    for (int i = 0; i < samples; ++i) {
        const bn::PathSampler path(sampler, i % 64, i / 64 % 64, unsigned(i / 4096));
        bn::RaySampler ray = path.ray(1);
        float point[2];
        lights[choose_light(ray.draw_end_light(), cdf, 3, point)] += 1.0 / samples;
        middle += (point[0] + point[1]) / 2 / samples;
        leaves[descend(ray, left, 2, point)] += 1.0 / samples;
        crossed += (free_flight(ray, 2, half_density, 1) >= 1) / double(samples);
        below += (walk(ray) > 0) / double(samples);
        // The result does not depend on earlier draws.
        passed += passes(ray, 7, 0.25f) / double(samples);
        wrong += passes(ray, 7, 0.25f) != passes(path.ray(1), 7, 0.25f);
        first += first_wavelength(path) / samples;
        dark += !(through_leaves(path, two, 2) > 0) / double(samples);
        const Texel texel = choose_texel(ray.draw_end_light(), rows, columns, 3, 2);
        texels[texel.row][texel.column] += 1.0 / samples;
        const Direction direction = choose_direction(ray, cdf, 3);
        directions[direction.to_light ? direction.light : 3] += 1.0 / samples;
        places += (texel.u + texel.v + direction.u + direction.v) / 4 / samples;
        const Start plain = start(path, false), lens = start(path, true);
        wrong += plain.film[0] != lens.film[0] || plain.light[0] != lens.lens[0] || lens.light[0] == lens.lens[0];
        wrong += shutter_time(path) != path.time_wavelength()[0] || shutter_time(path) == lens.lens[0];
        wrong += trace(sampler, 3, 4, unsigned(i)) != trace(sampler, 3, 4, unsigned(i));
    }
    const auto near = [](double a, double b) { return std::fabs(a - b) < 0.004; };
    wrong += !near(lights[0], 0.25) + !near(lights[1], 0.25) + !near(lights[2], 0.5) + !near(middle, 0.5);
    wrong += !near(leaves[0], 0.125) + !near(leaves[1], 0.125) + !near(leaves[2], 0.5625) + !near(leaves[3], 0.1875);
    wrong += !near(texels[0][0], 0.25) + (texels[0][1] + texels[0][2] > 0) + (texels[1][0] + texels[1][1] > 0) + !near(texels[1][2], 0.75);
    wrong += !near(directions[0], 0.125) + !near(directions[1], 0.125) + !near(directions[2], 0.25) + !near(directions[3], 0.5);
    wrong += !near(places, 0.5) + !near(dark, 0.25);
    // The length is 1, and the density is 0.5.
    wrong += !near(crossed, std::exp(-0.5)) + !near(passed, 0.75) + !near(first, 0.5) + !(below > 0 && below < 1);
    // Branches form one sequence over a pixel's samples, both with a fixed and with a varying branch count.
    for (unsigned way = 0; way < 2; ++way) {
        unsigned taken = 0, branches = 0;
        std::vector<float> all;
        for (unsigned index = 0; index < 16; ++index) {
            const bn::PathSampler path(sampler, 5, 6, index);
            bn::RaySampler ray = path.ray(0);
            const unsigned count = way ? 4 : 1 + index % 7;
            bn::RaySampler again = path.ray(0);
            const bn::Split split = way ? again.next_split(count) : again.next_split_from(branches);
            for (unsigned k = 0; k < count; ++k) all.push_back(split[k].ray(0).draw_direction()[0]);
            branches += count;
            way ? split_(ray, count) : split_by_weight(ray, count, taken);
        }
        wrong += !way && taken != branches;
        // In a (0,2)-sequence, each 32nd of [0, 1) contains one of 32 numbers.
        all.resize(32);
        std::sort(all.begin(), all.end());
        for (unsigned i = 0; i < 32; ++i) wrong += unsigned(32 * all[i]) != i;
    }
    std::printf("%d\\n", wrong);
}
"""


def test_paths(static_library, tmp_path):
    listings = re.findall(r"^<!-- listing -->\n```cpp\n(.*?)^```", PAGES["docs/paths.md"], re.MULTILINE | re.DOTALL)
    assert len(listings) == 14
    text = "".join(listings).replace("float split(", "float split_(")
    includes = "#include <bn/bn.hpp>\n#include <cmath>\n"
    (tmp_path / "main.cpp").write_text(includes + text + PATHS_MAIN)
    assert run(static_library.compile_cpp(tmp_path / "program", tmp_path / "main.cpp")) == "0\n"
