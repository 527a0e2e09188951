# SPDX-License-Identifier: Apache-2.0
"""Pictures in parts: regions and ranges of samples merged, written on the way, ended by the clock."""

import csv
import resource
import signal
import subprocess
import time

import numpy as np
import OpenEXR
import pytest
from pathtracer_driver import assert_near, assert_same, read_exr, read_layers
from PIL import Image
from scene_files import write_environment
from scipy.ndimage import gaussian_filter

SIZE = ["--size", "45x37"]


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
    out = ["-o", "out.exr"]
    assert "same samples" in pathtracer.failure("--merge", first, first, *out)
    overlapping = pathtracer.render(*common, "--first-sample", 1)
    assert "same samples" in pathtracer.failure("--merge", first, overlapping, *out)
    other = pathtracer.render(*common, "--first-sample", 2, "--size", "37x45")
    assert "size" in pathtracer.failure("--merge", first, other, *out)


# Attributes in which parts of one picture may differ, and displayWindow, which is the size. Others are settings.
PARTS_DIFFER_IN = {
    "channels", "chunkCount", "compression", "dataWindow", "lineOrder", "name", "pixelAspectRatio", "screenWindowCenter",
    "screenWindowWidth", "type", "spp", "firstSample", "endSample", "exposure", "threads", "seconds", "rays", "samplingShare",
    "fireflies", "software", "bnVersion", "displayWindow",
}  # fmt: skip
SETTINGS = {
    "scene", "camera", "environment", "sampler", "mask", "draws", "inputs", "worldToCamera", "worldToNDC", "declaredSpp", "seed",
    "maxDepth", "lightSamples", "singleScatter", "photometric", "noise", "minSpp", "noiseExposure",
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
            pathtracer.failure("--merge", first, copy, "-o", "out.exr", said=["not parts of one picture", copy.name])


def test_another_mask_is_another_picture(pathtracer):
    """By its name, and by what is in a file of the same name."""
    values = np.random.default_rng(3).permutation(64).astype(np.uint8).reshape(8, 8)
    mask = pathtracer.folder / "mask.png"
    Image.fromarray(values).save(mask)
    common = [*SIZE, "--spp", 2, "--sampler", "mask"]
    first = pathtracer.render(*common, "--mask", mask)
    for later in (["--mask", "builtin"], []):
        other = pathtracer.render(*common, *later, "--first-sample", 2)
        pathtracer.failure("--merge", first, other, "-o", "out.exr", said=["mask"])
    Image.fromarray(values.T).save(mask)
    other = pathtracer.render(*common, "--mask", mask, "--first-sample", 2)
    pathtracer.failure("--merge", first, other, "-o", "out.exr", said=[f"the contents of {mask}"])


def test_a_picture_of_another_program_is_no_part(pathtracer):
    path = write_environment(pathtracer.folder / "other.exr", 0)
    pathtracer.failure("--merge", path, "-o", "out.exr", said=["other.exr", "this program"])


@pytest.mark.parametrize("crop", [(0, 0, 40, 30), (5, 3, 31, 27)])
def test_the_error_against_a_reference(pathtracer, crop):
    """Each row of --convergence is what a run of so many samples would have, and the last is what is printed."""
    common = ["--size", "40x30", "--seed", 2, "--crop", ",".join(map(str, crop))]
    reference = pathtracer.render("--size", "40x30", "--spp", 96, "--seed", 1)
    path = pathtracer.folder / "rows.csv"
    arguments = ["--spp", 11, "--quiet", "--reference", reference, "--convergence", path, "-o", "out.exr"]
    words = pathtracer.success(*common, *arguments).stdout.split()
    assert words[0] == "rmse" and words[2:4] == ["sigma", "1.0"] and words[5:7] == ["sigma", "2.1"]
    with open(path, newline="") as file:
        rows = [{name: float(v) for name, v in row.items()} for row in csv.DictReader(file)]
    assert list(rows[0]) == ["spp", "seconds", "rmse", "relative_rmse", "rmse_1.0", "rmse_2.1"]
    assert [row["spp"] for row in rows] == [1, 2, 3, 4, 6, 8, 11]
    seconds = [row["seconds"] for row in rows]
    assert seconds == sorted(seconds) and seconds[0] > 0
    wanted = read_exr(reference)[0][crop[1]:crop[3], crop[0]:crop[2]].astype(np.float64)
    for row in (rows[0], rows[4], rows[6]):
        error = pathtracer.image(*common, "--spp", int(row["spp"])) - wanted
        for name, sigma in [("rmse", 0), ("rmse_1.0", 1.0), ("rmse_2.1", 2.1)]:
            blurred = gaussian_filter(error, (sigma, sigma, 0)) if sigma else error
            assert row[name] == pytest.approx(np.sqrt(np.mean(blurred**2)), rel=1e-6)
        relative = error / (wanted + 0.1 * wanted.mean())
        assert row["relative_rmse"] == pytest.approx(np.sqrt(np.mean(relative**2)), rel=1e-6)
    # Seven digits of an RMSE are six decimals here.
    printed = [float(words[i]) for i in (1, 4, 7)]
    np.testing.assert_allclose(printed, [rows[-1][name] for name in ("rmse", "rmse_1.0", "rmse_2.1")], atol=1e-6)


def test_passes_do_not_change_a_bit(pathtracer):
    common = ["--size", "40x30", "--spp", 13]
    plain = pathtracer.render(*common)
    written = pathtracer.render(*common, "--write-partial", 0.001, "--threads", 1)
    assert_same(read_layers(written), read_layers(plain))


def test_a_time_limit(pathtracer):
    began = time.monotonic()
    path = pathtracer.render("--size", "64x64", "--time", 1)
    took = time.monotonic() - began
    header = read_exr(path)[1]
    # What is asked for is rendering time; loading a program takes some, a busy machine more.
    assert 0.3 < header["seconds"] < 3 and took < 30
    assert header["spp"] > 1
    assert (read_layers(path)["count"] == header["spp"]).all()
    few = read_exr(pathtracer.render("--size", "64x64", "--time", 1000, "--spp", 2))[1]
    assert few["spp"] == 2
    one = read_exr(pathtracer.render("--size", "64x64", "--time", 1e-6))[1]
    assert one["spp"] == 1


def test_partial_pictures_appear_and_a_full_disk_does_not_end_the_run(pathtracer):
    endless = ["--size", "96x64", "--spp", 1000000]
    program = pathtracer.start(*endless, "--write-partial", 0.3, "-o", "out.exr", stderr=subprocess.PIPE)
    out = pathtracer.folder / "out.exr"
    seen = set()
    deadline = time.monotonic() + 60
    while len(seen) < 2 and time.monotonic() < deadline:
        time.sleep(0.1)
        if out.exists():
            seen.add(read_exr(out)[1]["spp"])
    assert len(seen) >= 2
    program.send_signal(signal.SIGINT)
    assert program.wait(timeout=60) == 128 + signal.SIGINT
    program.stderr.close()
    assert read_exr(out)[1]["spp"] >= max(seen)

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

    done = pathtracer.run(*endless, "--time", 2, "--write-partial", 0.5, "-o", "full.exr", preexec_fn=limit)
    lines = done.stderr.splitlines()
    assert done.returncode == 1 and len(lines) >= 2
    assert all("rendering continues" in line for line in lines[:-1]) and "full.exr" in lines[-1]
    assert not (pathtracer.folder / "full.exr").exists()


def test_fireflies_are_counted(pathtracer):
    """Glass in a studio has paths that only chance finds: few samples show fireflies, a lone lamp none."""
    def count(*arguments):
        return int(read_exr(pathtracer.render(*arguments))[1]["fireflies"])

    assert count("--scene", "glass", "--size", "192x144", "--spp", 2, "--sampler", "white") > 0
    assert count("--scene", "furnace", "--size", "64x64", "--spp", 2) == 0
