# SPDX-License-Identifier: Apache-2.0
"""The sampling pattern for Cycles compiles and draws the numbers that Cycles requests. They are bit-identical to the library's, and none
is drawn twice."""

import re

import pytest
from conftest import ROOT, run

HERE = ROOT / "tests" / "install" / "cycles"
OWN = ROOT / "examples" / "cycles"
PATCH = OWN / "cycles.patch"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder containing the files that README.md copies to src/kernel/sample."""
    folder = tmp_path_factory.mktemp("cycles")
    sample = folder / "kernel" / "sample"
    sample.mkdir(parents=True)
    for path in (OWN / "blue.h", *((ROOT / "libbn" / "include" / "bn" / f"bn_{name}.glsl") for name in ("draw", "path"))):
        (sample / path.name).write_text(path.read_text())
    return folder


@pytest.fixture(scope="module")
def link(folder, static_library):
    return lambda name, *options: static_library.compile_cpp(folder / name, "-I", folder, "-I", HERE, *options, HERE / "draws.cpp")


@pytest.fixture(scope="module")
def draws(link):
    return link("draws")


@pytest.mark.parametrize("kind", ["surface", "volume", "subsurface"])
def test_no_number_is_drawn_twice(draws, kind):
    lines = run(draws, "path", kind, "30").splitlines()
    # Two different numbers are identical with probability 2^-24 in one sample, and practically never in all eight.
    assert len(set(lines)) == len(lines) >= 5 + 29 * 6
    assert all(0 <= float(number) < 1 for line in lines for number in line.split())


def test_domains_match_the_readme(draws):
    assert run(draws, "domains") == "0\n"


def test_gpu_kernels_draw_the_same_numbers(link):
    """GPU kernels avoid 64-bit products."""
    assert run(link("gpu", "-D__KERNEL_GPU__"), "domains") == "0\n"


def test_patch_changes_the_expected_files():
    changed = re.findall(r"^\+\+\+ b/(.*)", PATCH.read_text(), re.MULTILINE)
    assert changed == ["src/kernel/CMakeLists.txt", "src/kernel/sample/pattern.h",
                       "src/kernel/types.h", "src/scene/CMakeLists.txt", "src/scene/integrator.cpp"]
