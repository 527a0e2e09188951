# SPDX-License-Identifier: Apache-2.0
"""The command line: what it says, and that bad input ends in one clear line and no file."""

import os
import pty
import resource
import shlex
import signal
import subprocess
import time

import numpy as np
import pytest
from pathtracer_driver import SAMPLERS, SCENES, read_exr, read_layers

HUGE = ["--size", "8192x8192", "--spp", 1000000]  # would take days


def test_help_and_list(pathtracer):
    text = pathtracer.run("--help")
    assert text.returncode == 0 and text.stderr == ""
    # Each option that a message of this file names is explained.
    for option in {word for word in BAD_ARGUMENTS.replace(",", " ").split() if word.startswith("--") and word != "--fast"}:
        assert option in text.stdout, option
    listing = pathtracer.run("--list")
    assert listing.returncode == 0 and listing.stderr == ""
    for name in (*SCENES, *SAMPLERS):
        assert name in listing.stdout.split()


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
    --max-memory much                            | --max-memory takes a number
    --declare many                               | --declare
    --first-sample 4294967295 --spp 2            | --first-sample, 4294967295
    --light-samples 0                            | --light-samples, 256
    --light-samples 2 --first-sample 3000000000  | --first-sample, --light-samples 2
    --env absent.exr                             | absent.exr
    --exposure nan                               | --exposure, 'nan'
    --crop 0,0,0,10                              | --crop
    --crop 5,0,3,10                              | --crop
    --crop 0,0,10,10 --size 9x20                 | --crop, 9x20
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
    --target 1e16,0,0                            | --target, 1e15
    --fov 0                                      | --fov, '0'
    --fov 180                                    | --fov, '180'
    --camera 1                                   | no camera 1
    --noise x                                    | --noise takes
    --noise 1.5                                  | --noise takes
    --min-spp 8                                  | --noise
    --noise 0.1 --min-spp 1                      | --min-spp takes
    --noise 0.1 --spp 8                          | --min-spp 16 is more than --spp 8
    --noise 0.1 --first-sample 4                 | leave out --first-sample
    --noise 0.1 --exposure auto                  | --exposure EV
    --noise 0.1 --scene a.gltf                   | --exposure EV
"""


@pytest.mark.parametrize("row", BAD_ARGUMENTS.strip().splitlines())
def test_bad_arguments(pathtracer, row):
    arguments, said = row.split(" | ")
    pathtracer.failure("-o", "out.exr", *shlex.split(arguments), said=said.split(", "), timeout=20)


@pytest.mark.parametrize(("output", "said"), [
    ("absent/out.exr", ["absent/out.exr", "No such file"]), ("file/out.exr", ["file/out.exr", "Not a directory"]),
    ("folder.exr", ["folder.exr", "regular"]), ("preview.exr", ["preview.png", "regular"]), ("out.png", ["out.png", ".exr"]),
    ("", ["-o"])])
def test_unwritable_output_is_found_before_rendering(pathtracer, output, said):
    (pathtracer.folder / "file").write_text("a file")
    for folder in ("folder.exr", "preview.png"):
        (pathtracer.folder / folder).mkdir()
    pathtracer.failure(*HUGE, "-o", output, said=said, timeout=20)


def test_a_full_disk_leaves_the_old_file(pathtracer):
    """A limit on file sizes takes the way of a full disk: the last bytes cannot be written."""
    old = pathtracer.render("--size", "8x8", "--spp", 1)
    before = old.read_bytes()
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
    pathtracer.failure("--size", "128x128", "--spp", 1, "-o", old, said=[str(old), "cannot write"], preexec_fn=limit, timeout=20)
    assert old.read_bytes() == before


def test_a_pipe_sees_no_progress(pathtracer):
    common = ["--size", "96x96", "--spp", 16]
    loud = pathtracer.success(*common, "-o", "out.exr")
    assert loud.stderr == "" and loud.stdout.count("\n") == 1 and "rays/s" in loud.stdout
    quiet = pathtracer.run(*common, "--quiet", "-o", "out.exr")
    assert quiet.returncode == 0 and quiet.stderr == "" and quiet.stdout == ""
    assert sorted(os.listdir(pathtracer.folder)) == ["out.exr", "out.png"]


def test_a_terminal_sees_progress(pathtracer):
    try:
        leader, follower = pty.openpty()
    except OSError as error:
        pytest.skip(f"no terminal can be had here: {error}")
    short = ["--size", "128x128", "--spp", 96, "--threads", 1, "-o", "out.exr"]
    shown = b""
    with pathtracer.start(*short, stderr=follower, stdout=subprocess.DEVNULL) as program:
        os.close(follower)
        while b"100.0 %" not in shown:
            shown += os.read(leader, 4096)
        os.close(leader)
        assert program.wait(timeout=60) == 0
    assert b"s left" in shown and b"rays/s" in shown


@pytest.mark.parametrize("way", ["SIGINT", "SIGHUP"])
def test_interrupt_writes_the_image_so_far(pathtracer, way):
    """Some samples of each pixel, which are those of a whole image of as many."""
    program = pathtracer.start("--size", "96x64", "--spp", 1000000, "--quiet", "-o", "out.exr", stderr=subprocess.PIPE, text=True)
    time.sleep(1)
    program.send_signal(getattr(signal, way))
    message = program.communicate(timeout=60)[1]
    assert program.returncode == 128 + getattr(signal, way)
    assert message.count("\n") == 1 and "interrupted; out.exr has the image so far" in message
    assert sorted(os.listdir(pathtracer.folder)) == ["out.exr", "out.png"]
    count = read_layers(pathtracer.folder / "out.exr")["count"]
    assert count.min() >= 1 and count.max() <= 2 * count.min() + 1
    part = read_exr(pathtracer.folder / "out.exr")[0][0, 0]
    whole = pathtracer.image("--size", "96x64", "--crop", "0,0,1,1", "--spp", int(count[0, 0]))[0, 0]
    assert np.array_equal(part, whole)


def test_a_second_interrupt_ends_at_once(pathtracer):
    program = pathtracer.start(*HUGE, "--sampler", "sobol", "-o", "out.exr", stderr=subprocess.DEVNULL)
    time.sleep(1.5)
    program.send_signal(signal.SIGTERM)
    time.sleep(0.05)
    program.send_signal(signal.SIGTERM)
    assert program.wait(timeout=30) in (-signal.SIGTERM, 128 + signal.SIGTERM)
    names = os.listdir(pathtracer.folder)
    assert {*names} <= {"out.exr", "out.png"}
