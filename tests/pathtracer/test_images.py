# SPDX-License-Identifier: Apache-2.0
"""Tests that images do not depend on threads, crops or sample ranges; layers, attributes, adaptive sampling, previews and exposure."""

import os
import resource

import numpy as np
import pytest
from pathtracer_driver import PLUGINS, SAMPLERS, SCENES, assert_same, read_exr, read_layers
from PIL import Image
from scene_files import ONE, floor, over_floor, write_environment

from bluenoise import visible_noise

PENUMBRA = ["--scene", "penumbra", "--max-depth", 1]
ADAPTIVE = [*PENUMBRA, "--noise", 0.1, "--min-spp", 4, "--spp", 64]
AWAY = ["--eye", "0,5,0", "--target", "0,9,0"]  # turns the camera away from a floor


def test_threads_that_the_system_refuses_are_not_needed(pathtracer):
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2**31, 2**31))  # too little for so many stacks
    pathtracer.success("--size", "29x21", "--spp", 1, "--threads", 1024, "-o", "out.exr", preexec_fn=limit)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="the system has no CPU affinity")
def test_default_threads_are_the_cpus_that_the_process_may_use(pathtracer):
    one = lambda: os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    pathtracer.success("--size", "29x21", "--spp", 1, "-o", "out.exr", preexec_fn=one)
    assert read_exr(pathtracer.folder / "out.exr")[1]["threads"] == "1"


@pytest.mark.parametrize(("sampler", "options"), [
    *(("blue", ["--scene", scene, "--spp", 4]) for scene in SCENES[1:]), *((sampler, ["--spp", 4]) for sampler in (*SAMPLERS, *PLUGINS)),
    *((sampler, ADAPTIVE) for sampler in ("blue", "white", "zorder"))])
def test_threads_crops_and_ranges_do_not_change_an_image(pathtracer, sampler, options):
    common = [*options, "--sampler", sampler, "--size", "29x21", "--light-samples", 3]
    path = pathtracer.render(*common, "--threads", 1)
    whole, (image, header) = read_layers(path), read_exr(path)
    assert header["sampler"] == sampler
    assert_same(whole, pathtracer.layers(*common, "--threads", 3))
    for x0, y0, x1, y1 in [(11, 3, 20, 19), (28, 0, 29, 21)]:
        part = pathtracer.render(*common, "--crop", f"{x0},{y0},{x1},{y1}")
        assert_same(read_layers(part), {name: values[y0:y1, x0:x1] for name, values in whole.items()})
        windows = [[*map(list, read_exr(part)[1][f"{kind}Window"])] for kind in ("data", "display")]
        assert windows == [[[x0, y0], [x1 - 1, y1 - 1]], [[0, 0], [28, 20]]]
    if "--noise" not in options:
        first, rest = (pathtracer.image(*common, "--spp", n, "--first-sample", f) for n, f in ((1, 0), (3, 1)))
        np.testing.assert_allclose(first / 4 + rest * 3 / 4, image, rtol=1e-5, atol=1e-6)


def test_sample_ranges_seeds_and_samplers_give_different_images(pathtracer):
    firsts = []
    for sampler in SAMPLERS:
        common = ["--sampler", sampler, "--size", "24x20", "--spp", 4]
        first, *others = (pathtracer.image(*common, *more) for more in ([], ["--first-sample", 4], ["--seed", 2**64 - 1]))
        assert all(np.mean(first != other) > 0.5 for other in [*others, *firsts])
        firsts.append(first)


def test_attributes_record_the_options(pathtracer):
    wanted = {"scene": "cornell", "sampler": "zorder", "spp": "5", "declare": "16", "seed": str(2**64 - 1), "first-sample": "7",
              "max-depth": "3", "threads": "2"}  # fmt: skip
    header = pathtracer.header(*(word for name, value in wanted.items() for word in (f"--{name}", value)), "--size", "20x10")
    wanted["firstSample"], wanted["endSample"] = wanted.pop("first-sample"), "12"
    assert {name: header[name] for name in wanted} == wanted
    assert float(header["seconds"]) > 0 and int(header["rays"]) >= 20 * 10 * 5
    assert header["software"].startswith("libbn pathtracer 0.") and "ZIP" in str(header["compression"])


