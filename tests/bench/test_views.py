# SPDX-License-Identifier: Apache-2.0
"""The views used to compare samplers."""

import argparse
import itertools
import math
import subprocess

import pytest
from report import views


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


def test_sets_are_what_they_say():
    core, tuning, held_out = (set(views.chosen(name)) for name in ("core", "tuning", "held-out"))
    assert len(core) == 12 and core < tuning and not tuning & held_out and tuning | held_out == set(views.ALL)
    assert {view.scene for view in core} == {view.scene for view in held_out} == set(views.SCENES)
    assert views.chosen("core", ("lens",), (32, 24))[0].size == (32, 24)


def test_a_request_names_the_camera():
    view = views.chosen("core", ("glass",))[1]
    words = view.request("sobol", 4, 9, declared=4).arguments()
    assert words[words.index("--eye") + 1] == view.camera[1] and f"{view.width}x{view.height}" in words
    assert words[words.index("--declare") + 1] == "4"


def test_options():
    parser = argparse.ArgumentParser()
    views.add_options(parser)
    assert parser.parse_args([]).views == "core" and parser.parse_args(["--all-views"]).views == "all"
    assert parser.parse_args(["--scenes", "lens,cornell"]).scenes == ("cornell", "lens")
    with pytest.raises(SystemExit):
        parser.parse_args(["--scenes", "attic"])
