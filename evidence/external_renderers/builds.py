# SPDX-License-Identifier: Apache-2.0
"""Builds other people's renderers with libbn's sampler, from checkouts that stay as they are.

A build is in ~/.cache/libbn/NAME ($XDG_CACHE_HOME): a copy of the checkout's files with the patch of examples/NAME applied, and libbn.
pbrt-v4 is built for the processor alone and without a window; of Cycles the stand-alone program, with kernels for this processor alone and
without what the scenes do not need.
"""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from ..base.cache import cache_folder
from ..base.files import write_text
from ..renders.renderer import RenderError

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = ROOT / "libbn" / "include" / "bn"
BN_OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DBN_BUILD_SHARED=OFF", "-DBN_BUILD_TESTS=OFF", "-DBN_BUILD_PATHTRACER=OFF",
              "-DBN_BUILD_PYTHON=OFF", "-DBN_NEURAL=OFF")


def git(checkout, *arguments):
    try:
        return subprocess.run(["git", "-C", checkout, *arguments], check=True, capture_output=True, text=True).stdout.strip()
    except OSError as error:
        raise RenderError(f"cannot run git ({error.strerror})") from None
    except subprocess.CalledProcessError as error:
        raise RenderError(f"{checkout}: {error.stderr.strip().splitlines()[-1]}") from None


def check(checkout, name, marker, commit, clone, update):
    """Raises RenderError unless `checkout` has the file `marker` and is at the commit; clone, update: commands that help."""
    if not (checkout / marker).is_file():
        raise RenderError(f"{checkout} is no checkout of {name}; run {clone}")
    found = git(checkout, "rev-parse", "HEAD")
    if found != commit:
        raise RenderError(f"{checkout} is at commit {found[:8]}; run {update}")


def prepare(checkout, name, patch, depends, own, change, ignored=()):
    """The folder of a build, whose src has the checkout's files, copied again if `depends` (texts) or the patch changed.

    own: (file, folder in the copy) of files of ours; change(copy) makes further changes; ignored: names that are not copied.
    """
    folder = cache_folder() / name
    source, stamp_file = folder / "src", folder / "src.sha256"
    stamp = hashlib.sha256("\n".join([*depends, patch.read_text(encoding="utf-8")]).encode()).hexdigest()
    if not stamp_file.is_file() or stamp_file.read_text() != stamp:
        shutil.rmtree(source, ignore_errors=True)
        stamp_file.unlink(missing_ok=True)
        shutil.copytree(checkout, source, ignore=shutil.ignore_patterns(".git", *ignored), symlinks=True, copy_function=shutil.copy)
        # git apply works outside repositories, and would take a repository further up for one.
        done = subprocess.run(["git", "apply", patch], cwd=source, capture_output=True, text=True, check=False,
                              env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.resolve())})
        if done.returncode:
            raise RenderError(f"{patch} does not apply: {done.stderr.strip()}")
        change(source)
        stamp_file.write_text(stamp)
    for path, place in own:
        text, there = path.read_text(encoding="utf-8"), source / place / path.name
        if not there.is_file() or there.read_text(encoding="utf-8") != text:  # so that only what has changed is compiled
            write_text(there, text)
    return folder


def run_logged(what, log, *command):
    """Runs a build step. Raises RenderError with the end of what it wrote, which is in the log."""
    print(f"bench: {what}", file=sys.stderr, flush=True)
    try:
        with open(log, "w", encoding="utf-8") as out:
            code = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, check=False).returncode
    except OSError as error:
        raise RenderError(f"cannot run {command[0]} ({error.strerror}); run scripts/setup") from None
    if code:
        lines = log.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
        raise RenderError(f"{what} failed; see {log}. It ends with:\n{''.join(lines[-20:])}")


