# SPDX-License-Identifier: Apache-2.0
"""Tests images in parts: merging regions and sample ranges, resuming stopped images, and checking that the input files are the same."""

import shutil
import signal
import subprocess
import zlib

import numpy as np
import OpenEXR
import pytest
from pathtracer_driver import assert_near, assert_same, read_exr, read_layers
from scene_files import ONE, Gltf, add_floor, encoded, floor, over_floor, room, write_environment

SIZE = ["--size", "45x37"]
PENUMBRA = ["--scene", "penumbra", "--max-depth", 1, "--min-spp", 4, "--exposure", 1]
ADAPTIVE = [*PENUMBRA, "--noise", 0.1]
VISIBLE = [*PENUMBRA, "--sampler", "white", "--visible-noise", 1.2]


def assert_same_attributes(path, wanted, but):
    header, other = ({**read_exr(file)[1], "channels": None} for file in (path, wanted))
    assert {name for name in header.keys() | other.keys() if not np.array_equal(header.get(name), other.get(name))} <= but


@pytest.mark.parametrize("options", [["--spp", 6], [*ADAPTIVE, "--spp", 64], [*VISIBLE, "--spp", 50]])
def test_merged_regions_are_bit_identical_to_the_whole_image(pathtracer, options):
    """This includes regions that cut through blocks of adaptive sampling."""
    parts = [pathtracer.render(*SIZE, *options, "--crop", crop) for crop in ("0,0,20,37", "20,0,45,11", "20,11,45,37")]
    # Files store variances in single precision.
    assert_same(pathtracer.layers("--merge", *parts), pathtracer.layers(*SIZE, *options), variance=1e-6)


def test_merged_sample_ranges_equal_the_whole_image(pathtracer):
    """Ranges may have different lengths, be in any order, and be merged images themselves."""
    common = ["--scene", "lens", *SIZE, "--seed", 3]
    whole = pathtracer.render(*common, "--spp", 11)
    a, b, c = (pathtracer.render(*common, "--first-sample", f, "--spp", n) for f, n in ((7, 4), (0, 1), (1, 6)))
    for parts in ((a, b, c), (pathtracer.render("--merge", b, c), a)):
        merged = pathtracer.render("--merge", *parts)
        assert_near(read_layers(merged), read_layers(whole))
        assert_same_attributes(merged, whole, {"seconds", "threads", "exposure"})


def test_pixels_that_no_part_contains_stay_empty(pathtracer):
    path = pathtracer.render("--merge", *(pathtracer.render(*SIZE, "--spp", 2, "--crop", c) for c in ("0,0,10,10", "20,20,30,30")))
    layers = read_layers(path)
    count = layers["count"]
    assert [*map(list, read_exr(path)[1]["dataWindow"])] == [[0, 0], [29, 29]]
    assert (count[:10, :10] == 2).all() and (count[20:, 20:] == 2).all() and count.sum() == 2 * 200
    assert all((values[count == 0] == 0).all() for values in layers.values())


def test_parts_that_overlap_or_leave_gaps_are_refused(pathtracer):
    part = lambda first, count, *more: pathtracer.render(*SIZE, "--sampler", "white", "--first-sample", first, "--spp", count, *more)
    left, right = ("--crop", "0,0,20,37"), ("--crop", "20,0,45,37")
    a, b, c = part(0, 2), part(2, 3), part(5, 1)
    assert (pathtracer.layers("--merge", c, a, b)["count"] == 6).all()
    for parts, said in [
        ([a, part(0, 2)], ["same samples"]), ([a, part(1, 2)], ["same samples"]), ([a, part(2, 2, "--size", "37x45")], ["size"]),
        ([c, a], ["samples 2 to 4 ", c.name, "--first-sample 2 --spp 3"]),
        # A gap in only some pixels also counts, as do regions that start at different samples.
        ([a, part(2, 3, *left), c], ["samples 2 to 4 of pixel 20,0"]),
        ([part(0, 2, *left), part(1, 2, *right)], ["samples 0 to 0 of pixel 20,0"]),
        ([write_environment(pathtracer.folder / "other.exr", 0)], ["other.exr", "this program"]),
    ]:
        pathtracer.failure("--merge", *parts, said=said)


