# SPDX-License-Identifier: Apache-2.0
"""The sampler for pbrt-v4 compiles and draws the numbers that pbrt requests. No number is drawn twice."""

import re

import pytest
from conftest import ROOT, run

HERE = ROOT / "tests" / "install" / "pbrt"
OWN = ROOT / "examples" / "pbrt"
# The pbrt headers that blue.h and blue.cpp include.
HEADERS = sorted(set(re.findall(r"#include <(pbrt/[^>]+)>", (OWN / "blue.h").read_text() + (OWN / "blue.cpp").read_text())))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder containing blue.h and stand-ins for the other headers."""
    folder = tmp_path_factory.mktemp("pbrt")
    for name in HEADERS:
        header = folder / name
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text((OWN / "blue.h").read_text() if name == "pbrt/blue.h" else f'#include "{HERE / "stand_in.h"}"\n')
    return folder


@pytest.fixture(scope="module")
def draws(folder, static_library):
    return static_library.compile_cpp(folder / "draws", "-I", folder, HERE / "draws.cpp", OWN / "blue.cpp")


@pytest.mark.parametrize("order", ["7", "10", "cpu", "late"])
def test_no_number_is_drawn_twice(draws, order):
    lines = run(draws, "path", order, "40").splitlines()
    # Two different numbers are identical with probability 2^-24 in one sample, and practically never in all eight.
    assert len(set(lines)) == len(lines) >= 4 + 40 * 7
    assert all(0 <= float(number) < 1 for line in lines for number in line.split())


@pytest.mark.parametrize("arguments", [["wavefront", "40"], ["domains"], ["frames"], ["wavelengths"]], ids=lambda arguments: arguments[0])
def test_comparisons_find_no_differences(draws, arguments):
    """The wavefront integrator draws the same numbers as an uninterrupted path, decisions use the domains listed in the README, frames
    continue the samples, and at few samples wavelengths are evenly spaced."""
    assert run(draws, *arguments) == "0\n"


def test_patch_changes_the_expected_files():
    changed = re.findall(r"^\+\+\+ b/(.*)", (OWN / "pbrt-v4.patch").read_text(), re.MULTILINE)
    assert changed == ["CMakeLists.txt", "src/pbrt/base/sampler.h", "src/pbrt/samplers.cpp", "src/pbrt/samplers.h"]