def build(folder, jobs, name, options, target):
    """Builds libbn and, with it, the target of folder/src in folder/build. Takes a quarter of an hour the first time."""
    prefix, log = folder / "prefix", folder / "log"
    for what, source, place, chosen, targets in (
            ("libbn", ROOT, folder / "libbn", (*BN_OPTIONS, f"-DCMAKE_INSTALL_PREFIX={prefix}"), "install"),
            (f"{name}, about a quarter of an hour the first time; {log} grows", folder / "src", folder / "build",
             (*options, f"-DCMAKE_PREFIX_PATH={prefix}"), target)):
        cache = place / "CMakeCache.txt"
        # CMake refuses the cache of sources that have moved.
        if cache.is_file() and f"CMAKE_HOME_DIRECTORY:INTERNAL={source}\n" not in cache.read_text(encoding="utf-8"):
            shutil.rmtree(place)
        generator = ("-G", "Ninja") if not cache.is_file() and shutil.which("ninja") else ()
        run_logged(f"configuring {what.split(',')[0]}", log, "cmake", "-S", str(source), "-B", str(place), *generator, *chosen)
        run_logged(f"building {what}", log, "cmake", "--build", str(place), "--parallel", str(jobs), "--target", targets)
    return folder / "build"


# ---- Cycles

CYCLES = ROOT / "examples" / "cycles"
CYCLES_PATCH = CYCLES / "cycles.patch"
CYCLES_OFF = ("ALEMBIC", "EMBREE", "OPENCOLORIO", "OPENIMAGEDENOISE", "OPENSUBDIV", "OPENVDB", "NANOVDB", "OSL", "USD", "DEVICE_CUDA",
              "DEVICE_OPTIX", "DEVICE_HIP", "HYDRA_RENDER_DELEGATE")
CYCLES_OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DWITH_CYCLES_NATIVE_ONLY=ON", *(f"-DWITH_CYCLES_{name}=OFF" for name in CYCLES_OFF))
# For measuring alone, (file, text, what it becomes). With the variable BN_COUNTS the program's one picture is the samples of each pixel,
# which adaptive sampling chooses; with BN_TOLD patterns are told that many samples, as a preview tells them, whatever is taken.
CYCLES_CHANGES = (
    ("src/app/cycles_standalone.cpp", "pass->set_type(PASS_COMBINED);",
     'pass->set_type(getenv("BN_COUNTS") ? PASS_SAMPLE_COUNT : PASS_COMBINED);'),
    ("src/session/session.cpp", "set_aa_samples(params.samples);",
     'set_aa_samples(getenv("BN_TOLD") ? atoi(getenv("BN_TOLD")) : params.samples);'),
)


def change_cycles(copy):
    for path, before, after in CYCLES_CHANGES:
        text = (copy / path).read_text(encoding="utf-8")
        if text.count(before) != 1:
            raise RenderError(f"{path} has no line {before}")
        write_text(copy / path, text.replace(before, after))


def cycles(checkout, jobs):
    """The path of Cycles with the pattern `blue`. Raises RenderError unless the patch applies to `checkout`."""
    checkout = Path(checkout).resolve()
    done = subprocess.run([ROOT / "scripts" / "patches", "cycles", checkout], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RenderError(f"{checkout} is no checkout of Cycles that takes the patch; {(done.stdout or done.stderr).strip()}")
    depends = [git(checkout, "rev-parse", "HEAD"), git(checkout, "diff", "HEAD", "--", "src"), *(word for words in CYCLES_CHANGES for word in words)]
    own = [(path, "src/kernel/sample") for path in (CYCLES / "blue.h", INCLUDE / "bn_draw.glsl", INCLUDE / "bn_path.glsl")]
    # The folder lib has precompiled libraries.
    folder = prepare(checkout, "cycles", CYCLES_PATCH, depends, own, change_cycles, ("lib",))
    return build(folder, jobs, "Cycles", CYCLES_OPTIONS, "cycles") / "bin" / "cycles"


# ---- pbrt-v4

PBRT = ROOT / "examples" / "pbrt"
PBRT_PATCH = PBRT / "pbrt-v4.patch"
PBRT_COMMIT = "5f7a606806a4ac7b939131ded9d7a30ebd02416e"
PBRT_OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF",
                # For submodules whose CMake files are older than CMake 3.5, and a copy without .git
                "-DCMAKE_POLICY_VERSION_MINIMUM=3.5", "-DCMAKE_DISABLE_FIND_PACKAGE_Git=ON",
                "-DCMAKE_CUDA_COMPILER=", f"-DCMAKE_MODULE_PATH={PBRT / 'headless'}", "-DGLFW_BUILD_X11=OFF", "-DGLFW_BUILD_WAYLAND=OFF")
