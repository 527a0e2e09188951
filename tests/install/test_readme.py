# SPDX-License-Identifier: Apache-2.0
"""The README's examples work as they stand: built against the installed library, run by this Python."""

import re
import sys

import pytest
from conftest import ROOT, cmake_build, run

README = (ROOT / "README.md").read_text(encoding="utf-8")


def examples(language, text=README):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


RENDERER = "static float shade(float u, float v, float s, float t, float a, float b) { return u * v * s * t * a * b; }\n"
MAIN = """
#include <cstdio>
int main() {
    const bn::Sampler sampler(1);
    for (unsigned index = 0; index < 4; ++index) std::printf("%g\\n", double(trace(sampler, 17, 4, index)));
}
"""


def program():
    (text,) = examples("cpp")
    return RENDERER + text + MAIN


def test_program(static_library, tmp_path):
    (tmp_path / "main.cpp").write_text(program())
    lines = run(static_library.compile_cpp(tmp_path / "main", tmp_path / "main.cpp")).splitlines()
    assert len(set(lines)) == 4 and all(0 <= float(number) < 4 for number in lines)


def test_cmake_project(installed, tmp_path):
    target = "cmake_minimum_required(VERSION 3.21)\nproject(example LANGUAGES CXX)\nadd_executable(example main.cpp)\n"
    (tmp_path / "CMakeLists.txt").write_text(target + examples("cmake")[0])
    (tmp_path / "main.cpp").write_text(program())
    cmake_build(tmp_path, tmp_path / "build", f"-DCMAKE_PREFIX_PATH={installed.prefix}")
    assert len(run(tmp_path / "build" / "example").splitlines()) == 4


@pytest.mark.parametrize("text", examples("python", (ROOT / "bindings" / "README.md").read_text()))
def test_python(tmp_path, text):
    pytest.importorskip("bluenoise")
    (tmp_path / "example.py").write_text(text)
    run(sys.executable, "-W", "error", "example.py", cwd=tmp_path)
