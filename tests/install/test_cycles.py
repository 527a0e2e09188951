# SPDX-License-Identifier: Apache-2.0
"""The sampling pattern for Cycles compiles and draws the numbers that Cycles requests. They are bit-identical to the library's, and none
is drawn twice. `scripts/patches` tests the patch itself."""

import re
import subprocess

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


def test_script_reports_where_the_patch_applies(tmp_path):
    """Uses a repository containing the lines that the patch replaces. One tag has all of them, and another lacks a file's lines."""
    for name, hunks in re.findall(r"^\+\+\+ b/(\S+)\n(.*?)(?=^diff|\Z)", PATCH.read_text(), re.MULTILINE | re.DOTALL):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(line[1:] for line in hunks.splitlines(keepends=True) if line[0] in " -"))
    git = ("git", "-C", tmp_path, "-c", "user.name=test", "-c", "user.email=test")
    run("git", "init", "-q", tmp_path)
    for tag in ("fits", "lacks"):
        run(*git, "add", ".")
        run(*git, "commit", "-qm", tag)
        run(*git, "tag", tag)
        (tmp_path / "src/kernel/types.h").write_text("")
    done = subprocess.run([ROOT / "scripts" / "patches", "cycles", tmp_path, "fits", "lacks"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    fits, lacks = done.stdout.splitlines()
    assert fits == "patches: fits: applies"
    assert lacks.startswith("patches: lacks: does not apply; error: patch failed: src/kernel/types.h")
