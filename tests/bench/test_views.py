# SPDX-License-Identifier: Apache-2.0
"""The views used to compare samplers."""

import argparse
import itertools
import math
import subprocess

import numpy as np
import pytest
from report.base.files import read_exr
from report.renders import views
from report.renders.renderer import Request, run_pathtracer


@pytest.mark.parametrize("scene", views.SCENES)
def test_no_size_of_a_scene_divides_another(scene):
    own = [view for view in views.ALL if view.scene == scene]
    sizes = [size for view in own for size in view.size]
    assert len(own) >= 8 and 120 <= min(sizes) and max(sizes) <= 400
    assert all(math.gcd(a, b) == 1 for a, b in itertools.combinations(sizes, 2))
    assert len({view.camera for view in own}) == len({view.name for view in own}) == len(own)
    assert {view.width > view.height for view in own} == {True, False}


def test_no_two_views_have_one_size():
    assert len({tuple(sorted(view.size)) for view in views.ALL}) == len(views.ALL)


def test_cameras_turn_and_move_a_little():
    for view in views.ALL:
        own_eye, own_target, own_fov = views.CAMERAS[view.scene]
        options = dict(zip(view.camera[::2], view.camera[1::2]))
        eye, target = ([float(number) for number in options[name].split(",")] for name in ("--eye", "--target"))
        distance = math.dist(own_eye, own_target)
        assert math.dist(eye, target) == pytest.approx(distance, rel=1e-4)
        assert 0 < math.dist(eye, own_eye) < 0.03 * distance
        cosine = sum((b - a) * (d - c) for a, b, c, d in zip(eye, target, own_eye, own_target)) / distance**2
        assert 0.01 < math.degrees(math.acos(min(1, cosine))) < 4
        assert float(options["--fov"]) == pytest.approx(own_fov, rel=0.061)


@pytest.mark.parametrize("scene", views.SCENES)
def test_cameras_are_those_of_the_scenes(pathtracer, scene):
    listed = subprocess.run([pathtracer, "--scene", scene, "--list-cameras"], check=True, capture_output=True, text=True).stdout
    words = listed.split()
    for name, own in zip(("--eye", "--target", "--fov"), views.CAMERAS[scene]):
        numbers = [float(number) for number in words[words.index(name) + 1].split(",")]
        assert numbers == pytest.approx(list(own) if isinstance(own, tuple) else [own], abs=2e-5)


@pytest.mark.parametrize("make, count", [(views.chosen, len(views.ALL)), (views.crops, 3 * 4 * len(views.SCENES))])
def test_sets_share_no_view_and_no_camera(make, count):
    sets = [make(name) for name in views.SETS]
    assert len(set().union(*sets)) == sum(map(len, sets)) == count
    cameras = [{view.camera for view in own} for own in sets]
    assert all(not a & b for a, b in itertools.combinations(cameras, 2))
    assert all({view.scene for view in own} == set(views.SCENES) for own in sets)
    assert views.chosen("core", ("lens",), (32, 24))[0].size == (32, 24)


def test_small_and_large_pictures_share_no_camera():
    large = {view.camera for name in views.SETS for view in views.crops(name)}
    assert len(large) == 3 * len(views.SCENES) and not large & {view.camera for view in views.ALL}


def test_crops_are_real_sizes_one_in_each_quarter():
    for name in views.SETS:
        for scene in views.SCENES:
            own = views.crops(name, (scene,))
            assert len(own) == 4 and len({view.picture for view in own}) == 1
            assert own[0].width >= 1280 and own[0].height >= 960
            for i, view in enumerate(own):
                (x0, y0, x1, y1), (wide, high) = view.crop, (view.width // 2, view.height // 2)
                assert view.size == (x1 - x0, y1 - y0) == views.CROP and view.pixels == views.CROP[0] * views.CROP[1]
                assert i % 2 * wide <= x0 < x1 <= (i % 2 + 1) * wide and i // 2 * high <= y0 < y1 <= (i // 2 + 1) * high
    # Placed by names alone: these bounds must stay, or results of other versions are of other places.
    assert [view.crop[:2] for view in views.crops("held-out", ("cornell",))] == [(209, 16), (1067, 47), (330, 747), (896, 725)]


def test_crops_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="do not fit into the quarters"):
        views.crops("core", ("lens",), (64, 48), (33, 24))
    (x0, y0, x1, y1) = views.crops_of(views.View("a.obj", "", 400, 400), (100, 100), 0.25)[3].crop
    assert (x0, y0, x1, y1) == (200, 200, 300, 300)


def test_a_crop_is_a_part_of_the_picture(pathtracer, tmp_path):
    view = views.crops("core", ("penumbra",), (64, 48), (20, 12))[1]
    pictures = []
    for options in (view.options, view.camera):
        run_pathtracer(pathtracer, [*Request("blue", 2, 3, view.scene, 64, 48, more=options).arguments(), "--quiet", "-o",
                                    tmp_path / "a.exr"])
        pictures.append(read_exr(tmp_path / "a.exr")[0])
    x0, y0, x1, y1 = view.crop
    assert pictures[0].shape == (12, 20, 3) and np.array_equal(pictures[0], pictures[1][y0:y1, x0:x1])


def test_a_request_names_the_camera():
    view = views.chosen("core", ("glass",))[1]
    words = view.request("sobol", 4, 9, declared=4).arguments()
    assert words[words.index("--eye") + 1] == view.camera[1] and f"{view.width}x{view.height}" in words
    assert words[words.index("--declare") + 1] == "4"


def test_options():
    parser = argparse.ArgumentParser()
    views.add_options(parser)
    assert parser.parse_args([]).views == "core" and views.of(parser, parser.parse_args([])) == views.crops("core")
    assert views.of(parser, parser.parse_args(["--quick", "--views", "tuning"])) == views.chosen("tuning")
    with pytest.raises(SystemExit):
        views.of(parser, parser.parse_args(["--size", "64x48", "--crop", "33x24"]))
    assert parser.parse_args(["--scenes", "lens,cornell"]).scenes == ("cornell", "lens")
    with pytest.raises(SystemExit):
        parser.parse_args(["--scenes", "attic"])
