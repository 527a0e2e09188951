# SPDX-License-Identifier: Apache-2.0
"""Builds Cycles' stand-alone program with the sampling pattern of examples/cycles, from a checkout that stays as it is.

The build is in ~/.cache/libbn/cycles ($XDG_CACHE_HOME): a copy of the checkout's files with the patch applied, and libbn. Kernels are
for this processor alone, and what the scenes do not need is left out. A second build compiles only what has changed.
"""

import hashlib
import os
import shutil
import subprocess
from pathlib import Path

from ..base.files import write_text
from ..renders.renderer import RenderError, cache_folder
from .pbrt_build import BN_OPTIONS, git, put, run_logged

ROOT = Path(__file__).resolve().parents[3]
OWN = ROOT / "examples" / "cycles"
PATCH = OWN / "cycles-v4.2.0.patch"
TAG, COMMIT = "v4.2.0", "6170e50fbd5fb8e36d71676e78c2693e58bf6c3d"
# What goes to src/kernel/sample.
SAMPLE = (OWN / "blue.h", ROOT / "libbn" / "include" / "bn" / "bn_draw.glsl", ROOT / "libbn" / "include" / "bn" / "bn_path.glsl")
OFF = ("ALEMBIC", "EMBREE", "OPENCOLORIO", "OPENIMAGEDENOISE", "OPENSUBDIV", "OPENVDB", "NANOVDB", "OSL", "USD", "DEVICE_CUDA",
       "DEVICE_OPTIX", "DEVICE_HIP", "HYDRA_RENDER_DELEGATE")
OPTIONS = ("-DCMAKE_BUILD_TYPE=Release", "-DWITH_CYCLES_NATIVE_ONLY=ON", *(f"-DWITH_CYCLES_{name}=OFF" for name in OFF))
# For measuring alone, (file, text, what it becomes). With the variable BN_COUNTS the program's one picture is the samples of each pixel,
# which adaptive sampling chooses; with BN_TOLD patterns are told that many samples, as a preview tells them, whatever is taken.
CHANGES = (
    ("src/app/cycles_standalone.cpp", "pass->set_type(PASS_COMBINED);",
     'pass->set_type(getenv("BN_COUNTS") ? PASS_SAMPLE_COUNT : PASS_COMBINED);'),
    ("src/session/session.cpp", "set_aa_samples(params.samples);",
     'set_aa_samples(getenv("BN_TOLD") ? atoi(getenv("BN_TOLD")) : params.samples);'),
)


def check(checkout):
    """Raises RenderError unless `checkout` is Cycles at TAG."""
    if not (checkout / "src" / "kernel" / "sample" / "pattern.h").is_file():
        raise RenderError(f"{checkout} is no checkout of Cycles; run git clone --branch {TAG} https://github.com/blender/cycles")
    found = git(checkout, "rev-parse", "HEAD")
    if found != COMMIT:
        raise RenderError(f"{checkout} is at commit {found[:8]}; run git -C {checkout} checkout {TAG}")


def prepare(checkout, folder):
    """Copies the checkout's files to folder/src, without its folders for precompiled libraries, and applies the patch."""
    stamp = hashlib.sha256("\n".join([COMMIT, git(checkout, "diff", "HEAD", "--", "src"), *(word for change in CHANGES for word in change),
                                      PATCH.read_text(encoding="utf-8")]).encode()).hexdigest()
    source, stamp_file = folder / "src", folder / "src.sha256"
    if not stamp_file.is_file() or stamp_file.read_text() != stamp:
        new = folder / "src.new"
        shutil.rmtree(new, ignore_errors=True)
        shutil.copytree(checkout, new, ignore=shutil.ignore_patterns(".git", "lib"), symlinks=True, copy_function=shutil.copy2)
        # git apply works outside repositories, and would take a repository further up for one.
        done = subprocess.run(["git", "apply", PATCH], cwd=new, capture_output=True, text=True, check=False,
                              env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.resolve())})
        if done.returncode:
            raise RenderError(f"{PATCH} does not apply: {done.stderr.strip()}")
        for path, before, after in CHANGES:
            text = (new / path).read_text(encoding="utf-8")
            if text.count(before) != 1:
                raise RenderError(f"{path} has no line {before}")
            write_text(new / path, text.replace(before, after))
        shutil.rmtree(source, ignore_errors=True)
        new.rename(source)
        stamp_file.write_text(stamp)
    for path in SAMPLE:
        put(source / "src" / "kernel" / "sample" / path.name, path.read_text(encoding="utf-8"))


def build(checkout, jobs):
    """The path of Cycles with the pattern `blue`. Takes a quarter of an hour the first time."""
    checkout = Path(checkout).resolve()
    check(checkout)
    folder = cache_folder() / "cycles"
    folder.mkdir(parents=True, exist_ok=True)
    prepare(checkout, folder)
    libbn, prefix, cycles = folder / "libbn", folder / "prefix", folder / "build"
    for what, source, target, options, targets in (
            ("libbn", ROOT, libbn, (*BN_OPTIONS, f"-DCMAKE_INSTALL_PREFIX={prefix}"), ("--target", "install")),
            ("Cycles, about a quarter of an hour the first time", folder / "src", cycles, (*OPTIONS, f"-DCMAKE_PREFIX_PATH={prefix}"),
             ("--target", "cycles"))):
        cache = target / "CMakeCache.txt"
        # CMake refuses the cache of sources that have moved.
        if cache.is_file() and f"CMAKE_HOME_DIRECTORY:INTERNAL={source}\n" not in cache.read_text(encoding="utf-8"):
            shutil.rmtree(target)
        generator = ("-G", "Ninja") if not cache.is_file() and shutil.which("ninja") else ()
        run_logged(f"configuring {what.split(',')[0]}", folder / "log", "cmake", "-S", str(source), "-B", str(target), *generator,
                   *options)
        run_logged(f"building {what}", folder / "log", "cmake", "--build", str(target), "--parallel", str(jobs), *targets)
    return cycles / "bin" / "cycles"
