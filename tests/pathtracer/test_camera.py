# SPDX-License-Identifier: Apache-2.0
"""Where the camera stands and looks: --camera, --eye, --target, --fov and the list of cameras."""

import numpy as np
import pytest
from pathtracer_driver import SCENES, assert_same, read_exr, read_layers
from scene_files import CORNELL_CAMERA, DOWN, cornell, floor

SMALL = ["--size", "24x24", "--spp", 1]


def options_of(line):
    """The options of a line of the list."""
    number, *options = line.split()
    assert number == "0"
    return options[:6]


@pytest.mark.parametrize("scene", SCENES)
def test_the_listed_camera_is_the_one_of_the_scene(pathtracer, scene):
    listing = pathtracer.run("--scene", scene, "--list-cameras")
    assert listing.returncode == 0 and listing.stderr == ""
    (line,) = listing.stdout.splitlines()
    given = pathtracer.render("--scene", scene, *SMALL, *options_of(line))
    own = pathtracer.render("--scene", scene, *SMALL)
    assert_same(read_layers(given), read_layers(own))
    assert read_exr(own)[1]["camera"] == "--camera 0 " + " ".join(options_of(line))


def test_eye_target_and_angle(pathtracer):
    """A floor two wide and one unit below fills a picture of 90 degrees, and the middle half of one twice as wide."""
    path = floor().save(pathtracer.folder / "floor.glb")
    common = ["--scene", path, *SMALL, "--max-depth", 0]
    # Looking straight down, -z is up in the picture; from 1e6 up, nothing of the place may be lost.
    for height, fov in ((1, 90), (2, 2 * np.degrees(np.arctan(0.5)))):
        layers = read_layers(pathtracer.render(*common, "--eye", f"0,{height},0", "--target", "0,0,0", "--fov", fov))
        assert (layers["A"] == 1).all()
        np.testing.assert_allclose(layers["depth.Z"], height, rtol=1e-5)
    for x, z, rows, columns in ((0, 0, slice(6, 18), slice(6, 18)), (1, 0, slice(6, 18), slice(12)), (0, -1, slice(12, 24), slice(6, 18))):
        shown = read_layers(pathtracer.render(*common, "--eye", f"{x},2,{z}", "--target", f"{x},0,{z}", "--fov", 90))["A"]
        assert (shown[rows, columns] == 1).all() and shown.sum() == 144


def test_what_is_not_given_stays(pathtracer):
    own = "--camera 0 --eye 278,273,-800 --target 278,273,0 --fov "
    camera = lambda *arguments: read_exr(pathtracer.render(*SMALL, *arguments))[1]["camera"]
    assert camera("--fov", 20) == own + "20"
    assert camera("--eye", "278,273,-900").startswith("--camera 0 --eye 278,273,-900 --target 278,273,0 --fov 39.3")
    assert camera("--target", "0,0,0").startswith("--camera 0 --eye 278,273,-800 --target 0,0,0 --fov 39.3")


def test_the_place_of_a_file_is_its_own(pathtracer):
    """Eye and target are in the coordinates of the file, also far from its origin, as is the list."""
    shift = np.array([3e6, -2e6, 1e6])
    near = cornell().save(pathtracer.folder / "near.glb")
    far = cornell(shift=shift).save(pathtracer.folder / "far.glb")
    place = lambda p: ",".join(repr(float(v)) for v in p)
    eye, target = np.array([200, 300, -700]), np.array([300, 200, 100])
    images = [pathtracer.image("--scene", path, *SMALL, "--max-depth", 1, "--eye", place(eye + by), "--target", place(target + by))
              for path, by in ((near, np.zeros(3)), (far, shift))]
    # Vertices may round differently; those of a file hold seven digits before its node moves them.
    assert (np.abs(images[0] - images[1]) > 1e-3).mean() < 0.02
    line = pathtracer.run("--scene", far, "--list-cameras").stdout
    listed = [float(v) for v in line.split()[2].split(",")]
    np.testing.assert_allclose(listed, shift + CORNELL_CAMERA["translation"], rtol=1e-9)


def test_cameras_of_a_file_by_number(pathtracer):
    g = floor()
    g.camera(np.pi / 2, translation=[0, 1, 0], rotation=DOWN, name="close")
    g.camera(np.pi / 2, translation=[0, 2, 0], rotation=DOWN, name="far off")
    path = g.save(pathtracer.folder / "two.glb")
    depth = lambda *a: read_layers(pathtracer.render("--scene", path, *SMALL, *a))["depth.Z"][12, 12]
    assert depth() == pytest.approx(1) and depth("--camera", 0) == pytest.approx(1)
    assert depth("--camera", 1) == pytest.approx(2)
    assert depth("--camera", 1, "--eye", "0,3,0") == pytest.approx(3)
    lines = pathtracer.run("--scene", path, "--list-cameras").stdout.splitlines()
    assert len(lines) == 2 and "'close'" in lines[0] and lines[1].startswith("1") and "'far off'" in lines[1]
    said = ("two.glb", "no camera 2", "0 'close'", "1 'far off'")
    pathtracer.failure("--scene", path, "--camera", 2, "-o", "out.exr", said=said)
    said = pathtracer.run("--scene", path, *SMALL, "-o", "out.exr").stderr
    assert "first of 2 cameras" in said and "--camera" in said
    assert pathtracer.run("--scene", path, *SMALL, "--camera", 0, "-o", "out.exr").stderr == ""


def test_a_file_without_cameras(pathtracer):
    path = floor().save(pathtracer.folder / "none.glb")
    pathtracer.failure("--scene", path, "--camera", 0, "-o", "out.exr", said=["none", "--eye"])
    listing = pathtracer.run("--scene", path, "--list-cameras").stdout
    assert "none" in listing and "--eye" in listing and "--fov" in listing