MASK_COUNT, MASK_SIZE, SET_COUNT, SET_SIZE = 48, 128, 5, 65536
STAND_IN_VERSION = 1


def table_text(name, declaration, values):
    rows = ["{" + ",\n".join("{" + ",".join(map(str, row)) + "}" for row in part.tolist()) + "}" for part in values]
    return (f"#include <pbrt/util/{name}.h>\nnamespace pbrt {{\nconst {declaration} = {{" + ",\n".join(rows) + "};\n}\n")


def mask_text():
    """bluenoise.cpp: void-and-cluster masks of libbn."""
    import bluenoise

    masks = (bluenoise.mask((MASK_SIZE, MASK_SIZE), seed=seed).astype(np.int64) for seed in range(MASK_COUNT))
    return table_text("bluenoise", "uint16_t BlueNoiseTextures[NumBlueNoiseTextures][BlueNoiseResolution][BlueNoiseResolution]",
                      ((ranks * 65536 + 32768) // ranks.size for ranks in masks))


def point_text():
    """pmj02tables.cpp: Owen-scrambled (0,2)-sequences in base 2, as integers of 32 bits."""
    import bluenoise

    sampler = bluenoise.Sampler("sobol")
    sets = [sampler.sample(0, 0, np.arange(SET_SIZE), bluenoise.domain(k), dims=2) for k in range(SET_COUNT)]
    return table_text("pmj02tables", "uint32_t pmj02bnSamples[nPMJ02bnSets][nPMJ02bnSamples][2]",
                      (np.array(sets, np.float64) * 2.0**32).astype(np.uint32))


# Large files of pbrt that a checkout may lack, and what takes their place.
STAND_INS = {"src/pbrt/util/bluenoise.cpp": (mask_text, "void-and-cluster masks of libbn"),
             "src/pbrt/util/pmj02tables.cpp": (point_text, "Owen-scrambled Sobol' points")}


def other_submodules(checkout):
    """"name (commit instead of commit)" for each submodule that is not at its pinned commit."""
    found = []
    for line in git(checkout, "ls-tree", "-r", "HEAD").splitlines():
        mode, _, pinned, path = line.split(None, 3)
        # Without a .git of its own, git would answer for the folder above.
        if mode == "160000":
            own = git(checkout / path, "rev-parse", "HEAD") if (checkout / path / ".git").exists() else "unknown"
            if own != pinned:
                found.append(f"{Path(path).name} ({own[:8]} instead of {pinned[:8]})")
    return found


def pbrt(checkout, jobs):
    """(the path of pbrt with the sampler `blue`, sentences on what differs from the pinned sources). Raises RenderError unless `checkout`
    is pbrt-v4 at PBRT_COMMIT, with submodules."""
    checkout = Path(checkout).resolve()
    update = f"git -C {checkout} submodule update --init --recursive"
    check(checkout, "pbrt-v4", "src/pbrt/samplers.h", PBRT_COMMIT, "git clone --recursive https://github.com/mmp/pbrt-v4",
          f"git -C {checkout} checkout {PBRT_COMMIT} && {update}")
    if not (checkout / "src" / "ext" / "ptex" / "CMakeLists.txt").is_file():
        raise RenderError(f"{checkout} lacks its submodules; run {update}")
    # Missing, or a pointer to a store of large files.
    lacking = [path for path in STAND_INS if not (checkout / path).is_file() or (checkout / path).read_bytes()[:8] == b"version "]

    def stand_in(copy):
        for path in lacking:
            write_text(copy / path, STAND_INS[path][0]())

    others = other_submodules(checkout)
    folder = prepare(checkout, "pbrt", PBRT_PATCH, [
        str(STAND_IN_VERSION), PBRT_COMMIT, git(checkout, "status", "--porcelain"), *lacking, *others],
        [(PBRT / name, "src/pbrt") for name in ("blue.h", "blue.cpp")], stand_in)
    remarks = [f"`{Path(path).name}` is missing in the checkout; {STAND_INS[path][1]} take its place." for path in lacking]
    if others:
        remarks.append(f"Submodules at other commits than pbrt's: {', '.join(others)}.")
    return build(folder, jobs, "pbrt-v4", PBRT_OPTIONS, "pbrt_exe") / "pbrt", remarks
