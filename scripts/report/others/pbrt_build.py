# SPDX-License-Identifier: Apache-2.0
"""pbrt-v4 with the sampler of examples/pbrt, built for the processor alone and without a window."""

import dataclasses
from pathlib import Path

import numpy as np

from ..base.files import write_text
from ..renders import renderer
from . import other_build
from .other_build import ROOT, git

OWN = ROOT / "examples" / "pbrt"
PATCH = OWN / "pbrt-v4.patch"
COMMIT = "5f7a606806a4ac7b939131ded9d7a30ebd02416e"
# Large files of pbrt that a checkout may lack.
MASKS, POINTS = "src/pbrt/util/bluenoise.cpp", "src/pbrt/util/pmj02tables.cpp"
MASK_COUNT, MASK_SIZE, SET_COUNT, SET_SIZE = 48, 128, 5, 65536
STAND_IN_VERSION = 1
OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
           # For submodules whose CMake files are older than CMake 3.5, and a copy without .git
           "-DCMAKE_POLICY_VERSION_MINIMUM=3.5", "-DCMAKE_DISABLE_FIND_PACKAGE_Git=ON",
           "-DCMAKE_CUDA_COMPILER=", f"-DCMAKE_MODULE_PATH={OWN / 'headless'}", "-DGLFW_BUILD_X11=OFF", "-DGLFW_BUILD_WAYLAND=OFF")


@dataclasses.dataclass(frozen=True)
class Built:
    """program: the path of pbrt. remarks: what differs from the pinned sources, in sentences."""

    program: Path
    remarks: tuple


def check(checkout):
    """Raises RenderError unless `checkout` is pbrt-v4 at COMMIT, with submodules."""
    update = f"git -C {checkout} submodule update --init --recursive"
    other_build.check(checkout, "pbrt-v4", "src/pbrt/samplers.h", COMMIT, "git clone --recursive https://github.com/mmp/pbrt-v4",
                      f"git -C {checkout} checkout {COMMIT} && {update}")
    if not (checkout / "src" / "ext" / "ptex" / "CMakeLists.txt").is_file():
        raise renderer.RenderError(f"{checkout} lacks its submodules; run {update}")


def other_submodules(checkout):
    """"name (commit instead of commit)" for each submodule that is not at its pinned commit."""
    found = []
    for line in git(checkout, "ls-tree", "-r", "HEAD").splitlines():
        mode, _, pinned, path = line.split(None, 3)
        if mode != "160000":
            continue
        # Without a .git of its own, git would answer for the folder above.
        own = git(checkout / path, "rev-parse", "HEAD") if (checkout / path / ".git").exists() else "unknown"
        if own != pinned:
            found.append(f"{Path(path).name} ({own[:8]} instead of {pinned[:8]})")
    return found


# ---- Stand-ins for large files

def table_text(name, declaration, rows):
    return (f"#include <pbrt/util/{name}.h>\nnamespace pbrt {{\nconst {declaration} = {{" + ",\n".join(rows) + "};\n}\n")


def mask_text():
    """bluenoise.cpp: void-and-cluster masks of libbn."""
    import bluenoise

    rows = []
    for seed in range(MASK_COUNT):
        ranks = bluenoise.mask((MASK_SIZE, MASK_SIZE), seed=seed).astype(np.int64)
        values = (ranks * 65536 + 32768) // ranks.size
        rows.append("{" + ",\n".join("{" + ",".join(map(str, row)) + "}" for row in values) + "}")
    return table_text("bluenoise", "uint16_t BlueNoiseTextures[NumBlueNoiseTextures][BlueNoiseResolution][BlueNoiseResolution]", rows)


def point_text():
    """pmj02tables.cpp: Owen-scrambled (0,2)-sequences in base 2, as integers of 32 bits."""
    import bluenoise

    sampler = bluenoise.Sampler("sobol")
    sets = [sampler.sample(0, 0, np.arange(SET_SIZE), bluenoise.domain(k), dims=2) for k in range(SET_COUNT)]
    rows = ["{" + ",\n".join(f"{{{x}u,{y}u}}" for x, y in points.tolist()) + "}"
            for points in (np.array(sets, np.float64) * 2.0**32).astype(np.uint32)]
    return table_text("pmj02tables", "uint32_t pmj02bnSamples[nPMJ02bnSets][nPMJ02bnSamples][2]", rows)


STAND_INS = {MASKS: (mask_text, "void-and-cluster masks of libbn"), POINTS: (point_text, "Owen-scrambled Sobol' points")}


def missing(checkout):
    """The large files that are missing, or pointers to a store of large files."""
    return [path for path in STAND_INS
            if not (checkout / path).is_file() or (checkout / path).read_bytes()[:8] == b"version "]


def prepare(checkout, folder):
    """Copies and patches the checkout; returns the large files replaced by stand-ins."""
    lacking = missing(checkout)

    def stand_in(copy):
        for path in lacking:
            write_text(copy / path, STAND_INS[path][0]())

    other_build.prepare(checkout, folder, PATCH, [str(STAND_IN_VERSION), COMMIT, git(checkout, "status", "--porcelain"), *lacking,
                                                  *other_submodules(checkout)],
                        [(OWN / name, "src/pbrt") for name in ("blue.h", "blue.cpp")], change=stand_in)
    return lacking


def build(checkout, jobs):
    """Built: pbrt with the sampler `blue`."""
    checkout = Path(checkout).resolve()
    check(checkout)
    folder = renderer.cache_folder() / "pbrt"
    folder.mkdir(parents=True, exist_ok=True)
    lacking, others = prepare(checkout, folder), other_submodules(checkout)
    other_build.build(folder, jobs, "pbrt-v4", OPTIONS, "pbrt_exe")
    remarks = [f"`{Path(path).name}` is missing in the checkout; {STAND_INS[path][1]} take its place." for path in lacking]
    if others:
        remarks.append(f"Submodules at other commits than pbrt's: {', '.join(others)}.")
    return Built(folder / "build" / "pbrt", tuple(remarks))
