# SPDX-License-Identifier: Apache-2.0
"""Pictures that were stopped and gone on with, and parts that leave out samples."""

import signal
import subprocess
import time

import numpy as np
import pytest
from pathtracer_driver import assert_near, read_exr, read_layers
from PIL import Image
from scene_files import DOWN, SMALL, floor

SIZE = ["--size", "45x37"]


def stopped(pathtracer, *arguments):
    """A picture that was interrupted on the way, with uneven counts if it can be had."""
    path = pathtracer.folder / "stopped.exr"
    for attempt in range(20):
        program = pathtracer.start(*arguments, "--spp", 100000, "--quiet", "-o", path, stderr=subprocess.DEVNULL)
        time.sleep(0.3 + 0.05 * attempt)
        program.send_signal(signal.SIGINT)
        assert program.wait(timeout=60) == 128 + signal.SIGINT
        count = read_layers(path)["count"]
        if count.min() < count.max():
            break
    return path, count


@pytest.mark.parametrize("scene", ["cornell", "lens"])
def test_a_resumed_picture_equals_a_whole_one(pathtracer, scene):
    common = ["--scene", scene, *SIZE, "--seed", 5, "--sampler", "sobol", "--max-depth", 3]
    begun = pathtracer.render(*common, "--spp", 3)
    resumed = pathtracer.render("--resume", begun, "--spp", 11)
    whole = pathtracer.render(*common, "--spp", 11)
    assert_near(read_layers(resumed), read_layers(whole))
    header, wanted = read_exr(resumed)[1], read_exr(whole)[1]
    for name, value in wanted.items():
        if name not in ("seconds", "samplingShare", "channels"):
            assert np.array_equal(header[name], value), name


def test_a_stopped_picture_becomes_even(pathtracer):
    common = ["--size", "96x64", "--crop", "3,5,90,60", "--fov", 30, "--max-depth", 2]
    begun, count = stopped(pathtracer, *common)
    assert count.min() < count.max()
    most = int(count.max())
    even = pathtracer.render("--resume", begun)
    assert (read_layers(even)["count"] == most).all()
    assert_near(read_layers(even), read_layers(pathtracer.render(*common, "--spp", most)))
    # In place, and with a limit of time.
    pathtracer.success("--resume", begun, "--time", 0.001, "-o", begun)
    later = read_layers(begun)["count"]
    assert later.min() == later.max() and later.max() >= most


def test_what_is_not_the_same_picture_is_refused(pathtracer):
    common = [*SIZE, "--spp", 2]
    begun = pathtracer.render(*common, "--crop", "0,0,20,20", "--first-sample", 4)
    out = ["-o", "out.exr"]
    for name, changed in [
        ("seed", ["--seed", 1]),
        ("sampler", ["--sampler", "sobol"]),
        ("scene", ["--scene", "furnace"]),
        ("max depth", ["--max-depth", 3]),
        ("light samples", ["--light-samples", 2]),
        ("light samples", ["--lights", "coin"]),
        ("declared", ["--declare", 4]),
        ("camera", ["--fov", 20]),
        ("--size", ["--size", "40x40"]),
        ("--size", ["--size", "8x8"]),
        ("single scatter", ["--single-scatter"]),
        ("environment", ["--env", "sky"]),
        ("first sample", ["--first-sample", 0]),
        ("crop", ["--crop", "0,0,20,19"]),
    ]:
        pathtracer.failure("--resume", begun, "--spp", 8, *changed, *out, said=[name, begun.name])
    assert "already" in pathtracer.failure("--resume", begun, "--spp", 2, *out)
    assert "already" in pathtracer.failure("--resume", begun, "--spp", 1, *out)
    assert "already" in pathtracer.failure("--resume", begun, *out)
    assert "absent.exr" in pathtracer.failure("--resume", "absent.exr", *out)
    assert "--merge" in pathtracer.failure("--resume", begun, "--merge", begun, *out)


def test_a_camera_of_a_file_is_kept(pathtracer):
    """Also one by number that stands on its head, which --eye, --target and --fov do not say."""
    g = floor()
    g.camera(0.5, translation=[0, 1, 0], rotation=DOWN)
    half = np.sqrt(0.5)
    g.camera(0.9, translation=[0.2, 0.5, 2], rotation=[0, 0, half, half], name="on its side")
    path = g.save(pathtracer.folder / "two.glb")
    common = ["--scene", path, *SMALL, "--camera", 1]
    begun = pathtracer.render(*common, "--spp", 1)
    assert_near(read_layers(pathtracer.render("--resume", begun, "--spp", 3)), read_layers(pathtracer.render(*common, "--spp", 3)))
    moved = [*common, "--eye", "0.3,0.7,1.9", "--target", "0,0,0"]
    begun = pathtracer.render(*moved, "--spp", 1)
    assert_near(read_layers(pathtracer.render("--resume", begun, "--spp", 3)), read_layers(pathtracer.render(*moved, "--spp", 3)))


