# SPDX-License-Identifier: Apache-2.0
"""Tests the command line: bad input gives one clear error line and no file, and outputs never overwrite inputs."""

import os
import pty
import resource
import shlex
import signal
import stat
import subprocess
import time

import pytest
from pathtracer_driver import SAMPLERS, SCENES
from scene_files import floor

HUGE = ["--size", "8192x8192", "--spp", 1000000]  # would take days
TINY = ["--size", "8x8", "--spp", 1]


def test_help_and_list(pathtracer):
    text, listing = (pathtracer.success(option) for option in ("--help", "--list"))
    assert text.stderr == listing.stderr == ""
    # The help explains every option in BAD_ARGUMENTS that exists.
    for option in {word for word in BAD_ARGUMENTS.replace(",", " ").split() if word.startswith("--") and word != "--fast"}:
        assert option in text.stdout, option
    assert {*SCENES, *SAMPLERS} <= {*listing.stdout.split()}


BAD_ARGUMENTS = """
    --scene teapot                               | teapot, cornell
    --sampler pink                               | pink, blue, sobol, white, zorder, mask
    --spp 0                                      | --spp, '0', 1
    --spp ''                                     | --spp, ''
    --spp                                        | --spp, value
    --spp 4x4                                    | --spp, '4x4'
    --size 0x64                                  | --size, '0x64'
    --size 1000000x1000000                       | --size, 65536
    --size 64                                    | --size, '64'
    --size 65536x65536                           | --crop
    --seed 18446744073709551616                  | --seed, 18446744073709551615
    --threads 100000                             | --threads, 1024
    --max-depth -1                               | --max-depth
    --max-memory much                            | --max-memory takes GIB: numbers
    --first-sample 4294967295 --spp 2            | --first-sample, 4294967295
    --draw-offset 1                              | --draw-offset takes, '1'
    --draw-offset 1,2000000000                   | 1073741824
    --filter tent                                | box or gaussian, 'tent'
    --light-samples 0                            | --light-samples, 256
    --light-samples 2 --first-sample 3000000000  | --first-sample, --light-samples 2
    --env absent.exr                             | absent.exr
    --exposure nan                               | --exposure, 'nan'
    --crop 0,0,0,10                              | --crop takes
    --crop 0,5,10,3                              | --crop takes
    --crop 0,0,10,10 --size 9x20                 | --crop, 9x20
    --crop 0,0,9,21 --size 9x20                  | --crop, 9x20
    --fast                                       | --fast, --help
    scene.glb                                    | scene.glb, --help
    --scene a.obj                                | a.obj, scripts/to-gltf a.obj
    --merge                                      | --merge
    --merge absent.exr                           | absent.exr
    --scene --size 512x512                       | --scene needs a value, '--size'
    --eye 1,2,3 --target 1,2,3                   | --eye, --target, 1,2,3
    --eye 278,273,0                              | --eye, --target, 278,273,0
    --eye 1,2,3,4                                | --eye, '1,2,3,4'
    --eye 1,nan,3                                | --eye, '1,nan,3'
    --target 1e16,0,0                            | --target, 1e+15
    --fov 0                                      | --fov, '0'
    --fov 180                                    | --fov, '180'
    --camera 1                                   | no camera 1
    --noise 1.5                                  | --noise takes
    --min-spp 8                                  | --noise
    --visible-noise 300                          | --visible-noise takes
    --visible-noise 1 --noise 0.1                | leave out one
    --visible-noise 1 --spp 3                    | --min-spp 4 is more than --spp 3
    --visible-noise 1 --exposure auto            | --visible-noise needs a fixed exposure, --exposure EV
    --visible-noise 1 --first-sample 4           | --visible-noise needs, leave out --first-sample
    --noise 0.1 --min-spp 1                      | --min-spp takes
    --noise 0.1 --spp 8                          | --min-spp 16 is more than --spp 8
    --noise 0.1 --scene a.gltf                   | --exposure EV
"""


@pytest.mark.parametrize("row", BAD_ARGUMENTS.strip().splitlines())
def test_bad_arguments(pathtracer, row):
    arguments, said = row.split(" | ")
    pathtracer.failure(*shlex.split(arguments), said=said.split(", "), timeout=20)


@pytest.fixture
def folder(pathtracer):
    """Input files of every type, links to some of them, and folders and links that cannot be output files."""
    folder = pathtracer.folder
    for name in ("part", "sky", "preview"):
        pathtracer.success(*TINY, "-o", f"{name}.exr")
    (folder / "preview.exr").rename(folder / "part-as.png")
    floor().save(folder / "scene.glb").rename(folder / "scene.exr")
    for name in ("deep", "folder.exr", "folder.png"):
        (folder / name).mkdir()
    links = {"scene.glb": "scene.exr", "soft.exr": "deep/../part.exr", "to-own.exr": "to-own.png", "loop.exr": "loop.exr",
             "ring.png": "ring.png", "around": "around"}  # fmt: skip
    for name, target in links.items():
        (folder / name).symlink_to(target)
    os.link(folder / "part.exr", folder / "hard.exr")
    return folder


