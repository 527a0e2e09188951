# SPDX-License-Identifier: Apache-2.0
"""The brightness of the preview, and pictures in which nothing is to be seen."""

import numpy as np
import pytest
from pathtracer_driver import read_exr
from PIL import Image
from scene_files import SMALL, floor, over_floor, write_environment


def preview(path):
    return np.asarray(Image.open(path.with_suffix(".png"))).astype(np.float64)


def render(pathtracer, scene, *arguments):
    path = scene.save(pathtracer.folder / "scene.glb")
    out = pathtracer.folder / "out.exr"
    done = pathtracer.success("--scene", path, *SMALL, "--spp", 4, *arguments, "-o", out)
    return out, done.stderr


@pytest.mark.parametrize("radiance", [1e-4, 0.3, 1e5])
def test_an_even_picture_becomes_middle_grey(pathtracer, radiance):
    """A floor of albedo one half under an even sky, whatever it is bright: to an eighth of a stop."""
    sky = write_environment(pathtracer.folder / "sky.exr", radiance)
    out, said = render(pathtracer, over_floor(floor()), "--env", sky, "--max-depth", 1)
    picture, header = read_exr(out)
    exact = np.log2(0.18 / picture.mean())
    assert abs(header["exposure"] - exact) <= 0.13 and header["exposure"] * 4 % 1 == 0
    assert said == ""
    # Middle grey is 118 of 255 in sRGB; an eighth of a stop is some 5 levels there.
    assert abs(preview(out).mean() - 118) < 6


def test_only_surfaces_count(pathtracer):
    """A sky a thousand times as bright as the floor, which fills a quarter of the picture."""
    g = floor()
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [0.001, 0.001, 0.001, 1]
    sky = write_environment(pathtracer.folder / "sky.exr", 1)
    view = ["--eye", "0,2,0", "--target", "0,0,0", "--fov", 90]
    out, _ = render(pathtracer, g, "--env", sky, "--max-depth", 1, *view)
    assert read_exr(out)[1]["exposure"] == pytest.approx(np.log2(0.18 / 0.001), abs=0.13)


def test_built_in_scenes_keep_their_brightness(pathtracer):
    common = ["--size", "32x32", "--spp", 4]
    assert read_exr(pathtracer.render(*common))[1]["exposure"] == 0
    auto = read_exr(pathtracer.render(*common, "--exposure", "auto"))[1]["exposure"]
    # Samplers differ in noise, and not in brightness.
    others = [read_exr(pathtracer.render(*common, "--exposure", "auto", "--sampler", sampler, "--spp", spp))[1]["exposure"]
              for sampler in ("white", "sobol") for spp in (1, 64)]
    assert np.ptp([auto, *others]) <= 0.25 and auto != 0
    path = over_floor(floor()).save(pathtracer.folder / "scene.glb")
    given = pathtracer.render("--scene", path, *SMALL, "--exposure", -1.5)
    assert read_exr(given)[1]["exposure"] == -1.5


def test_nothing_is_visible(pathtracer, even_sky):
    """One line says so, with --quiet too: where nothing is hit, and where no light is."""
    away = ["--eye", "0,5,0", "--target", "0,9,0", "--env", even_sky]
    for scene, options, words in [
        (floor(), [*away, "--quiet"], ["NOTHING IS VISIBLE", "--eye", "from -1,0,-1 to 1,0,1"]),
        (over_floor(floor()), ["--env", "none", "--quiet"], ["BLACK", "--env sky"]),
        (floor(), [*away, "--crop", "0,0,8,8"], []),  # parts of a picture may be empty
        (over_floor(floor()), ["--env", even_sky], []),
    ]:
        _, said = render(pathtracer, scene, *options)
        assert said.count("\n") == bool(words) and all(word in said for word in words), said


def test_merged_parts_have_their_own(pathtracer, even_sky):
    path = over_floor(floor()).save(pathtracer.folder / "scene.glb")
    common = ["--scene", path, *SMALL, "--spp", 2]
    merged = pathtracer.render("--merge", *(pathtracer.render(*common, "--first-sample", n) for n in (0, 2)))
    assert read_exr(merged)[1]["exposure"] == read_exr(pathtracer.render(*common, "--spp", 4))[1]["exposure"] != 0
    common += ["--env", even_sky, "--eye", "0,5,0", "--target", "0,9,0"]
    parts = [pathtracer.render(*common, "--first-sample", n) for n in (0, 2)]
    assert "NOTHING IS VISIBLE" in pathtracer.success("--merge", *parts, "-o", "out.exr").stderr
