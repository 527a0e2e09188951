# SPDX-License-Identifier: Apache-2.0
"""Images in parts: regions and ranges of samples that are merged, and images that were stopped and resumed."""

import signal
import subprocess
import time

import numpy as np
import OpenEXR
import pytest
from pathtracer_driver import assert_near, assert_same, read_exr, read_layers
from scene_files import DOWN, SMALL, floor, room, write_environment

SIZE = ["--size", "45x37"]
OUT = ["-o", "out.exr"]
ADAPTIVE = ["--scene", "penumbra", "--max-depth", 1, "--noise", 0.1, "--min-spp", 4, "--exposure", 0]


def merge(pathtracer, *parts):
    return pathtracer.render("--merge", *parts)


@pytest.mark.parametrize("options", [["--spp", 6], [*ADAPTIVE, "--spp", 64]])
def test_merged_regions_equal_the_whole_to_the_bit(pathtracer, options):
    """Also if they cut through blocks of adaptive sampling."""
    common = [*SIZE, *options]
    whole = read_layers(pathtracer.render(*common))
    crops = ["0,0,20,37", "20,0,45,11", "20,11,45,37"]
    merged = read_layers(merge(pathtracer, *(pathtracer.render(*common, "--crop", c) for c in crops)))
    assert_same(merged, whole, variance=1e-6)  # through single precision and back


def test_merged_samples_equal_the_whole(pathtracer):
    """Also ranges of different lengths, in any order, and merged before."""
    common = ["--scene", "lens", *SIZE, "--seed", 3]
    whole_path = pathtracer.render(*common, "--spp", 11)
    ranges = [(7, 4), (0, 1), (1, 6)]
    parts = [pathtracer.render(*common, "--first-sample", f, "--spp", n) for f, n in ranges]
    for path in (merge(pathtracer, *parts), merge(pathtracer, merge(pathtracer, *parts[1:]), parts[0])):
        assert_near(read_layers(path), read_layers(whole_path))
        header, expected = read_exr(path)[1], read_exr(whole_path)[1]
        for name in ("spp", "firstSample", "endSample", "rays", "seed", "scene", "sampler"):
            assert header[name] == expected[name], name


def test_parts_that_miss_pixels_leave_them_empty(pathtracer):
    parts = [pathtracer.render(*SIZE, "--spp", 2, "--crop", c) for c in ("0,0,10,10", "20,20,30,30")]
    path = merge(pathtracer, *parts)
    layers = read_layers(path)
    low, high = read_exr(path)[1]["dataWindow"]
    assert [*low, *high] == [0, 0, 29, 29]
    assert (layers["count"][:10, :10] == 2).all() and (layers["count"][20:, 20:] == 2).all()
    assert layers["count"].sum() == 2 * 200
    assert all((values[layers["count"] == 0] == 0).all() for values in layers.values())


def test_parts_that_do_not_belong_together(pathtracer):
    common = [*SIZE, "--spp", 2]
    first = pathtracer.render(*common)
    for said, *more in (("same samples",), ("same samples", "--first-sample", 1), ("size", "--first-sample", 2, "--size", "37x45")):
        pathtracer.failure("--merge", first, pathtracer.render(*common, *more), *OUT, said=[said])
    path = write_environment(pathtracer.folder / "other.exr", 0)
    pathtracer.failure("--merge", path, *OUT, said=["other.exr", "this program"])


def test_merge_refuses_gaps(pathtracer):
    common = [*SIZE, "--sampler", "white"]
    part = lambda first, count, *more: pathtracer.render(*common, "--first-sample", first, "--spp", count, *more)
    a, c = part(0, 2), part(5, 1)
    pathtracer.failure("--merge", c, a, *OUT, said=["samples 2 to 4 ", c.name, "--first-sample 2 --spp 3"])
    assert (read_layers(merge(pathtracer, c, a, part(2, 3)))["count"] == 6).all()
    # A gap in some pixels is one.
    pathtracer.failure("--merge", a, part(2, 3, "--crop", "0,0,20,37"), c, *OUT, said=["samples 2 to 4 of pixel 20,0"])
    # So are regions that begin at other samples.
    right = part(1, 2, "--crop", "20,0,45,37")
    pathtracer.failure("--merge", part(0, 2, "--crop", "0,0,20,37"), right, *OUT, said=["samples 0 to 0 of pixel 20,0"])