def test_layers_of_the_cornell_box(pathtracer):
    """The box's colours, its walls' distances and the camera's direction, +z, are known."""
    layers = pathtracer.layers("--size", "64x64", "--spp", 16)
    normals = [f"normal.{axis}" for axis in "XYZ"]
    assert {*layers} == {*"RGBA", "count", "depth.Z", *normals, *(f"{name}.{c}" for name in ("albedo", "variance") for c in "RGB")}
    assert all(np.isfinite(values).all() and (name in normals or values.min() >= 0) for name, values in layers.items())
    assert layers["count"].dtype == np.uint32 and (layers["count"] == 16).all() and layers["A"].max() == 1
    # The left wall is red and the right wall is green. The white back wall faces the camera.
    red, green = ([layers[f"albedo.{c}"][32, x] for c in "RGB"] for x in (3, 60))
    assert red[0] > 2 * red[1] and green[1] > 2 * green[0]
    normal = np.stack([layers[name] for name in normals])
    np.testing.assert_allclose(np.abs(normal[:, 18, 32]), [0, 0, 1], atol=1e-6)
    assert abs(normal[0, 32, 3]) > 0.99 and np.sign(normal[0, 32, 3]) == -np.sign(normal[0, 32, 60])
    assert np.linalg.norm(normal, axis=0).max() < 1 + 1e-6
    # The camera is 800 in front of the box, which is 559.2 deep.
    assert layers["depth.Z"][18, 32] == pytest.approx(800 + 559.2, abs=1)
    assert layers["depth.Z"][layers["A"] == 1].min() > 800
    wide = pathtracer.layers("--size", "96x64", "--spp", 16)["depth.Z"]  # shows the same centre
    assert np.median(np.abs(wide[:, 16:80] - layers["depth.Z"])) < 1 and np.abs(wide[:, :64] - layers["depth.Z"]).max() > 100


def test_the_variance_layer_is_the_sample_variance(pathtracer):
    arguments = ["--size", "24x24", "--spp", 1, "--crop", "4,4,12,12"]
    samples = np.stack([pathtracer.image(*arguments, "--first-sample", i) for i in range(6)])
    for count in (1, 6):
        layers = pathtracer.layers(*arguments, "--spp", count)
        wanted = samples.var(axis=0, ddof=1, dtype=np.float64) if count > 1 else 0 * samples[0]
        np.testing.assert_allclose(np.stack([layers[f"variance.{c}"] for c in "RGB"], axis=-1), wanted, rtol=1e-5, atol=1e-9)


def displayed_error(layers, exposure):
    """The error of one block, as film.h defines it."""
    of = lambda name: np.stack([layers[name.format(c)] for c in "RGB"], dtype=np.float64)
    mean, error = 2.0**exposure * of("{}"), 2.0**exposure * np.sqrt(of("variance.{}") / layers["count"])
    shown = (np.minimum(mean + 2 * error, 1) - np.minimum(mean - 2 * error, 1)) / 4
    return np.sqrt(np.mean(shown**2)) / (np.minimum(mean, 1).mean() + 0.02)


def blocks_of(layers):
    height, width = layers["count"].shape
    places = [np.s_[y:y + 8, x:x + 8] for y in range(0, height, 8) for x in range(0, width, 8)]
    return [{name: values[place] for name, values in layers.items()} for place in places]


@pytest.mark.parametrize(("exposure", "least"), [(0, 4), (-2, 4), (2, 8)])
def test_adaptive_blocks_stop_below_the_noise_level(pathtracer, exposure, least):
    """A block stops at the first power of two, at --min-spp or more, where its error is below the level, or else at --spp."""
    size = ["--size", "45x37"]
    path = pathtracer.folder / "out.exr"
    said = pathtracer.success(*ADAPTIVE, *size, "--min-spp", least, "--exposure", exposure, "-o", path).stdout
    prefixes = {n: blocks_of(pathtracer.layers(*PENUMBRA, *size, "--spp", n)) for n in (4, 8, 16, 32, 64)}
    layers, header = read_layers(path), read_exr(path)[1]
    for k, block in enumerate(blocks_of(layers)):
        count = next((n for n in (4, 8, 16, 32) if n >= least and displayed_error(prefixes[n][k], exposure) < 0.1), 64)
        assert_same(block, prefixes[count][k])  # the samples are the same as without --noise
    count = layers["count"]
    most = int(count.max())
    assert len(np.unique(count)) > 2 and (most == 64 or exposure)
    wanted = {"spp": most, "endSample": most, "min-spp": least, "noise": 0.1, "noise-exposure": exposure}
    assert {name: header[name] for name in wanted} == {name: str(value) for name, value in wanted.items()}
    assert f"{count.min()} to {most} spp, {count.mean():.6g} on average" in said


@pytest.mark.parametrize("spp", [64, 24])  # 24: the last measurement compares 16 samples with 8
def test_blocks_stop_where_no_noise_is_visible(pathtracer, spp):
    """A 16x16 block stops at the first power of two at which its halves show less noise than wanted. Layers hold both."""
    options = [*PENUMBRA, "--size", "45x37", "--sampler", "white", "--exposure", 1]
    path = pathtracer.folder / "out.exr"
    said = pathtracer.success(*options, "--visible-noise", 1.2, "--spp", spp, "-o", path).stdout
    counts = [n for n in (2, 4, 8, 16, 32, 64) if n < spp] + [spp]
    prefixes = {n: pathtracer.layers(*options, "--spp", n) for n in counts}
    rgb = lambda layers, place, name="{}": np.stack([layers[name.format(c)][place] for c in "RGB"], axis=-1)
    layers = read_layers(path)
    for place in (np.s_[y:y + 16, x:x + 16] for y in range(0, 37, 16) for x in range(0, 45, 16)):
        for half, count in zip(counts, counts[1:]):
            first, mean, share = rgb(prefixes[half], place), rgb(prefixes[count], place), half / count
            noise = visible_noise(first, (mean - share * first) / (1 - share), exposure=2, first_share=share, window=65)[0, 0]
            if noise < 1.2:
                break
        assert (layers["count"][place] == count).all() and count >= 4
        np.testing.assert_array_equal(rgb(layers, place), mean)
        np.testing.assert_array_equal(rgb(layers, place, "half.{}"), 0 if noise < 1.2 and count != 24 else first)
        np.testing.assert_allclose(layers["noise"][place], noise, rtol=1e-4)
    assert len(np.unique(layers["count"])) > 2
    reached = np.sort(layers["noise"].ravel())[int(0.95 * (layers["noise"].size - 1))]
    assert f"95% of the image is below {reached:.2f} steps of visible noise\n" in said


