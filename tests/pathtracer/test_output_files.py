# SPDX-License-Identifier: Apache-2.0
"""Outputs never destroy an input, and appear together or not at all."""

import os
import shutil
import signal
import stat
import subprocess

import numpy as np
import pytest
from pathtracer_driver import read_exr
from scene_files import floor

SIZE = ["--size", "8x8", "--spp", 1]


@pytest.fixture
def inputs(pathtracer):
    """One file of each kind that a run reads, with other names for some of them."""
    folder = pathtracer.folder
    for name in ("ref", "sky", "preview"):
        pathtracer.run(*SIZE, "-o", f"{name}.exr")
    (folder / "preview.exr").rename(folder / "part-as.png")
    (folder / "preview.png").rename(folder / "mk.png")
    floor().save(folder / "scene.glb")
    (folder / "scene.glb").rename(folder / "scene.exr")
    (folder / "scene.glb").symlink_to("scene.exr")
    (folder / "deep").mkdir()
    (folder / "soft.exr").symlink_to("deep/../ref.exr")
    (folder / "to-own.exr").symlink_to("to-own.png")
    os.link(folder / "ref.exr", folder / "hard.exr")
    return folder


@pytest.mark.parametrize(("arguments", "said"), [
    (["--reference", "ref.exr", "-o", "ref.exr"], ["-o", "--reference", "ref.exr"]),
    (["--reference", "ref.exr", "-o", "deep/../ref.exr"], ["-o", "--reference", "ref.exr"]),
    (["--reference", "ref.exr", "-o", "soft.exr"], ["-o", "--reference", "ref.exr", "soft.exr"]),
    (["--reference", "hard.exr", "-o", "soft.exr"], ["-o", "--reference", "hard.exr", "soft.exr"]),
    (["--sampler", "mask", "--mask", "mk.png", "-o", "mk.exr"], ["preview of -o", "--mask", "mk.png"]),
    (["--env", "sky.exr", "-o", "sky.exr"], ["-o", "--env", "sky.exr"]),
    (["--scene", "scene.glb", "-o", "scene.exr"], ["-o", "--scene", "scene.glb"]),
    (["--merge", "ref.exr", "-o", "ref.exr"], ["-o", "--merge", "ref.exr"]),
    (["--merge", "part-as.png", "-o", "part-as.exr"], ["preview of -o", "--merge", "part-as.png"]),
    (["--resume", "part-as.png", "-o", "part-as.exr"], ["preview of -o", "--resume", "part-as.png"]),
    # Names of files that do not exist yet
    (["-o", "to-own.exr"], ["-o", "preview of -o", "to-own.png"]),
    (["--env", "absent.exr", "-o", "absent.exr"], ["-o", "--env", "absent.exr"]),
])
def test_an_output_that_is_another_file_of_the_run_is_refused(pathtracer, inputs, arguments, said):
    files = [p for p in inputs.iterdir() if p.is_file()]
    before = [p.read_bytes() for p in files]
    pathtracer.failure(*SIZE, *arguments, said=said)
    assert [p.read_bytes() for p in files] == before


@pytest.mark.parametrize("loop", ["loop.exr", "loop.png", "folder/out.exr"])
def test_a_loop_of_links_is_refused(pathtracer, loop):
    (pathtracer.folder / loop.partition("/")[0]).symlink_to(loop.partition("/")[0])
    pathtracer.failure(*SIZE, "-o", loop.replace(".png", ".exr"), said=[loop, "symbolic links"])


def test_temporary_files_have_names_that_nobody_knows(pathtracer):
    """Another user of the folder prepares links under the names that a process number gives away."""
    victim = pathtracer.folder / "victim"
    victim.write_text("precious")

    def prepare():
        for name in ("out.exr", "out.png"):
            os.symlink("victim", f"{name}.part-{os.getpid()}")

        os.umask(0o027)

    assert pathtracer.run(*SIZE, "-o", "out.exr", preexec_fn=prepare).returncode == 0
    assert victim.read_text() == "precious"
    for name in ("out.exr", "out.png"):
        assert (pathtracer.folder / name).lstat().st_mode == stat.S_IFREG | 0o640


@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
@pytest.mark.parametrize("way", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_killed_merge_leaves_no_temporary_file(pathtracer, way):
    """The signal comes while the first file is written."""
    if pathtracer.has_address_sanitizer:
        pytest.skip("the address sanitizer must be the first library that is loaded")
    part = pathtracer.render(*SIZE)
    source, library = pathtracer.folder / "killed.c", pathtracer.folder / "killed.so"
    source.write_text(f"#include <signal.h>\nint fsync(int file) {{ raise({way}); return 0; }}\n")
    subprocess.run(["cc", "-shared", "-fPIC", source, "-o", library], check=True)
    before = sorted(os.listdir(pathtracer.folder))
    done = pathtracer.run("--merge", part, "-o", "out.exr", env={**os.environ, "LD_PRELOAD": str(library)},
                          preexec_fn=lambda: signal.signal(getattr(signal, way), signal.SIG_DFL))
    assert done.returncode == -getattr(signal, way)
    assert sorted(os.listdir(pathtracer.folder)) == sorted([*before, "out.exr", "out.png"])


@pytest.mark.parametrize("arguments", [["--list"], ["--help"], ["--list-cameras"], [*SIZE, "-o", "out.exr"],
                                       [*SIZE, "--reference", "reference.exr", "--quiet", "-o", "out.exr"]])
@pytest.mark.parametrize("closed", [False, True])
def test_text_that_does_not_arrive_is_an_error(arguments, closed, pathtracer):
    """Standard output is full or closed. The pictures are written all the same."""
    pathtracer.render(*SIZE).rename(pathtracer.folder / "reference.exr")
    with open("/dev/full", "wb") as full:
        done = subprocess.run([pathtracer.binary, *map(str, arguments)], cwd=pathtracer.folder, stdout=full, stderr=subprocess.PIPE,
                              text=True, preexec_fn=(lambda: os.close(1)) if closed else None)
    assert done.returncode == 1
    reason = "Bad file descriptor" if closed else "No space left on device"
    assert done.stderr.splitlines()[-1] == f"pathtracer: cannot write to standard output: {reason}"
    if "-o" in arguments:
        assert pathtracer.run("--merge", "out.exr", "-o", "whole.exr").returncode == 0


def test_without_standard_streams_the_picture_is_the_same(pathtracer):
    """No file of the run takes their numbers."""
    picture = pathtracer.render(*SIZE)
    assert pathtracer.run("--quiet", *SIZE, "-o", "out.exr", preexec_fn=lambda: os.closerange(0, 3)).returncode == 0
    np.testing.assert_array_equal(read_exr(picture)[0], read_exr(pathtracer.folder / "out.exr")[0])