@pytest.mark.parametrize(("arguments", "said"), [
    # The output or its preview would overwrite an input or the output itself
    (["--merge", "part.exr", "-o", "part.exr"], ["-o", "part.exr"]),
    (["--merge", "part.exr", "-o", "deep/../part.exr"], ["-o", "part.exr"]),
    (["--merge", "hard.exr", "-o", "soft.exr"], ["-o", "hard.exr", "soft.exr"]),
    (["--env", "sky.exr", "-o", "sky.exr"], ["-o", "sky.exr"]), (["--scene", "scene.glb", "-o", "scene.exr"], ["-o", "scene.glb"]),
    (["--merge", "part-as.png", "-o", "part-as.exr"], ["preview of -o", "part-as.png"]),
    (["--resume", "part-as.png", "--spp", 2, "-o", "part-as.exr"], ["preview of -o", "part-as.png"]),
    (["-o", "to-own.exr"], ["-o", "preview", "to-own.png"]),
    # The output cannot be written
    (["-o", "loop.exr"], ["loop", "symbolic links"]), (["-o", "ring.exr"], ["ring", "symbolic links"]),
    (["-o", "around/out.exr"], ["around", "symbolic links"]), (["-o", "absent/out.exr"], ["absent/out.exr", "No such file"]),
    (["-o", "part.exr/out.exr"], ["part.exr/out.exr", "Not a directory"]),
    *((["-o", "folder.exr"], [f"folder.{kind}", "regular"]) for kind in ("exr", "png")),
    (["-o", "out.png"], ["out.png", ".exr"]), (["-o", ""], ["-o"])])
def test_invalid_outputs_are_refused_before_rendering(pathtracer, folder, arguments, said):
    if "folder.png" in said:
        (folder / "folder.exr").rmdir()
    files = [p for p in folder.iterdir() if p.is_file()]
    before = [p.read_bytes() for p in files]
    pathtracer.failure(*HUGE, *arguments, said=said, timeout=20)
    assert [p.read_bytes() for p in files] == before


def test_output_to_a_link_writes_the_target(pathtracer):
    (pathtracer.folder / "deep").mkdir()
    link = pathtracer.folder / "link.exr"
    link.symlink_to("deep/target.exr")
    pathtracer.success(*TINY, "-o", link)
    assert link.is_symlink() and (pathtracer.folder / "deep/target.exr").stat().st_size > 0


def test_temporary_files_have_unpredictable_names(pathtracer):
    """Links that another user creates under names predicted from the process ID are not followed."""
    victim = pathtracer.folder / "victim"
    victim.write_text("precious")

    def prepare():
        for name in ("out.exr", "out.png"):
            os.symlink("victim", f"{name}.part-{os.getpid()}")
        os.umask(0o027)

    pathtracer.success(*TINY, "-o", "out.exr", preexec_fn=prepare)
    assert victim.read_text() == "precious"
    for name in ("out.exr", "out.png"):
        assert (pathtracer.folder / name).lstat().st_mode == stat.S_IFREG | 0o640


def test_a_full_disk_leaves_the_old_file(pathtracer):
    """A limit on file sizes simulates a full disk: the last bytes cannot be written."""
    old = pathtracer.render(*TINY)
    before = old.read_bytes()
    limit = lambda: [signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))]
    pathtracer.failure("--size", "128x128", "--spp", 1, "-o", old, said=[str(old), "cannot write"], preexec_fn=limit, timeout=20)
    assert old.read_bytes() == before


def test_no_progress_is_printed_to_a_pipe(pathtracer):
    loud, quiet = (pathtracer.success(*TINY, *more, "-o", "out.exr") for more in ([], ["--quiet"]))
    assert loud.stderr == "" and loud.stdout.count("\n") == 1 and "rays/s" in loud.stdout
    assert quiet.stderr == "" and quiet.stdout == ""
    assert sorted(os.listdir(pathtracer.folder)) == ["out.exr", "out.png"]


def test_progress_is_printed_to_a_terminal(pathtracer):
    try:
        leader, follower = pty.openpty()
    except OSError as error:
        pytest.skip(f"cannot open a pseudo-terminal: {error}")
    shown, short = b"", ["--size", "128x128", "--spp", 16, "--threads", 1, "-o", "out.exr"]
    with pathtracer.start(*short, stderr=follower, stdout=subprocess.DEVNULL) as program:
        os.close(follower)
        while b"100.0%" not in shown:
            shown += os.read(leader, 4096)
        os.close(leader)
        assert program.wait(timeout=60) == 0
    assert b"s left" in shown and b"rays/s" in shown


def test_a_second_interrupt_ends_the_program_at_once(pathtracer):
    """The first interrupt waits for the current block to finish, the second does not. Blocks take longer as sample counts grow."""
    for seconds in 3 * (0.3, 0.6, 1, 2, 4):
        program = pathtracer.interrupt(signal.SIGTERM, "--size", "8x8", "--spp", 2**24, "-o", "out.exr", seconds=seconds)
        time.sleep(0.02)
        program.send_signal(signal.SIGTERM)
        if program.wait(timeout=60) == -signal.SIGTERM:
            return
    raise AssertionError("the second interrupt did not end the program at once")