def expected_preview(linear, exposure):
    v = linear.astype(np.float64) * 2.0**exposure
    v = np.where(v < 0.6, v, 1 - 0.4 * np.exp((0.6 - v) / 0.4))
    return 255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("exposure", [0, -2, 1.5])
def test_the_preview_is_tone_mapped_and_dithered(pathtracer, exposure):
    path = pathtracer.render("--size", "50x40", "--crop", "3,2,47,39", "--exposure", exposure)
    linear, header = read_exr(path)
    assert float(header["exposure"]) == exposure
    preview = np.asarray(Image.open(path.with_suffix(".png")))
    assert preview.dtype == np.uint8 and preview.shape == linear.shape
    # Dithering rounds up or down to a whole level, without bias. The tolerance allows for the program's float arithmetic.
    difference = preview - expected_preview(linear, exposure)
    assert np.abs(difference).max() < 1.001 and abs(difference.mean()) < 0.02
    # Without dithering, neighbouring pixels of a smooth image would all be rounded in the same direction.
    assert 0.2 < np.mean(difference > 0) < 0.8


@pytest.mark.parametrize(("albedo", "radiance", "view"), [
    (0.5, 1e-4, []), (0.5, 0.3, []), (0.5, 1e5, []),
    (0.001, 1, ["--eye", "0,2,0", "--target", "0,0,0", "--fov", 90])])  # the floor fills a quarter of the image, a bright sky the rest
def test_auto_exposure(pathtracer, albedo, radiance, view):
    """A floor under a uniform sky becomes middle grey, within an eighth of a stop. The visible sky is ignored."""
    sky = write_environment(pathtracer.folder / "sky.exr", radiance)
    path = pathtracer.render("--scene", over_floor(floor(albedo)), "--env", sky, "--max-depth", 1, *ONE, "--spp", 4, *view)
    exposure = float(read_exr(path)[1]["exposure"])
    assert pathtracer.said == "" and abs(exposure - np.log2(0.18 / albedo / radiance)) <= 0.13 and exposure * 4 % 1 == 0
    # Middle grey is level 118 of 255 in sRGB, where an eighth of a stop is about 5 levels.
    assert view or abs(np.asarray(Image.open(path.with_suffix(".png"))).astype(np.float64).mean() - 118) < 6


def test_default_automatic_and_explicit_exposure(pathtracer):
    exposure = lambda *more: float(pathtracer.header("--size", "32x32", "--spp", 4, *more)["exposure"])
    assert exposure() == 0
    # Samplers differ in noise but not in brightness.
    auto = [exposure("--exposure", "auto", "--sampler", *more) for more in (["blue"], ["white", "--spp", 1], ["sobol", "--spp", 64])]
    assert np.ptp(auto) <= 0.25 and auto[0] != 0
    path = pathtracer.folder / "printed.exr"
    said = pathtracer.success("--size", "32x32", "--spp", 4, "--exposure", "auto", "-o", path).stdout
    assert said.startswith(f"automatic exposure: {auto[0]:g} stops\n")
    assert pathtracer.header("--scene", over_floor(floor()), *ONE, "--exposure", -1.5)["exposure"] == "-1.5"


def test_warnings_about_empty_and_black_images(pathtracer, even_sky):
    """One line warns if no surface is visible or there is no light, even with --quiet."""
    for options, words in [
        ([*AWAY, "--env", even_sky, "--quiet"], ["NOTHING IS VISIBLE", "--eye", "from -1,0,-1 to 1,0,1"]),
        (["--env", "none", "--quiet"], ["BLACK", "--env sky"]), (["--env", even_sky], []),
        ([*AWAY, "--env", even_sky, "--crop", "0,0,8,8"], []),  # crops may be empty
    ]:
        pathtracer.render("--scene", over_floor(floor()), *ONE, *options)
        assert pathtracer.said.count("\n") == bool(words) and all(word in pathtracer.said for word in words), pathtracer.said


def test_merged_images_get_their_own_exposure_and_warning(pathtracer, even_sky):
    common = ["--scene", over_floor(floor()), *ONE]
    merged = lambda *more: pathtracer.header("--merge", *(pathtracer.render(*common, *more, "--first-sample", n) for n in (0, 1)))
    assert merged()["exposure"] == pathtracer.header(*common, "--spp", 2)["exposure"] != "0"
    merged("--env", even_sky, *AWAY)
    assert "NOTHING IS VISIBLE" in pathtracer.said
