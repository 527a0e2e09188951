# SPDX-License-Identifier: Apache-2.0
"""Builds pbrt-v4 with the sampler of examples/pbrt, from a checkout that stays as it is.

The build is in ~/.cache/libbn/pbrt ($XDG_CACHE_HOME): a copy of the checkout's files with the patch applied, and libbn,
both built for the processor alone and without a window. A second build compiles only what has changed.
"""

import dataclasses
import filecmp
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from ..base.files import write_text
from ..renders.renderer import RenderError, cache_folder

ROOT = Path(__file__).resolve().parents[3]
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
BN_OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DBN_BUILD_SHARED=OFF", "-DBN_BUILD_TESTS=OFF", "-DBN_BUILD_PATHTRACER=OFF",
              "-DBN_BUILD_PYTHON=OFF", "-DBN_NEURAL=OFF")


@dataclasses.dataclass(frozen=True)
class Built:
    """program: the path of pbrt. remarks: what differs from the pinned sources, in sentences."""

    program: Path
    remarks: tuple


def git(checkout, *arguments):
    try:
        return subprocess.run(["git", "-C", checkout, *arguments], check=True, capture_output=True, text=True).stdout.strip()
    except OSError as error:
        raise RenderError(f"cannot run git ({error.strerror})") from None
    except subprocess.CalledProcessError as error:
        raise RenderError(f"{checkout}: {error.stderr.strip().splitlines()[-1]}") from None


def check(checkout):
    """Raises RenderError unless `checkout` is pbrt-v4 at COMMIT, with submodules."""
    if not (checkout / "src" / "pbrt" / "samplers.h").is_file():
        raise RenderError(f"{checkout} is no checkout of pbrt-v4; run git clone --recursive https://github.com/mmp/pbrt-v4")
    found = git(checkout, "rev-parse", "HEAD")
    if found != COMMIT:
        raise RenderError(f"{checkout} is at commit {found[:8]}; run git -C {checkout} checkout {COMMIT} && "
                          f"git -C {checkout} submodule update --init --recursive")
    if not (checkout / "src" / "ext" / "ptex" / "CMakeLists.txt").is_file():
        raise RenderError(f"{checkout} lacks its submodules; run git -C {checkout} submodule update --init --recursive")


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

def mask_text():
    """bluenoise.cpp: void-and-cluster masks of libbn."""
    import bluenoise

    rows = []
    for seed in range(MASK_COUNT):
        ranks = bluenoise.mask((MASK_SIZE, MASK_SIZE), seed=seed).astype(np.int64)
        values = (ranks * 65536 + 32768) // ranks.size
        rows.append("{" + ",\n".join("{" + ",".join(map(str, row)) + "}" for row in values) + "}")
    return ("#include <pbrt/util/bluenoise.h>\nnamespace pbrt {\nconst uint16_t BlueNoiseTextures[NumBlueNoiseTextures]"
            "[BlueNoiseResolution][BlueNoiseResolution] = {" + ",\n".join(rows) + "};\n}\n")


def point_sets():
    """SET_COUNT Owen-scrambled (0,2)-sequences in base 2, (SET_COUNT, SET_SIZE, 2), as integers of 32 bits."""
    import bluenoise

    sampler = bluenoise.Sampler("sobol")
    sets = [sampler.sample(0, 0, np.arange(SET_SIZE), bluenoise.domain(k), dims=2) for k in range(SET_COUNT)]
    return (np.array(sets, np.float64) * 2.0**32).astype(np.uint32)


def point_text():
    """pmj02tables.cpp"""
    rows = ["{" + ",\n".join(f"{{{x}u,{y}u}}" for x, y in points.tolist()) + "}" for points in point_sets()]
    return ("#include <pbrt/util/pmj02tables.h>\nnamespace pbrt {\nconst uint32_t pmj02bnSamples[nPMJ02bnSets]"
            "[nPMJ02bnSamples][2] = {" + ",\n".join(rows) + "};\n}\n")


STAND_INS = {MASKS: (mask_text, "void-and-cluster masks of libbn"), POINTS: (point_text, "Owen-scrambled Sobol' points")}


def missing(checkout):
    """The large files that are missing, or pointers to a store of large files."""
    return [path for path in STAND_INS
            if not (checkout / path).is_file() or (checkout / path).read_bytes()[:8] == b"version "]


# ---- Building

