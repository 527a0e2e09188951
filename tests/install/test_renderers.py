# SPDX-License-Identifier: Apache-2.0
"""The sampler for pbrt-v4 and the sampling pattern for Cycles compile and draw the numbers that these renderers request. They are
bit-identical to the library's, and none is drawn twice."""

import re
import shutil

import pytest
from conftest import ROOT, run

HERE = ROOT / "tests" / "install"
PBRT, CYCLES = ROOT / "examples" / "pbrt", ROOT / "examples" / "cycles"


@pytest.fixture(scope="module")
def programs(static_library, tmp_path_factory):
    """Programs that draw like a renderer: in place of its headers, stand-ins; Cycles also as for GPUs, which avoid 64-bit products."""
    folder = tmp_path_factory.mktemp("renderers")
    for name in re.findall(r"#include <(pbrt/[^>]+)>", (PBRT / "blue.h").read_text() + (PBRT / "blue.cpp").read_text()):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text((PBRT / "blue.h").read_text() if name == "pbrt/blue.h" else f'#include "{HERE}/pbrt/stand_in.h"\n')
    sample = folder / "kernel" / "sample"
    sample.mkdir(parents=True)
    for path in (CYCLES / "blue.h", *((ROOT / "libbn" / "include" / "bn" / f"bn_{name}.glsl") for name in ("draw", "path"))):
        shutil.copy(path, sample)
    cycles = HERE / "cycles" / "draws.cpp"
    sources = {"pbrt": [HERE / "pbrt" / "draws.cpp", PBRT / "blue.cpp"], "cycles": [cycles], "gpu": ["-D__KERNEL_GPU__", cycles]}
    return {name: static_library.compile_cpp(folder / f"draw-{name}", "-I", folder, *source) for name, source in sources.items()}


@pytest.mark.parametrize(("program", "order", "depths", "least"), [
    *(("pbrt", order, 40, 4 + 40 * 7) for order in ("7", "10", "cpu", "late")),
    *(("cycles", kind, 30, 5 + 29 * 6) for kind in ("surface", "volume", "subsurface"))])
def test_no_number_is_drawn_twice(programs, program, order, depths, least):
    lines = run(programs[program], "path", order, depths).splitlines()
    # Two different numbers are identical with probability 2^-24 in one sample, and practically never in all eight.
    assert len(set(lines)) == len(lines) >= least
    assert all(0 <= float(number) < 1 for line in lines for number in line.split())


@pytest.mark.parametrize("arguments", ["pbrt wavefront 40", "pbrt domains", "pbrt frames", "pbrt wavelengths", "cycles domains",
                                       "gpu domains"])
def test_comparisons_find_no_differences(programs, arguments):
    """Decisions use the domains listed in the READMEs. In pbrt, the wavefront integrator draws the same numbers as an uninterrupted path,
    frames continue the samples, and at few samples wavelengths are evenly spaced."""
    program, *rest = arguments.split()
    assert run(programs[program], *rest) == "0\n"


@pytest.mark.parametrize(("patch", "files"), [
    (PBRT / "pbrt-v4.patch", ["CMakeLists.txt", "src/pbrt/base/sampler.h", "src/pbrt/samplers.cpp", "src/pbrt/samplers.h"]),
    (CYCLES / "cycles.patch", ["src/kernel/CMakeLists.txt", "src/kernel/sample/pattern.h", "src/kernel/types.h",
                               "src/scene/CMakeLists.txt", "src/scene/integrator.cpp"])], ids=["pbrt", "cycles"])
def test_patch_changes_the_expected_files(patch, files):
    assert re.findall(r"^\+\+\+ b/(.*)", patch.read_text(), re.MULTILINE) == files
