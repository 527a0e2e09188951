# SPDX-License-Identifier: Apache-2.0
"""Outputs never destroy an input, and appear together or not at all."""

import os
import stat
import subprocess

import pytest
from scene_files import floor

SIZE = ["--size", "8x8", "--spp", 1]


@pytest.fixture
def inputs(pathtracer):
    """One file of each kind that a run reads, with other names for some of them."""
    folder = pathtracer.folder
    for name in ("part", "sky", "preview"):
        pathtracer.run(*SIZE, "-o", f"{name}.exr")
    (folder / "preview.exr").rename(folder / "part-as.png")
    floor().save(folder / "scene.glb")
    (folder / "scene.glb").rename(folder / "scene.exr")
    (folder / "scene.glb").symlink_to("scene.exr")
    (folder / "deep").mkdir()
    (folder / "soft.exr").symlink_to("deep/../part.exr")
    (folder / "to-own.exr").symlink_to("to-own.png")
    os.link(folder / "part.exr", folder / "hard.exr")
    return folder


@pytest.mark.parametrize(("arguments", "said"), [
    (["--merge", "part.exr", "-o", "part.exr"], ["-o", "part.exr"]),
    (["--merge", "part.exr", "-o", "deep/../part.exr"], ["-o", "part.exr"]),
    (["--merge", "part.exr", "-o", "soft.exr"], ["-o", "part.exr", "soft.exr"]),
    (["--merge", "hard.exr", "-o", "soft.exr"], ["-o", "hard.exr", "soft.exr"]),
    (["--env", "sky.exr", "-o", "sky.exr"], ["-o", "sky.exr"]),
    (["--scene", "scene.glb", "-o", "scene.exr"], ["-o", "scene.glb"]),
    (["--merge", "part-as.png", "-o", "part-as.exr"], ["preview of -o", "part-as.png"]),
    (["--resume", "part-as.png", "--spp", 2, "-o", "part-as.exr"], ["preview of -o", "part-as.png"]),
    (["-o", "to-own.exr"], ["-o", "preview", "to-own.png"])])
def test_an_output_that_is_another_file_of_the_run_is_refused(pathtracer, inputs, arguments, said):
    files = [p for p in inputs.iterdir() if p.is_file()]
    before = [p.read_bytes() for p in files]
    pathtracer.failure(*SIZE, *arguments, said=said)
    assert [p.read_bytes() for p in files] == before


@pytest.mark.parametrize("loop", ["loop.exr", "loop.png", "folder/out.exr"])
def test_a_loop_of_links_is_refused(pathtracer, loop):
    (pathtracer.folder / loop.partition("/")[0]).symlink_to(loop.partition("/")[0])
    pathtracer.failure(*SIZE, "-o", loop.replace(".png", ".exr"), said=[loop.partition(".")[0], "symbolic links"])


def test_a_link_keeps_its_target(pathtracer):
    (pathtracer.folder / "deep").mkdir()
    link = pathtracer.folder / "link.exr"
    link.symlink_to("deep/target.exr")
    assert pathtracer.run(*SIZE, "-o", link).returncode == 0
    assert link.is_symlink() and (pathtracer.folder / "deep/target.exr").stat().st_size > 0


def test_temporary_files_have_random_names(pathtracer):
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


@pytest.mark.parametrize("arguments", [["--list"], [*SIZE, "-o", "out.exr"]])
def test_full_standard_output_is_an_error(arguments, pathtracer):
    """Standard output is full. The images are written all the same."""
    with open("/dev/full", "wb") as full:
        done = subprocess.run([pathtracer.binary, *map(str, arguments)], cwd=pathtracer.folder, stdout=full,
                              stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr == "pathtracer: cannot write to standard output: No space left on device\n"
    if "-o" in arguments:
        assert pathtracer.run("--merge", "out.exr", "-o", "whole.exr").returncode == 0
