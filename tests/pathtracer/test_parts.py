# SPDX-License-Identifier: Apache-2.0
"""Pictures in parts: regions and ranges of samples merged, and the error against a reference."""

import numpy as np
import OpenEXR
import pytest
from pathtracer_driver import assert_near, assert_same, read_exr, read_layers
from scene_files import write_environment
from scipy.ndimage import gaussian_filter

SIZE = ["--size", "45x37"]
OUT = ["-o", "out.exr"]


def merge(pathtracer, *parts):
    return pathtracer.render("--merge", *parts)


def test_merged_regions_equal_the_whole_to_the_bit(pathtracer):
    common = [*SIZE, "--spp", 6]
    whole = read_layers(pathtracer.render(*common))
    crops = ["0,0,20,37", "20,0,45,11", "20,11,45,37"]
    merged = read_layers(merge(pathtracer, *(pathtracer.render(*common, "--crop", c) for c in crops)))
    assert_same(merged, whole, variance=1e-6)  # through single precision and back


@pytest.mark.parametrize("scene", ["cornell", "lens"])
def test_merged_samples_equal_the_whole(pathtracer, scene):
    """Also ranges of different lengths, in any order, and merged before."""
    common = ["--scene", scene, *SIZE, "--seed", 3]
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
    left = part(2, 3, "--crop", "0,0,20,37")
    pathtracer.failure("--merge", a, left, c, *OUT, said=["samples 2 to 4 of pixel 20,0"])
    # So are regions that begin at other samples.
    right = part(1, 2, "--crop", "20,0,45,37")
    pathtracer.failure("--merge", part(0, 2, "--crop", "0,0,20,37"), right, *OUT, said=["samples 0 to 0 of pixel 20,0"])


def test_numbers_that_cannot_be(pathtracer):
    begun = pathtracer.render("--size", "8x8", "--spp", 1)
    whole = begun.read_bytes()
    for name, *values in (("seconds", np.nan, np.inf, -1), ("samplingShare", np.nan, np.inf, -1), ("exposure", np.nan, np.inf)):
        for value in values:
            at = whole.index(f"{name}\0float\0".encode()) + len(name) + 11
            begun.write_bytes(whole[:at] + np.float32(value).tobytes() + whole[at + 4:])
            pathtracer.failure("--merge", begun, *OUT, said=[name, begun.name])
    at = whole.index(b"endSample\0string\0") + 21  # "1"
    begun.write_bytes(whole[:at] + b"0" + whole[at + 1:])
    pathtracer.failure("--merge", begun, *OUT, said=["more samples than its attributes say"])


# Attributes in which parts of one picture may differ, and displayWindow, which is the size. Others are settings.
PARTS_DIFFER_IN = {
    "channels", "chunkCount", "compression", "dataWindow", "lineOrder", "name", "pixelAspectRatio", "screenWindowCenter",
    "screenWindowWidth", "type", "spp", "firstSample", "endSample", "exposure", "threads", "seconds", "rays", "samplingShare",
    "software", "bnVersion", "displayWindow",
}  # fmt: skip
SETTINGS = {
    "scene", "camera", "environment", "sampler", "mask", "draws", "inputs", "declaredSpp", "seed", "maxDepth", "lightSamples",
    "singleScatter", "photometric", "clamp", "noise", "minSpp", "noiseExposure",
}  # fmt: skip


def another(value):
    """A value of the same type that differs."""
    if isinstance(value, str):
        return str(int(value) + 1) if value.isdigit() else value + "x"
    return value + 1 if isinstance(value, (int, np.ndarray)) else value * 1.5 + 0.01


def test_parts_differ_in_no_setting(pathtracer):
    """Whatever attribute of a picture is changed, it is no part of that picture any more, unless it is known to be one in
    which parts differ. So a setting that is new is compared, or its attribute stands in the list above."""
    common = [*SIZE, "--noise", 0.3, "--min-spp", 2, "--spp", 4]
    first = pathtracer.render(*common, "--crop", "0,0,16,37")
    second = pathtracer.render(*common, "--crop", "16,0,45,37")
    merge(pathtracer, first, second)
    with OpenEXR.File(str(second), separate_channels=True) as file:
        header, channels = file.header(), {name: np.array(c.pixels) for name, c in file.channels().items()}
        settings = {name: value for name, value in header.items() if name not in PARTS_DIFFER_IN}
        assert set(settings) >= SETTINGS
        for name in (None, *settings):
            changed = {**header, **({name: another(settings[name])} if name else {})}
            changed.pop("channels")
            copy = pathtracer.folder / "copy.exr"
            with OpenEXR.File(changed, channels) as written:
                written.write(str(copy))
            if not name:
                merge(pathtracer, first, copy)  # written again, it is the same still
                continue
            pathtracer.failure("--merge", first, copy, *OUT, said=["not parts of one picture", copy.name])


@pytest.mark.parametrize("crop", [(0, 0, 40, 30), (5, 3, 31, 27)])
def test_the_error_against_a_reference(pathtracer, crop):
    common = ["--size", "40x30", "--seed", 2, "--crop", ",".join(map(str, crop)), "--spp", 4]
    reference = pathtracer.render("--size", "40x30", "--spp", 96, "--seed", 1)
    words = pathtracer.success(*common, "--quiet", "--reference", reference, *OUT).stdout.split()
    assert words[0] == "rmse" and words[2:4] == ["sigma", "1.0"] and words[5:7] == ["sigma", "2.1"]
    error = pathtracer.image(*common) - read_exr(reference)[0][crop[1]:crop[3], crop[0]:crop[2]].astype(np.float64)
    for word, sigma in ((1, 0), (4, 1.0), (7, 2.1)):
        blurred = gaussian_filter(error, (sigma, sigma, 0)) if sigma else error
        assert float(words[word]) == pytest.approx(np.sqrt(np.mean(blurred**2)), abs=1e-6)
