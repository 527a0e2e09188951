# SPDX-License-Identifier: Apache-2.0
"""The sampling pattern for Cycles compiles, and draws what Cycles asks for: no number twice, the library's
bits. With BN_CYCLES=DIR, a clone of Cycles, the patch applies to its tags, though it is not built."""

import os
import re
import subprocess

import pytest
from conftest import ROOT, run

HERE = ROOT / "tests" / "install" / "cycles"
OWN = ROOT / "examples" / "cycles"
PATCH = OWN / "cycles.patch"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with what README.md copies to src/kernel/sample."""
    folder = tmp_path_factory.mktemp("cycles")
    sample = folder / "kernel" / "sample"
    sample.mkdir(parents=True)
    for path in (OWN / "blue.h", *((ROOT / "libbn" / "include" / "bn" / f"bn_{name}.glsl") for name in ("draw", "path"))):
        (sample / path.name).write_text(path.read_text())
    return folder


def link(folder, library, name, *arguments):
    return library.compile_cpp(folder / name, "-I", folder, "-I", HERE, *arguments, HERE / "draws.cpp")


@pytest.fixture(scope="module")
def draws(folder, static_library):
    return link(folder, static_library, "draws")


@pytest.mark.parametrize("kind", ["surface", "volume", "subsurface"])
def test_no_number_is_drawn_twice(draws, kind):
    lines = run(draws, "path", kind, "30").splitlines()
    assert len(lines) >= 5 + 29 * 6
    # Equal in eight samples is no chance: one in 2^24 is equal in a single one.
    assert len(set(lines)) == len(lines)
    assert all(0 <= float(number) < 1 for line in lines for number in line.split())


def test_decisions_have_the_domains_that_the_readme_names(draws):
    assert run(draws, "domains") == "0\n"


def test_kernels_for_gpus_draw_the_same(folder, static_library):
    """Without 64-bit products."""
    program = link(folder, static_library, "gpu", "-D__KERNEL_GPU__")
    assert run(program, "domains") == "0\n"


def test_the_patch_is_for_cycles_alone():
    changed = re.findall(r"^\+\+\+ b/(.*)", PATCH.read_text(), re.MULTILINE)
    assert changed == ["src/kernel/CMakeLists.txt", "src/kernel/sample/pattern.h",
                       "src/kernel/types.h", "src/scene/CMakeLists.txt", "src/scene/integrator.cpp"]


@pytest.mark.skipif("BN_CYCLES" not in os.environ, reason="BN_CYCLES names no clone of Cycles")
def test_the_patch_applies(tmp_path):
    """To each tag from v4.2.0 on, and to what is checked out."""
    environment = {**os.environ, "GIT_INDEX_FILE": str(tmp_path / "index")}

    def git(*arguments):
        command = ["git", "-C", os.environ["BN_CYCLES"], *arguments]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    tags = [tag for tag in git("tag", "--list", "v*").stdout.split() if [int(part) for part in re.findall(r"\d+", tag)] >= [4, 2]]
    for tree in (*tags, "HEAD"):
        assert git("read-tree", tree).returncode == 0
        done = git("apply", "--check", "--cached", PATCH)
        assert done.returncode == 0, f"{tree}: {done.stderr}"
