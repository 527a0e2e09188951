# SPDX-License-Identifier: Apache-2.0
"""Pictures that were stopped and gone on with."""

import signal
import subprocess
import time

import numpy as np
import pytest
from pathtracer_driver import assert_near, read_exr, read_layers
from scene_files import DOWN, SMALL, cornell, encoded, floor

SIZE = ["--size", "45x37"]
OUT = ["-o", "out.exr"]


def stopped(pathtracer, *arguments):
    """A picture that was interrupted on the way, with uneven counts."""
    path = pathtracer.folder / "stopped.exr"
    for attempt in range(20):
        program = pathtracer.start(*arguments, "--spp", 100000, "--quiet", "-o", path, stderr=subprocess.DEVNULL)
        time.sleep(0.3 + 0.05 * attempt)
        program.send_signal(signal.SIGINT)
        assert program.wait(timeout=60) == 128 + signal.SIGINT
        count = read_layers(path)["count"]
        if count.min() < count.max():
            return path, int(count.min()), int(count.max())
    raise AssertionError("the counts are even each time")


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
    begun, least, most = stopped(pathtracer, *common)
    rest = pathtracer.render(*common, "--first-sample", most, "--spp", 2)
    pathtracer.failure("--merge", begun, rest, *OUT, said=[f"samples {least} to {most - 1}", "--resume"])
    even = pathtracer.render("--resume", begun)
    assert (read_layers(even)["count"] == most).all()
    assert_near(read_layers(even), read_layers(pathtracer.render(*common, "--spp", most)))
    pathtracer.success("--resume", begun, "-o", begun)  # in place
    assert (read_layers(begun)["count"] == most).all()


@pytest.mark.parametrize("crop", [[], ["--crop", "5,9,21,30"]])
def test_adaptive_pictures_go_on(pathtracer, crop):
    """Of a crop that cuts through blocks too: pixels around it are drawn again."""
    common = ["--scene", "penumbra", *SIZE, "--max-depth", 1, *crop]
    noise = ["--noise", 0.1, "--min-spp", 4, "--spp", 64]
    adaptive = pathtracer.render(*common, *noise)
    whole = read_layers(adaptive)
    for begun, options in (([*noise, "--spp", 6], ["--spp", 64]),  # stopped between looks
                           ([*noise, "--noise", 0.3], ["--noise", 0.1, "--spp", 64]), (["--spp", 3], noise)):
        assert_near(whole, read_layers(pathtracer.render("--resume", pathtracer.render(*common, *begun), *options)))
    even = read_layers(pathtracer.render("--resume", adaptive, "--noise", 0))
    assert_near(read_layers(pathtracer.render(*common, "--spp", 64)), even)
    for change in (["--noise", 0.2], ["--min-spp", 2], ["--exposure", 1]):
        pathtracer.failure("--resume", adaptive, "--spp", 128, *change, *OUT, said=["not an earlier state"])
    pathtracer.failure("--resume", pathtracer.render(*common, "--spp", 5), *noise, *OUT, said=["minSpp '16' and '4'"])


def test_what_is_not_the_same_picture_is_refused(pathtracer):
    begun = pathtracer.render(*SIZE, "--spp", 2, "--crop", "0,0,20,20", "--first-sample", 4)
    for name, *changed in [
        ("seed", "--seed", 1), ("sampler", "--sampler", "sobol"), ("scene", "--scene", "furnace"), ("maxDepth", "--max-depth", 3),
        ("lightSamples", "--light-samples", 2), ("lightSamples", "--lights", "coin"), ("declaredSpp", "--declare", 4),
        ("camera", "--fov", 20), ("--size", "--size", "40x40"), ("singleScatter", "--single-scatter"),
        ("environment", "--env", "sky"), ("first sample", "--first-sample", 0), ("crop", "--crop", "0,0,20,19"),
        ("already", "--spp", 2), ("already", "--spp", 1), ("--merge", "--merge", begun), ("begins with sample 4", "--noise", 0.1),
    ]:
        pathtracer.failure("--resume", begun, "--spp", 8, *changed, *OUT, said=[name])
    pathtracer.failure("--resume", begun, *OUT, said=["already", begun.name])
    pathtracer.failure("--resume", "absent.exr", *OUT, said=["absent.exr"])


def test_a_camera_of_a_file_is_kept(pathtracer):
    """Also one by number that lies on its side, which --eye, --target and --fov do not say."""
    g = floor()
    g.camera(0.5, translation=[0, 1, 0], rotation=DOWN)
    half = np.sqrt(0.5)
    g.camera(0.9, translation=[0.2, 0.5, 2], rotation=[0, 0, half, half], name="on its side")
    two = ["--scene", g.save(pathtracer.folder / "two.glb"), "--camera", 1]
    box = ["--scene", cornell().save(pathtracer.folder / "box.glb")]  # its middle is not the origin
    for arguments in (two, [*two, "--eye", "0.3,0.7,1.9", "--target", "0,0,0"], box):
        begun, whole = (pathtracer.render(*arguments, *SMALL, "--spp", spp) for spp in (1, 3))
        assert_near(read_layers(pathtracer.render("--resume", begun, "--spp", 3)), read_layers(whole))


def test_pictures_of_changed_files_are_refused_or_mixed(pathtracer):
    mask = lambda seed: (pathtracer.folder / "mask.png").write_bytes(encoded(np.random.default_rng(seed).permutation(64).reshape(8, 8)))
    mask(1)
    common = [*SIZE, "--sampler", "mask", "--mask", "mask.png", "--spp", 1]
    before = pathtracer.render(*common)
    mask(2)
    after = pathtracer.render(*common, "--first-sample", 1)
    pathtracer.failure("--resume", before, "--spp", 2, *OUT, said=[before.name, "the contents of mask.png", "--allow-changed"])
    resumed = pathtracer.render("--resume", before, "--spp", 2, "--allow-changed")
    merged = pathtracer.render("--merge", before, after, "--allow-changed")
    assert_near(read_layers(resumed), read_layers(merged))
    assert read_exr(resumed)[1]["inputs"] == read_exr(merged)[1]["inputs"] == ""


def test_files_that_a_picture_names_are_read_below_its_folder_only(pathtracer, even_sky):
    """The picture may be a stranger's."""
    folder = pathtracer.folder
    floor().save(folder / "scene.glb")
    (folder / "theirs").mkdir()
    (folder / "theirs" / "sky.exr").symlink_to("../even.exr")
    begun = folder / "theirs" / "begun.exr"
    for option, file in [("--scene", "scene.glb"), ("--env", "theirs/sky.exr"), ("--env", even_sky), ("--env", "theirs/../even.exr")]:
        pathtracer.success(*SMALL, option, file, "--spp", 1, "-o", begun)
        again = ["--resume", "theirs/begun.exr", "--spp", 2, *OUT]
        pathtracer.failure(*again, said=[str(file), "outside the picture's folder", f"name it with {option}", "--allow-outside"])
        for more in (["--allow-outside"], [option, file]):
            pathtracer.success(*again, *more)
        begun.rename(folder / "begun.exr")
        pathtracer.success("--resume", "begun.exr", "--spp", 2, *OUT)
        for name in ("out.exr", "out.png"):
            (folder / name).unlink()