def rewritten(path, name, value):
    """Returns a copy of an image with one attribute changed."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        file.header()[name] = value
        file.write(str(path.with_name("copy.exr")))
    return path.with_name("copy.exr")


def test_parts_with_different_settings_are_refused(pathtracer):
    """An image that differs in any setting is not a part of the same image. Statistics may differ but must be valid."""
    common = [*SIZE, "--noise", 0.3, "--min-spp", 2, "--spp", 4, "--exposure", 0]
    first, second = (pathtracer.render(*common, "--crop", crop) for crop in ("0,0,16,37", "16,0,45,37"))
    # Parts of an image may differ in statistics. All other text attributes are settings.
    statistics = {"spp", "firstSample", "endSample", "exposure", "threads", "seconds", "rays", "software", "name", "type"}
    settings = {name: value for name, value in read_exr(second)[1].items() if isinstance(value, str) and name not in statistics}
    assert set(settings) >= {"scene", "camera", "env", "sampler", "draws", "inputs", "declare", "seed", "max-depth",
                             "light-samples", "photometric", "clamp", "noise", "visible-noise", "min-spp", "noise-exposure"}  # fmt: skip
    pathtracer.success("--merge", first, rewritten(second, "seconds", "1"), "-o", pathtracer.render(*ONE))
    for name, value in settings.items():
        pathtracer.failure("--merge", first, rewritten(second, name, value + "x"), said=["not parts of one image", "copy.exr"])
    for name, value, said in [
        ("seconds", "nan", "seconds"), ("exposure", "inf", "exposure"), ("rays", "-1", "rays"), ("spp", "2x", "spp"),
        ("firstSample", "9", "firstSample"), ("endSample", "1", "more samples than its attributes say"),
    ]:
        pathtracer.failure("--merge", rewritten(second, name, value), said=[said, "copy.exr"])


def test_a_resumed_image_equals_an_uninterrupted_one(pathtracer):
    common = ["--scene", "lens", *SIZE, "--seed", 5, "--sampler", "sobol", "--max-depth", 3]
    resumed = pathtracer.render("--resume", pathtracer.render(*common, "--spp", 3), "--spp", 11)
    whole = pathtracer.render(*common, "--spp", 11)
    assert_near(read_layers(resumed), read_layers(whole))
    assert_same_attributes(resumed, whole, {"seconds"})


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP, signal.SIGTERM])
def test_interrupts_write_the_image_so_far(pathtracer, number):
    """Pixels of an interrupted image differ in sample count. When it is resumed without --spp, all reach the highest count."""
    common = ["--size", "96x64", "--crop", "3,5,90,60", "--fov", 30, "--max-depth", 2]
    begun = pathtracer.folder / "begun.exr"
    for _ in range(20):
        program = pathtracer.interrupt(number, *common, "--spp", 1000000, "-o", begun, stderr=subprocess.PIPE, text=True)
        message = program.communicate(timeout=60)[1]
        assert program.returncode == 128 + number
        assert message.count("\n") == 1 and "begun.exr has the image so far" in message
        assert sorted(path.name for path in pathtracer.folder.iterdir()) == ["begun.exr", "begun.png"]
        count = read_layers(begun)["count"]
        least, most = int(count.min()), int(count.max())
        assert 1 <= least and most <= 2 * least + 1
        if least < most:
            break
    assert least < most
    rest = pathtracer.render(*common, "--first-sample", most, "--spp", 2)
    pathtracer.failure("--merge", begun, rest, said=[f"samples {least} to {most - 1}", "--resume"])
    assert_near(pathtracer.layers("--resume", begun), pathtracer.layers(*common, "--spp", most))
    pathtracer.success("--resume", begun, "-o", begun)  # in place
    assert (read_layers(begun)["count"] == most).all()


@pytest.mark.parametrize("rule", [ADAPTIVE, VISIBLE])
@pytest.mark.parametrize("spp", [6, 24])  # between two counts at which blocks may stop; at 24, some blocks have little noise
@pytest.mark.parametrize("crop", [[], ["--crop", "5,9,21,30"]])
def test_adaptive_images_can_be_resumed(pathtracer, rule, spp, crop):
    """This includes a crop that cuts through blocks, for which the pixels around it are rendered too."""
    common = [*rule, *SIZE, *crop]
    begun = pathtracer.render(*common, "--spp", spp)
    whole = pathtracer.layers(*common, "--spp", 64)
    assert_near(whole, pathtracer.layers("--resume", begun, "--spp", 64))
    assert len(np.unique(whole["count"])) > 1 and ("noise" in whole) == (rule is VISIBLE)
    for change in ([rule[-2], 0.2], [rule[-2], 0], ["--min-spp", 2], ["--exposure", 0]):
        pathtracer.failure("--resume", begun, "--spp", 128, *change, said="not an earlier state")


def test_resuming_with_different_settings_is_refused(pathtracer):
    begun = pathtracer.render(*SIZE, "--spp", 2, "--crop", "0,0,20,20", "--first-sample", 4)
    for name, *changed in [
        ("seed", "--seed", 1), ("sampler", "--sampler", "sobol"), ("scene", "--scene", "furnace"), ("max-depth", "--max-depth", 3),
        ("light-samples", "--light-samples", 2), ("declare", "--declare", 4), ("camera", "--fov", 20), ("size", "--size", "40x40"),
        ("env", "--env", "sky"), ("draw-offset", "--draw-offset", "1,-2"), ("filter", "--filter", "gaussian"),
        ("first-sample", "--first-sample", 0), ("crop", "--crop", "0,0,20,19"),
        ("already", "--spp", 2), ("already", "--spp", 1), ("--merge", "--merge", begun), ("--first-sample", "--noise", 0.1),
    ]:
        pathtracer.failure("--resume", begun, "--spp", 8, *changed, said=name)
    pathtracer.failure("--resume", begun, said=["already", begun.name])
    pathtracer.failure("--resume", "absent.exr", said="absent.exr")


def test_a_resumed_image_keeps_its_camera(pathtracer):
    """This includes a numbered camera that lies on its side, which --eye, --target and --fov cannot express."""
    g = over_floor(floor())
    g.camera(0.9, translation=[0.2, 0.5, 2], rotation=[0, 0, np.sqrt(0.5), np.sqrt(0.5)], name="on its side")
    # The room's centre is not the origin.
    for scene, more in ((g, ["--camera", 1]), (g, ["--camera", 1, "--eye", "0.3,0.7,1.9", "--target", "0,0,0"]), (room(), [])):
        begun, whole = (pathtracer.render("--scene", scene, *more, *ONE, "--spp", spp) for spp in (1, 3))
        assert_near(pathtracer.layers("--resume", begun, "--spp", 3), read_layers(whole))


@pytest.fixture
def scene(pathtracer):
    """Returns arguments and the files they refer to."""
    folder, g = pathtracer.folder, Gltf()
    (folder / "sub").mkdir()
    for uri in ("sub/wood.png", "bump%20map.png", "\u00e9.png", "per%25cent.png"):
        add_floor(g, pbr={"baseColorTexture": {"index": g.add("textures", source=g.add("images", uri=uri))}})
    names = ["sub/wood.png", "bump map.png", "\u00e9.png", "per%cent.png"]
    for name in names:
        (folder / name).write_bytes(encoded(np.full((4, 4, 3), 200)))
    text = g.text(uri="my mesh.bin")
    (folder / "scene.gltf").write_text(text.replace("sub/wood", "sub\\/wood").replace("my mesh", "my\\u0020mesh"))
    (folder / "my mesh.bin").write_bytes(g.bytes)
    write_environment(folder / "sky.exr", 1.0)
    return ["--scene", "scene.gltf", "--env", "sky.exr", *ONE], ["scene.gltf", "my mesh.bin", "sky.exr", *names]


def test_images_with_changed_input_files_are_refused(pathtracer, scene):
    """--list-inputs lists exactly the files that are read. If one is removed, loading fails or the list changes."""
    folder, (options, names) = pathtracer.folder, scene
    names = sorted(names, key=str.encode)
    listed = pathtracer.success(*options, "--list-inputs").stdout
    data = [(folder / name).read_bytes() for name in names]
    assert listed.splitlines(keepends=True) == [f"{zlib.crc32(d):08x}-{len(d)}  {name}\n" for d, name in zip(data, names)]
    before = pathtracer.render(*options)
    assert read_exr(before)[1]["inputs"] == listed
    for name, old in zip(names, data):
        (folder / name).unlink()
        done = pathtracer.run(*options, "--list-inputs")
        # A missing texture only causes a warning.
        assert name not in done.stdout and done.returncode == (not name.endswith(".png"))
        (folder / name).write_bytes(old + b"\n ")
        after = pathtracer.render(*options, "--first-sample", 1)
        pathtracer.failure("--merge", before, after, said=[before.name, after.name, name])
        pathtracer.failure("--resume", before, "--spp", 2, said=name)
        (folder / name).write_bytes(old)
    # Input files may be read from another folder.
    pathtracer.folder = shutil.copytree(folder, folder / "other")
    after = pathtracer.render(*options, "--first-sample", 1)
    pathtracer.success("--merge", before, after, "-o", "whole.exr")
    # Control characters in an image's list of inputs do not reach the terminal.
    before.write_bytes(before.read_bytes().replace(b"  sub/wood.png\n", b"  \x1b[31mwoo.png\n", 1))
    pathtracer.failure("--merge", after, before, said="?[31mwoo.png")
