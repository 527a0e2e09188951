# SPDX-License-Identifier: Apache-2.0
"""What an image may not depend on, and what is written beside it: layers, attributes, a preview of the right brightness."""

import numpy as np
import pytest
from pathtracer_driver import PEERS, SAMPLERS, SCENES, assert_same, read_exr, read_layers
from PIL import Image
from scene_files import SMALL, floor, over_floor, write_environment

ADAPTIVE = ["--noise", 0.1, "--min-spp", 4, "--spp", 64]


@pytest.mark.parametrize(("scene", "sampler", "more"), [
    *((scene, "blue", ()) for scene in SCENES[1:]), *(("cornell", sampler, ()) for sampler in (*SAMPLERS, *PEERS)),
    *(("penumbra", sampler, ADAPTIVE) for sampler in ("blue", "white", "zorder"))])
def test_threads_crops_and_ranges_do_not_change_an_image(pathtracer, scene, sampler, more):
    pathtracer.needs(sampler)
    common = ["--scene", scene, "--sampler", sampler, "--size", "29x21", "--light-samples", 3, "--spp", 4, *more]
    path = pathtracer.render(*common, "--threads", 1)
    whole = read_layers(path)
    assert read_exr(path)[1]["sampler"] == sampler
    assert_same(whole, read_layers(pathtracer.render(*common, "--threads", 3)))
    for x0, y0, x1, y1 in [(0, 0, 29, 21), (11, 3, 20, 19), (28, 20, 29, 21), (0, 7, 29, 8)]:
        part = pathtracer.render(*common, "--crop", f"{x0},{y0},{x1},{y1}")
        assert_same(read_layers(part), {name: values[y0:y1, x0:x1] for name, values in whole.items()})
        header = read_exr(part)[1]
        assert [*map(list, header["dataWindow"])] == [[x0, y0], [x1 - 1, y1 - 1]]
        assert [*map(list, header["displayWindow"])] == [[0, 0], [28, 20]]
    if not more:
        first, rest = (pathtracer.image(*common, "--spp", n, "--first-sample", f) for n, f in ((1, 0), (3, 1)))
        np.testing.assert_allclose(first / 4 + rest * 3 / 4, read_exr(path)[0], rtol=1e-5, atol=1e-6)


def test_samples_seeds_and_samplers_differ(pathtracer):
    firsts = []
    for sampler in SAMPLERS:
        common = ["--sampler", sampler, "--size", "40x32", "--spp", 4]
        first, *others = (pathtracer.image(*common, *more) for more in ([], ["--first-sample", 4], ["--seed", 2**64 - 1]))
        assert all(np.mean(first != other) > 0.5 for other in [*others, *firsts])
        firsts.append(first)


def test_attributes(pathtracer):
    arguments = ["--sampler", "zorder", "--declare", 16, "--spp", 5, "--seed", 2**64 - 1]
    arguments += ["--first-sample", 7, "--max-depth", 3, "--threads", 2, "--size", "20x10"]
    header = read_exr(pathtracer.render(*arguments))[1]
    wanted = {"scene": "cornell", "sampler": "zorder", "spp": "5", "declare": "16", "seed": str(2**64 - 1),
              "firstSample": "7", "endSample": "12", "max-depth": "3", "threads": "2"}
    assert {name: header[name] for name in wanted} == wanted
    assert float(header["seconds"]) > 0 and int(header["rays"]) >= 20 * 10 * 5
    assert header["software"].startswith("libbn pathtracer 0.")
    assert "ZIP" in str(header["compression"])


def test_layers(pathtracer):
    """The Cornell box is known: its colours, that its camera looks along +z, and how far its walls are."""
    path = pathtracer.render("--size", "64x64", "--spp", 16)
    layers = read_layers(path)
    normals = [f"normal.{axis}" for axis in "XYZ"]
    expected = [*"RGBA", "count", "depth.Z", *normals, *(f"{name}.{c}" for name in ("albedo", "variance") for c in "RGB")]
    assert sorted(layers) == sorted(expected)
    assert all(np.isfinite(values).all() and (name in normals or values.min() >= 0) for name, values in layers.items())
    assert layers["count"].dtype == np.uint32 and (layers["count"] == 16).all() and layers["A"].max() == 1
    # The left wall is red, the right one green, and what is behind is a white wall that faces the camera.
    middle = 32
    red, green = ([layers[f"albedo.{c}"][middle, x] for c in "RGB"] for x in (3, 60))
    assert red[0] > 2 * red[1] and green[1] > 2 * green[0]
    normal = np.stack([layers[name] for name in normals])
    np.testing.assert_allclose(np.abs(normal[:, 18, 32]), [0, 0, 1], atol=1e-6)
    assert abs(normal[0, middle, 3]) > 0.99 and np.sign(normal[0, middle, 3]) == -np.sign(normal[0, middle, 60])
    assert np.linalg.norm(normal, axis=0).max() < 1 + 1e-6
    # 800 from the camera to the front of the box, which is 559.2 deep.
    assert layers["depth.Z"][18, 32] == pytest.approx(800 + 559.2, abs=1)
    assert layers["depth.Z"][layers["A"] == 1].min() > 800


def test_wide_images_show_the_middle_alike(pathtracer):
    square, wide = (read_layers(pathtracer.render("--size", size, "--spp", 16))["depth.Z"] for size in ("48x48", "80x48"))
    assert np.median(np.abs(wide[:, 16:64] - square)) < 1 and np.abs(wide[:, :48] - square).max() > 100


