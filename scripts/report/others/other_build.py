# SPDX-License-Identifier: Apache-2.0
"""Builds other people's renderers with libbn's sampler, from a checkout that stays as it is.

The build is in ~/.cache/libbn/NAME ($XDG_CACHE_HOME): a copy of the checkout's files with the patch of examples/NAME applied, and
libbn. A second build compiles only what has changed.
"""

import filecmp
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

from ..base.files import write_text
from ..renders.renderer import RenderError

ROOT = Path(__file__).resolve().parents[3]
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


def put(path, text):
    """Writes text unless it is there, so that only what has changed is compiled."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        write_text(path, text)


def prepare(checkout, folder, patch, depends, own, ignored=(), change=lambda copy: None):
    """Copies the checkout's files to folder/src, again if `depends` (texts) or the patch change, and applies the patch.

    own: (file, folder in the copy) of files of ours; ignored: names that are not copied; change(copy) makes further changes.
    """
    stamp = hashlib.sha256("\n".join([*depends, patch.read_text(encoding="utf-8")]).encode()).hexdigest()
    source, stamp_file = folder / "src", folder / "src.sha256"
    if not stamp_file.is_file() or stamp_file.read_text() != stamp:
        new = folder / "src.new"
        shutil.rmtree(new, ignore_errors=True)
        shutil.copytree(checkout, new, ignore=shutil.ignore_patterns(".git", *ignored), symlinks=True, copy_function=shutil.copy)
        # git apply works outside repositories, and would take a repository further up for one.
        done = subprocess.run(["git", "apply", patch], cwd=new, capture_output=True, text=True, check=False,
                              env={**os.environ, "GIT_CEILING_DIRECTORIES": str(folder.resolve())})
        if done.returncode:
            raise RenderError(f"{patch} does not apply: {done.stderr.strip()}")
        change(new)
        for path, place in own:
            put(new / place / path.name, path.read_text(encoding="utf-8"))
        # What is the same keeps its time and is not compiled again.
        for path in new.rglob("*"):
            old = source / path.relative_to(new)
            if path.is_file() and old.is_file() and filecmp.cmp(path, old, shallow=False):
                shutil.copystat(old, path)
        shutil.rmtree(source, ignore_errors=True)
        new.rename(source)
        stamp_file.write_text(stamp)
    for path, place in own:
        put(source / place / path.name, path.read_text(encoding="utf-8"))


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


def build(folder, jobs, name, options, target):
    """Builds libbn and, with it, the target of folder/src in folder/build. Takes a quarter of an hour the first time."""
    prefix = folder / "prefix"
    for what, source, place, chosen, targets in (
            ("libbn", ROOT, folder / "libbn", (*BN_OPTIONS, f"-DCMAKE_INSTALL_PREFIX={prefix}"), "install"),
            (f"{name}, about a quarter of an hour the first time", folder / "src", folder / "build",
             (*options, f"-DCMAKE_PREFIX_PATH={prefix}"), target)):
        cache = place / "CMakeCache.txt"
        # CMake refuses the cache of sources that have moved.
        if cache.is_file() and f"CMAKE_HOME_DIRECTORY:INTERNAL={source}\n" not in cache.read_text(encoding="utf-8"):
            shutil.rmtree(place)
        generator = ("-G", "Ninja") if not cache.is_file() and shutil.which("ninja") else ()
        run_logged(f"configuring {what.split(',')[0]}", folder / "log", "cmake", "-S", str(source), "-B", str(place), *generator, *chosen)
        run_logged(f"building {what}", folder / "log", "cmake", "--build", str(place), "--parallel", str(jobs), "--target", targets)
