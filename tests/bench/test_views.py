# SPDX-License-Identifier: Apache-2.0
"""The views used to compare samplers."""

import itertools
import subprocess

import numpy as np
import pytest
from report.base.files import read_exr
from report.renders import views
from report.renders.renderer import Request, run_pathtracer


@pytest.mark.parametrize("scene", views.SCENES)
def test_cameras_are_those_of_the_scenes(pathtracer, scene):
    listed = subprocess.run([pathtracer, "--scene", scene, "--list-cameras"], check=True, capture_output=True, text=True).stdout
    words = listed.split()
    for name, own in zip(("--eye", "--target", "--fov"), views.CAMERAS[scene]):
        numbers = [float(number) for number in words[words.index(name) + 1].split(",")]
        assert numbers == pytest.approx(list(own) if isinstance(own, tuple) else [own], abs=2e-5)


def test_sets_share_no_view_and_no_camera():
    sets = [views.crops(name) for name in views.SETS]
    assert len(set().union(*sets)) == sum(map(len, sets)) == 3 * 4 * len(views.SCENES)
    cameras = [{view.camera for view in own} for own in sets]
    assert all(not a & b for a, b in itertools.combinations(cameras, 2))
    assert all({view.scene for view in own} == set(views.SCENES) for own in sets)


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


def test_a_crop_is_a_part_of_the_picture(pathtracer, tmp_path):
    view = views.crops("core", ("penumbra",), (64, 48), (20, 12))[1]
    pictures = []
    for options in (view.options, view.camera):
        run_pathtracer(pathtracer, [*Request("blue", 2, 3, view.scene, 64, 48, more=options).arguments(), "--quiet", "-o",
                                    tmp_path / "a.exr"])
        pictures.append(read_exr(tmp_path / "a.exr")[0])
    x0, y0, x1, y1 = view.crop
    assert pictures[0].shape == (12, 20, 3) and np.array_equal(pictures[0], pictures[1][y0:y1, x0:x1])