def test_the_layer_of_variance_is_that_of_samples(pathtracer):
    arguments = ["--size", "24x24", "--spp", 1, "--crop", "4,4,12,12"]
    samples = np.stack([pathtracer.image(*arguments, "--first-sample", i) for i in range(6)])
    layers = read_layers(pathtracer.render(*arguments, "--spp", 6))
    variance = np.stack([layers[f"variance.{c}"] for c in "RGB"], axis=-1)
    np.testing.assert_allclose(variance, samples.var(axis=0, ddof=1, dtype=np.float64), rtol=1e-5, atol=1e-9)
    single = read_layers(pathtracer.render(*arguments))
    assert all((single[f"variance.{c}"] == 0).all() for c in "RGB")


def expected_preview(linear, exposure):
    v = linear.astype(np.float64) * 2.0**exposure
    v = np.where(v < 0.6, v, 1 - 0.4 * np.exp((0.6 - v) / 0.4))
    return 255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("exposure", [0, -2, 1.5])
def test_preview(pathtracer, exposure):
    path = pathtracer.render("--size", "50x40", "--crop", "3,2,47,39", "--exposure", exposure)
    linear = read_exr(path)[0]
    preview = np.asarray(Image.open(path.with_suffix(".png")))
    assert preview.dtype == np.uint8 and preview.shape == linear.shape
    # Dithered: up or down to a whole level, and on the mean right. The rest is the float arithmetic of the program.
    difference = preview - expected_preview(linear, exposure)
    assert np.abs(difference).max() < 1.001
    assert abs(difference.mean()) < 0.02
    # Rounding alone would put all of a smooth image's neighbours on one side.
    assert 0.2 < np.mean(difference > 0) < 0.8


# ---- The brightness of the preview, and images in which nothing is to be seen


def preview(path):
    return np.asarray(Image.open(path.with_suffix(".png"))).astype(np.float64)


def render(pathtracer, scene, *arguments):
    path = scene.save(pathtracer.folder / "scene.glb")
    out = pathtracer.folder / "out.exr"
    done = pathtracer.success("--scene", path, *SMALL, "--spp", 4, *arguments, "-o", out)
    return out, done.stderr


@pytest.mark.parametrize("radiance", [1e-4, 0.3, 1e5])
def test_an_even_image_becomes_middle_grey(pathtracer, radiance):
    """A floor of albedo one half under an even sky, whatever it is bright: to an eighth of a stop."""
    sky = write_environment(pathtracer.folder / "sky.exr", radiance)
    out, said = render(pathtracer, over_floor(floor()), "--env", sky, "--max-depth", 1)
    picture, header = read_exr(out)
    exact = np.log2(0.18 / picture.mean())
    assert abs(float(header["exposure"]) - exact) <= 0.13 and float(header["exposure"]) * 4 % 1 == 0
    assert said == ""
    # Middle grey is 118 of 255 in sRGB; an eighth of a stop is some 5 levels there.
    assert abs(preview(out).mean() - 118) < 6


def test_auto_exposure_ignores_the_sky(pathtracer):
    """A sky a thousand times as bright as the floor, which fills a quarter of the image."""
    g = floor()
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.001, 0.001, 0.001, 1]
    sky = write_environment(pathtracer.folder / "sky.exr", 1)
    view = ["--eye", "0,2,0", "--target", "0,0,0", "--fov", 90]
    out, _ = render(pathtracer, g, "--env", sky, "--max-depth", 1, *view)
    assert float(read_exr(out)[1]["exposure"]) == pytest.approx(np.log2(0.18 / 0.001), abs=0.13)


def test_built_in_scenes_keep_their_brightness(pathtracer):
    common = ["--size", "32x32", "--spp", 4]
    exposure = lambda *more: float(read_exr(pathtracer.render(*common, *more))[1]["exposure"])
    assert exposure() == 0
    auto = exposure("--exposure", "auto")
    # Samplers differ in noise, and not in brightness.
    others = [exposure("--exposure", "auto", "--sampler", sampler, "--spp", spp) for sampler in ("white", "sobol") for spp in (1, 64)]
    assert np.ptp([auto, *others]) <= 0.25 and auto != 0
    path = over_floor(floor()).save(pathtracer.folder / "scene.glb")
    given = pathtracer.render("--scene", path, *SMALL, "--exposure", -1.5)
    assert read_exr(given)[1]["exposure"] == "-1.5"


def test_warnings_about_empty_and_black_images(pathtracer, even_sky):
    """One line says so, with --quiet too: where nothing is hit, and where no light is."""
    away = ["--eye", "0,5,0", "--target", "0,9,0", "--env", even_sky]
    for scene, options, words in [
        (floor(), [*away, "--quiet"], ["NOTHING IS VISIBLE", "--eye", "from -1,0,-1 to 1,0,1"]),
        (over_floor(floor()), ["--env", "none", "--quiet"], ["BLACK", "--env sky"]),
        (floor(), [*away, "--crop", "0,0,8,8"], []),  # parts of an image may be empty
        (over_floor(floor()), ["--env", even_sky], []),
    ]:
        _, said = render(pathtracer, scene, *options)
        assert said.count("\n") == bool(words) and all(word in said for word in words), said


def test_merged_images_get_their_own_exposure(pathtracer, even_sky):
    path = over_floor(floor()).save(pathtracer.folder / "scene.glb")
    common = ["--scene", path, *SMALL, "--spp", 2]
    merged = pathtracer.render("--merge", *(pathtracer.render(*common, "--first-sample", n) for n in (0, 2)))
    assert read_exr(merged)[1]["exposure"] == read_exr(pathtracer.render(*common, "--spp", 4))[1]["exposure"] != "0"
    common += ["--env", even_sky, "--eye", "0,5,0", "--target", "0,9,0"]
    parts = [pathtracer.render(*common, "--first-sample", n) for n in (0, 2)]
    assert "NOTHING IS VISIBLE" in pathtracer.success("--merge", *parts, "-o", "out.exr").stderr
