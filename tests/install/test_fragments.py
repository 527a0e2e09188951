# SPDX-License-Identifier: Apache-2.0
"""The guides' code fragments compile, and the commands and API examples of the package's pages run."""

import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import CXX, ROOT, listing, run

PAGES = {name: (ROOT / name).read_text(encoding="utf-8") for name in
         ("docs/porting.md", "docs/realtime.md", "bindings/README.md", "bindings/api.md")}
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
