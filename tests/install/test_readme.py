# SPDX-License-Identifier: Apache-2.0
"""The README's examples work as they stand: built against the installed library, run by this Python."""

import re
import sys

import pytest
from conftest import ROOT, cmake_build, run

HEADERS = "".join(path.read_text() for path in sorted((ROOT / "libbn" / "include" / "bn").glob("*.h")))
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


def test_the_languages_are_there():
    assert len(examples("cpp")) == 1 and len(examples("cmake")) == 1


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


def test_files_it_names_exist():
    links = re.findall(r"\]\(([^)#]+)\)", README)
    named = re.findall(r"`((?:scripts|examples|libbn|bindings|tests|docs)/[\w./-]+)`", README)
    missing = [path for path in links + named if "://" not in path and not (ROOT / path).exists()]
    assert missing == []


@pytest.mark.parametrize("option", sorted(set(re.findall(r"`(BN_[A-Z_]+)`", README))))
def test_options_it_names_exist(option):
    cmake = (ROOT / "CMakeLists.txt").read_text()
    assert re.search(rf"\b{option}\b", cmake + HEADERS)


def test_functions_it_names_exist():
    pages = (path for path in (ROOT / "docs").glob("*.md") if path.stem not in ("blue", "shaders"))
    text = README + "".join(path.read_text(encoding="utf-8") for path in pages)
    names = set(re.findall(r"`(bn_[a-z0-9_]+)`", text))
    declared = [name for name in names if re.search(rf"\b{name}\(|\}} {name};|^typedef struct {name}\b", HEADERS, re.M)]
    assert len(names) > 5 and sorted(names) == sorted(declared)