def rewritten(path, name, value):
    """A copy of an image with another attribute, or without any change."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {channel: np.array(c.pixels) for channel, c in file.channels().items()}
        header = {**file.header(), **({name: value} if name else {})}
        header.pop("channels", None)
        with OpenEXR.File(header, channels) as written:
            written.write(str(path.with_name("copy.exr")))
    return path.with_name("copy.exr")


@pytest.mark.parametrize(("name", "value", "said"), [
    ("seconds", "nan", "seconds"), ("exposure", "inf", "exposure"), ("rays", "-1", "rays"), ("spp", "2x", "spp"),
    ("firstSample", "9", "firstSample"), ("endSample", "1", "more samples than its attributes say")])
def test_impossible_attributes(pathtracer, name, value, said):
    begun = pathtracer.render("--size", "8x8", "--spp", 2)
    merge(pathtracer, rewritten(begun, None, None))
    pathtracer.failure("--merge", rewritten(begun, name, value), *OUT, said=[said, "copy.exr"])


# Attributes in which parts of one image may differ. All others that are texts are settings.
STATISTICS = {"spp", "firstSample", "endSample", "exposure", "threads", "seconds", "rays", "software", "name", "type"}


def test_parts_with_any_other_setting_are_refused(pathtracer):
    """Whatever setting of an image is changed, it is no part of that image any more."""
    common = [*SIZE, "--noise", 0.3, "--min-spp", 2, "--spp", 4, "--exposure", 0]
    first, second = (pathtracer.render(*common, "--crop", crop) for crop in ("0,0,16,37", "16,0,45,37"))
    merge(pathtracer, first, second)
    settings = {name: value for name, value in read_exr(second)[1].items() if isinstance(value, str) and name not in STATISTICS}
    assert set(settings) >= {"scene", "camera", "env", "sampler", "draws", "inputs", "declare", "seed", "max-depth",
                             "light-samples", "photometric", "clamp", "noise", "min-spp", "noise-exposure"}  # fmt: skip
    for name, value in settings.items():
        changed = rewritten(second, name, value + "x")
        pathtracer.failure("--merge", first, changed, *OUT, said=["not parts of one image", changed.name])


# ---- Resumed images


def stopped(pathtracer, *arguments):
    """An image that was interrupted on the way, with uneven counts."""
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


def test_a_resumed_image_equals_a_whole_one(pathtracer):
    common = ["--scene", "lens", *SIZE, "--seed", 5, "--sampler", "sobol", "--max-depth", 3]
    begun = pathtracer.render(*common, "--spp", 3)
    resumed = pathtracer.render("--resume", begun, "--spp", 11)
    whole = pathtracer.render(*common, "--spp", 11)
    assert_near(read_layers(resumed), read_layers(whole))
    header, wanted = read_exr(resumed)[1], read_exr(whole)[1]
    for name, value in wanted.items():
        if name not in ("seconds", "channels"):
            assert np.array_equal(header[name], value), name


def test_a_stopped_image_becomes_even(pathtracer):
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
def test_adaptive_images_can_be_resumed(pathtracer, crop):
    """Also of a crop that cuts through blocks: pixels around it are drawn again."""
    common = [*ADAPTIVE, *SIZE, *crop]
    whole = read_layers(pathtracer.render(*common, "--spp", 64))
    begun = pathtracer.render(*common, "--spp", 6)  # stopped between looks
    assert_near(whole, read_layers(pathtracer.render("--resume", begun, "--spp", 64)))
    for change in (["--noise", 0.2], ["--noise", 0], ["--min-spp", 2], ["--exposure", 1]):
        pathtracer.failure("--resume", begun, "--spp", 128, *change, *OUT, said=["not an earlier state"])


def test_an_image_of_other_settings_is_not_resumed(pathtracer):
    begun = pathtracer.render(*SIZE, "--spp", 2, "--crop", "0,0,20,20", "--first-sample", 4)
    for name, *changed in [
        ("seed", "--seed", 1), ("sampler", "--sampler", "sobol"), ("scene", "--scene", "furnace"), ("max-depth", "--max-depth", 3),
        ("light-samples", "--light-samples", 2), ("declare", "--declare", 4), ("camera", "--fov", 20), ("size", "--size", "40x40"),
        ("env", "--env", "sky"), ("first-sample", "--first-sample", 0), ("crop", "--crop", "0,0,20,19"),
        ("already", "--spp", 2), ("already", "--spp", 1), ("--merge", "--merge", begun), ("--first-sample", "--noise", 0.1),
    ]:
        pathtracer.failure("--resume", begun, "--spp", 8, *changed, *OUT, said=[name])
    pathtracer.failure("--resume", begun, *OUT, said=["already", begun.name])
    pathtracer.failure("--resume", "absent.exr", *OUT, said=["absent.exr"])


def test_a_resumed_image_keeps_the_camera_of_its_file(pathtracer):
    """Also one by number that lies on its side, which --eye, --target and --fov do not say."""
    g = floor()
    g.camera(0.5, translation=[0, 1, 0], rotation=DOWN)
    half = np.sqrt(0.5)
    g.camera(0.9, translation=[0.2, 0.5, 2], rotation=[0, 0, half, half], name="on its side")
    two = ["--scene", g.save(pathtracer.folder / "two.glb"), "--camera", 1]
    far = ["--scene", room().save(pathtracer.folder / "room.glb")]  # its middle is not the origin
    for arguments in (two, [*two, "--eye", "0.3,0.7,1.9", "--target", "0,0,0"], far):
        begun, whole = (pathtracer.render(*arguments, *SMALL, "--spp", spp) for spp in (1, 3))
        assert_near(read_layers(pathtracer.render("--resume", begun, "--spp", 3)), read_layers(whole))