def put(path, text):
    """Writes text unless it is there, so that only what has changed is compiled."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        write_text(path, text)


def put_own(source):
    for name in ("blue.h", "blue.cpp"):
        put(source / "src" / "pbrt" / name, (OWN / name).read_text(encoding="utf-8"))


def prepare(checkout, folder):
    """Copies the checkout's files to folder/src and applies the patch; returns the large files replaced by stand-ins."""
    lacking = missing(checkout)
    stamp = hashlib.sha256("\n".join([str(STAND_IN_VERSION), COMMIT, git(checkout, "status", "--porcelain"), *lacking,
                                      *other_submodules(checkout), PATCH.read_text(encoding="utf-8")]).encode()).hexdigest()
    source, stamp_file = folder / "src", folder / "src.sha256"
    if not stamp_file.is_file() or stamp_file.read_text() != stamp:
        new = folder / "src.new"
        shutil.rmtree(new, ignore_errors=True)
        shutil.copytree(checkout, new, ignore=shutil.ignore_patterns(".git"), symlinks=True, copy_function=shutil.copy)
        for path in lacking:
            write_text(new / path, STAND_INS[path][0]())
        # git apply works outside repositories, and would take a repository further up for one.
        done = subprocess.run(["git", "apply", PATCH], cwd=new, capture_output=True, text=True, check=False,
                              env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.resolve())})
        if done.returncode:
            raise RenderError(f"{PATCH} does not apply: {done.stderr.strip()}")
        put_own(new)
        # What is the same keeps its time and is not compiled again.
        for path in new.rglob("*"):
            old = source / path.relative_to(new)
            if path.is_file() and old.is_file() and filecmp.cmp(path, old, shallow=False):
                shutil.copystat(old, path)
        shutil.rmtree(source, ignore_errors=True)
        new.rename(source)
        stamp_file.write_text(stamp)
    put_own(source)
    return lacking


def run_logged(what, log, *command):
    """Runs a build step; on a terminal shows its latest line. Raises RenderError with the end of the log."""
    shown, lines = sys.stderr.isatty(), []
    print(f"bench: {what}", file=sys.stderr, flush=True)
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True,
                                   errors="replace")
    except OSError as error:
        raise RenderError(f"cannot run {command[0]} ({error.strerror}); run scripts/setup") from None
    with process:
        for line in process.stdout:
            lines.append(line)
            if shown:
                print(f"\r{line.strip()[:100]}\033[K", end="", file=sys.stderr, flush=True)
    if shown:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    log.write_text("".join(lines))
    if process.returncode:
        raise RenderError(f"{what} failed; see {log}. It ends with:\n{''.join(lines[-20:])}")


def build(checkout, jobs):
    """Built: pbrt with the sampler `blue`. Takes a quarter of an hour the first time."""
    checkout = Path(checkout).resolve()
    check(checkout)
    folder = cache_folder() / "pbrt"
    folder.mkdir(parents=True, exist_ok=True)
    lacking = prepare(checkout, folder)
    libbn, prefix, pbrt = folder / "libbn", folder / "prefix", folder / "build"
    # Configured again only if CMake's files changed, but with these options every time.
    for what, source, target, options, targets in (
            ("libbn", ROOT, libbn, (*BN_OPTIONS, f"-DCMAKE_INSTALL_PREFIX={prefix}"), ("--target", "install")),
            ("pbrt-v4, about a quarter of an hour the first time", folder / "src", pbrt,
             (*OPTIONS, f"-DCMAKE_PREFIX_PATH={prefix}"), ("--target", "pbrt_exe"))):
        cache = target / "CMakeCache.txt"
        # CMake refuses the cache of sources that have moved.
        if cache.is_file() and f"CMAKE_HOME_DIRECTORY:INTERNAL={source}\n" not in cache.read_text(encoding="utf-8"):
            shutil.rmtree(target)
        new = not cache.is_file()
        generator = ("-G", "Ninja") if new and shutil.which("ninja") else ()
        run_logged(f"configuring {what.split(',')[0]}", folder / "log", "cmake", "-S", str(source), "-B", str(target), *generator,
                   *options)
        run_logged(f"building {what}", folder / "log", "cmake", "--build", str(target), "--parallel", str(jobs), *targets)
    remarks = [f"`{Path(path).name}` is missing in the checkout; {STAND_INS[path][1]} take its place." for path in lacking]
    others = other_submodules(checkout)
    if others:
        remarks.append(f"Submodules at other commits than pbrt's: {', '.join(others)}.")
    return Built(pbrt / "pbrt", tuple(remarks))