def test_merge_refuses_gaps(pathtracer):
    common = [*SIZE, "--sampler", "white"]
    part = lambda first, count, *more: pathtracer.render(*common, "--first-sample", first, "--spp", count, *more)
    a, c = part(0, 2), part(5, 1)
    message = pathtracer.failure("--merge", c, a, "-o", "out.exr")
    assert "samples 2 to 4 " in message and c.name in message and "--first-sample 2 --spp 3" in message
    assert (read_layers(pathtracer.render("--merge", c, a, part(2, 3)))["count"] == 6).all()
    # A gap in some pixels is one.
    left = part(2, 3, "--crop", "0,0,20,37")
    message = pathtracer.failure("--merge", a, left, c, "-o", "out.exr")
    assert "samples 2 to 4 of pixel 20,0" in message
    # So are regions that begin at other samples.
    right = part(1, 2, "--crop", "20,0,45,37")
    message = pathtracer.failure("--merge", part(0, 2, "--crop", "0,0,20,37"), right, "-o", "out.exr")
    assert "samples 0 to 0 of pixel 20,0" in message


def test_merge_refuses_what_an_interruption_left_out(pathtracer):
    common = ["--size", "96x64", "--max-depth", 1]
    begun, count = stopped(pathtracer, *common)
    assert count.min() < count.max()
    most = int(count.max())
    rest = pathtracer.render(*common, "--first-sample", most, "--spp", 2)
    message = pathtracer.failure("--merge", begun, rest, "-o", "out.exr")
    assert f"samples {int(count.min())} to {most - 1}" in message and "--resume" in message
    merged = pathtracer.render("--merge", pathtracer.render("--resume", begun), rest)
    assert (read_layers(merged)["count"] == most + 2).all()


def test_a_damaged_picture_is_refused_or_gone_on_with(pathtracer):
    """Whatever bit of its header or its pixels has turned over: one line, or a picture."""
    begun, rest = (pathtracer.render("--size", "8x8", "--spp", 1, "--first-sample", n) for n in (0, 1))
    whole = begun.read_bytes()
    rng = np.random.default_rng(2)
    refused = 0
    for i in range(60):
        damaged = bytearray(whole)
        damaged[rng.integers(8, 1800 if i % 3 else len(whole))] ^= 1 << rng.integers(8)
        begun.write_bytes(damaged)
        for mode in (["--resume", begun, "--spp", 2], ["--merge", begun, rest]):
            done = pathtracer.run(*mode, "-o", "out.exr")
            assert done.returncode in (0, 1), done.stderr
            if done.returncode == 1:
                refused += 1
                assert done.stderr.startswith("pathtracer: ") and done.stderr.count("\n") == 1
                assert not (pathtracer.folder / "out.exr").exists()
            (pathtracer.folder / "out.exr").unlink(missing_ok=True)
    assert refused > 40


def test_files_that_a_picture_names_are_read_below_its_folder_only(pathtracer, even_sky):
    """The picture may be a stranger's."""
    folder = pathtracer.folder
    floor().save(folder / "scene.glb")
    Image.fromarray(np.arange(64, dtype=np.uint8).reshape(8, 8)).save(folder / "mask.png")
    (folder / "theirs").mkdir()
    (folder / "theirs" / "sky.exr").symlink_to("../even.exr")
    for option, file in [("--scene", "scene.glb"), ("--env", even_sky.name), ("--mask", "mask.png"),
                         ("--env", "theirs/sky.exr"), ("--env", even_sky), ("--env", "theirs/../even.exr")]:
        settings = [*SMALL, "--sampler", "mask", option, file]
        begun = folder / "theirs" / "begun.exr"
        pathtracer.success(*settings, "--spp", 1, "-o", begun)
        again = ["--resume", "theirs/begun.exr", "--spp", 2, "-o", "out.exr"]
        said = [str(file), "outside the picture's folder", f"name it with {option}", "--allow-outside"]
        pathtracer.failure(*again, said=said)
        for more in (["--allow-outside"], [option, file]):
            pathtracer.success(*again, *more)
        begun.rename(folder / "begun.exr")
        pathtracer.success("--resume", "begun.exr", "--spp", 2, "-o", "out.exr")
        for name in ("out.exr", "out.png"):
            (folder / name).unlink()


@pytest.mark.parametrize("name", ["seconds", "samplingShare", "exposure"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -1])
def test_attributes_that_no_picture_has_are_refused(pathtracer, name, value):
    begun = pathtracer.render("--size", "8x8", "--spp", 1)
    data = begun.read_bytes()
    at = data.index(f"{name}\0float\0".encode()) + len(name) + 11
    begun.write_bytes(data[:at] + np.float32(value).tobytes() + data[at + 4:])
    if name == "exposure" and value == -1:
        return
    pathtracer.failure("--resume", begun, "--spp", 2, "-o", "out.exr", said=[name, begun.name])
    assert name in pathtracer.failure("--merge", begun, "-o", "out.exr")


def test_a_terminal_that_closes_leaves_the_picture_so_far(pathtracer):
    endless = ["--size", "64x64", "--spp", 1000000, "--quiet", "-o", "out.exr"]
    program = pathtracer.start(*endless, stderr=subprocess.PIPE, text=True)
    time.sleep(1)
    program.send_signal(signal.SIGHUP)
    message = program.communicate(timeout=60)[1]
    assert program.returncode == 128 + signal.SIGHUP and "picture so far" in message
    assert read_layers(pathtracer.folder / "out.exr")["count"].min() > 0
