# SPDX-License-Identifier: Apache-2.0
"""Scenes from files: what they say is what is rendered, wherever and however large it is; and cameras of all scenes.

Most images are known without rendering, or are those of another file that says the same in another way. Seeds are fixed.
"""

import numpy as np
import pytest
from pathtracer_driver import SCENES, assert_same, read_exr, read_layers
from scene_files import COMPONENT_TYPES, DOWN, QUAD, ROOM_EYE, SIX, SMALL, Gltf, ball, floor, over_floor, picture, room

# ---- The same scene said in other ways


def test_a_furnace_from_a_file(pathtracer):
    """Walls that emit and reflect one half: three bounces add 7/8 to the emission, by lamps and by what is hit."""
    light = np.array([2, 1.5, 0.5])
    g = Gltf()
    glow = g.material(**g.glow(light, 2))
    bottom = QUAD - np.float32([0, 1, 0])
    for axis in range(3):
        wall = np.roll(bottom, axis, axis=1)
        g.quads([wall, -wall[::-1]], glow)
    image = picture(pathtracer, g, "--spp", 64, "--max-depth", 3, "--eye", "0,0,0", "--target", "0,-1,-1", "--fov", 90)
    np.testing.assert_allclose(image.mean(axis=(0, 1)), 1.875 * light, rtol=0.01)


@pytest.mark.parametrize("scale, shift_in_sizes", [(1e-4, 0), (1e4, 0), (1, 1000), (1e-4, 1000), (1e4, 1000)])
def test_scale_and_place_do_not_matter(pathtracer, scale, shift_in_sizes):
    """The same samples give the same picture, but for the few paths that rounding sends elsewhere."""
    plain = picture(pathtracer, room(), "--spp", 4)
    shift = shift_in_sizes * 2 * scale * np.array([1, -1, 0.5])
    moved = picture(pathtracer, room(scale, shift), "--spp", 4)
    assert np.mean(np.abs(moved - plain) > 0.01 * plain) < 0.05
    assert moved.mean() == pytest.approx(plain.mean(), rel=0.01)


def staircase(nest):
    """A tilted quad under a light; `nest` places it in the tree."""
    g = Gltf()
    mesh = g.mesh(QUAD, SIX, g.material((0.6, 0.5, 0.4)), NORMAL=np.tile(np.float32([0.1, 0.9, 0]), (4, 1)))
    nest(g, mesh)
    g.light("point", 5, translation=[0.5, 2, 0.3])
    return over_floor(g, 4)


def test_nodes_and_matrices(pathtracer):
    """Turned by 0.3 about z, scaled by (1, 2, 0.5), moved: in one node, as a matrix, in a row of nodes."""
    c, s = np.cos(0.3), np.sin(0.3)
    turn = {"rotation": [0, 0, float(np.sin(0.15)), float(np.cos(0.15))]}
    scale, move = {"scale": [1, 2, 0.5]}, {"translation": [0.2, -0.3, 0.1]}
    matrix = [c, s, 0, 0, -2 * s, 2 * c, 0, 0, 0, 0, 0.5, 0, 0.2, -0.3, 0.1, 1]

    def row(g, mesh):
        inner = g.node(root=False, mesh=mesh, **scale)
        g.node(children=[g.node(root=False, children=[inner], **turn)], **move)

    expected = picture(pathtracer, staircase(lambda g, mesh: g.node(mesh=mesh, **turn, **scale, **move)), "--spp", 4)
    assert 0.05 < expected.mean() < 1
    for nest in (lambda g, mesh: g.node(mesh=mesh, matrix=[float(m) for m in matrix]), row):
        np.testing.assert_allclose(picture(pathtracer, staircase(nest), "--spp", 4), expected, rtol=2e-4, atol=1e-5)


def test_mirrored_nodes_keep_fronts(pathtracer):
    """A light that shines from its front only still faces down after two mirrors, and after one that is made up for by
    the order of its corners."""

    def lamp(corners, **node):
        g = floor()
        g.quads([corners], g.material((0, 0, 0), emissiveFactor=[2, 2, 2]), **node)
        return over_floor(g, 0.9)

    above = QUAD * 0.5 + np.float32([0, 1, 0])
    down, up = above[::-1], above
    lit = picture(pathtracer, lamp(down), "--spp", 8)
    assert lit.mean() > 0.1
    assert picture(pathtracer, lamp(up), "--spp", 8).mean() == 0
    for corners, scale in ((down, [-1, 1, 1]), (down, [-1, 1, -1]), (up * [1, -1, 1], [1, -1, 1])):
        mirrored = picture(pathtracer, lamp(np.float32(corners), scale=scale), "--spp", 8)
        assert mirrored.mean() == pytest.approx(lit.mean(), rel=0.02), scale


@pytest.mark.parametrize("way", ["uint8", "uint32", "none", "strip", "fan", "sparse", "sparse indices", "strided", "quantised",
                                 "normalized"])
def test_ways_to_store_a_mesh(pathtracer, way):
    """A square in every way a glTF can hold it: albedo on the floor, nothing beside it, in each the same."""

    def scene(way):
        g = Gltf()
        material = g.material((0.25, 0.5, 0.75))  # the back is not seen
        # Rows of so many numbers, the place of the first of them, what they are multiplied by
        rows = {"strided": (np.float32, 5, 1, 1), "quantised": (np.int8, 4, 0, 1), "normalized": (np.int16, 4, 0, 32767)}
        positions, indices, mode = QUAD, SIX, None
        if way in ("uint8", "uint32"):
            indices = SIX.astype(way)
        elif way == "none":
            positions, indices = QUAD[SIX], None
        elif way == "strip":
            indices, mode = np.array([1, 2, 0, 3], np.uint16), 5
        elif way == "fan":
            indices, mode = np.array([1, 2, 3, 0], np.uint16), 6
        elif way == "sparse":
            g.accessor(QUAD * np.float32([1, 1, 0]))
            positions = g.accessor(np.zeros((4, 3), np.float32))
            del g.json["accessors"][positions]["bufferView"]
            changed = {"bufferView": g.view(bytes(range(4))), "componentType": 5121}
            values = {"bufferView": g.view(QUAD.tobytes())}
            g.json["accessors"][positions]["sparse"] = {"count": 4, "indices": changed, "values": values}
        elif way == "sparse indices":  # of zeros, which make faces without area
            changed = {"bufferView": g.view(np.arange(6, dtype=np.uint16).tobytes()), "componentType": 5123}
            values = {"bufferView": g.view(SIX.tobytes())}
            indices = g.add("accessors", componentType=5123, count=21, type="SCALAR",
                            sparse={"count": 6, "indices": changed, "values": values})
        elif way in rows:
            kind, width, first, scale = rows[way]
            stored = np.full((4, width), 99, kind)
            stored[:, first:first + 3] = QUAD * scale
            positions = g.add("accessors", bufferView=g.view(stored.tobytes(), byteStride=stored.strides[0]), count=4, type="VEC3",
                              byteOffset=first * stored.itemsize, componentType=COMPONENT_TYPES[stored.dtype.name],
                              normalized=way == "normalized")
        g.node(mesh=g.mesh(positions, indices, material, mode))
        g.light("directional", 2, rotation=DOWN)
        return over_floor(g, 4, 0.9)

    image = picture(pathtracer, scene(way), "--spp", 2)
    np.testing.assert_allclose(image, picture(pathtracer, scene("uint16"), "--spp", 2), rtol=1e-4)
    np.testing.assert_allclose(image[12, 12], 2 / np.pi * np.array([0.25, 0.5, 0.75]), rtol=1e-4)
    assert (image[0] == 0).all()


# ---- Cameras and skies

ONE = [*SMALL, "--spp", 1]


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
    given = pathtracer.render("--scene", scene, *ONE, *options_of(line))
    own = pathtracer.render("--scene", scene, *ONE)
    assert_same(read_layers(given), read_layers(own))
    assert read_exr(own)[1]["camera"] == "--camera 0 " + " ".join(options_of(line))


def test_eye_target_and_angle(pathtracer):
    """A floor two wide and one unit below fills a picture of 90 degrees, and the middle half of one twice as wide."""
    path = floor().save(pathtracer.folder / "floor.glb")
    common = ["--scene", path, *ONE, "--max-depth", 0]
    # Looking straight down, -z is up in the picture; from 1e6 up, nothing of the place may be lost.
    for height, fov in ((1, 90), (2, 2 * np.degrees(np.arctan(0.5)))):
        layers = read_layers(pathtracer.render(*common, "--eye", f"0,{height},0", "--target", "0,0,0", "--fov", fov))
        assert (layers["A"] == 1).all()
        np.testing.assert_allclose(layers["depth.Z"], height, rtol=1e-5)
    for x, z, rows, columns in ((0, 0, slice(6, 18), slice(6, 18)), (1, 0, slice(6, 18), slice(12)), (0, -1, slice(12, 24), slice(6, 18))):
        shown = read_layers(pathtracer.render(*common, "--eye", f"{x},2,{z}", "--target", f"{x},0,{z}", "--fov", 90))["A"]
        assert (shown[rows, columns] == 1).all() and shown.sum() == 144


def test_camera_options_default_to_the_scene(pathtracer):
    own = "--camera 0 --eye 278,273,-800 --target 278,273,0 --fov "
    camera = lambda *arguments: read_exr(pathtracer.render(*ONE, *arguments))[1]["camera"]
    assert camera("--fov", 20) == own + "20"
    assert camera("--eye", "278,273,-900").startswith("--camera 0 --eye 278,273,-900 --target 278,273,0 --fov 39.3")
    assert camera("--target", "0,0,0").startswith("--camera 0 --eye 278,273,-800 --target 0,0,0 --fov 39.3")


def test_cameras_of_scenes_far_from_the_origin(pathtracer):
    """Eye and target are in the coordinates of the file, also far from its origin, as is the list."""
    shift = np.array([3e4, -2e4, 1e4])
    near = room().save(pathtracer.folder / "near.glb")
    far = room(shift=shift).save(pathtracer.folder / "far.glb")
    place = lambda p: ",".join(repr(float(v)) for v in p)
    eye, target = np.array([0.3, 1.2, 3.5]), np.array([-0.1, 0.8, 0])
    images = [pathtracer.image("--scene", path, *ONE, "--max-depth", 1, "--eye", place(eye + by), "--target", place(target + by))
              for path, by in ((near, np.zeros(3)), (far, shift))]
    # Vertices may round differently; those of a file hold seven digits before its node moves them.
    assert (np.abs(images[0] - images[1]) > 1e-3).mean() < 0.02
    line = pathtracer.run("--scene", far, "--list-cameras").stdout
    listed = [float(v) for v in line.split()[2].split(",")]
    np.testing.assert_allclose(listed, shift + ROOM_EYE, rtol=1e-9)


def test_cameras_of_a_file_by_number(pathtracer):
    g = floor()
    g.camera(np.pi / 2, translation=[0, 1, 0], rotation=DOWN, name="close")
    g.camera(np.pi / 2, translation=[0, 2, 0], rotation=DOWN, name="far off")
    path = g.save(pathtracer.folder / "two.glb")
    depth = lambda *a: read_layers(pathtracer.render("--scene", path, *ONE, *a))["depth.Z"][12, 12]
    assert depth() == pytest.approx(1) and depth("--camera", 0) == pytest.approx(1)
    assert depth("--camera", 1) == pytest.approx(2)
    assert depth("--camera", 1, "--eye", "0,3,0") == pytest.approx(3)
    lines = pathtracer.run("--scene", path, "--list-cameras").stdout.splitlines()
    assert len(lines) == 2 and "'close'" in lines[0] and lines[1].startswith("1") and "'far off'" in lines[1]
    said = ("two.glb", "no camera 2", "has 2 of its own", "--list-cameras")
    pathtracer.failure("--scene", path, "--camera", 2, "-o", "out.exr", said=said)
    said = pathtracer.run("--scene", path, *ONE, "-o", "out.exr").stderr
    assert "first of 2 cameras" in said and "--camera" in said
    assert pathtracer.run("--scene", path, *ONE, "--camera", 0, "-o", "out.exr").stderr == ""


def test_a_file_without_cameras(pathtracer):
    path = floor().save(pathtracer.folder / "none.glb")
    pathtracer.failure("--scene", path, "--camera", 0, "-o", "out.exr", said=["no camera 0", "has 0 of its own", "--eye"])
    listing = pathtracer.run("--scene", path, "--list-cameras").stdout
    assert "none" in listing and "--eye" in listing and "--fov" in listing


def test_without_a_camera_everything_is_in_the_image(pathtracer, even_sky):
    """Of things long and flat, tiny and large: all of each, with room around, and not less than half of the picture."""
    for scale in ([1, 1, 1], [5, 1, 1], [1e3, 1e4, 1e3], [1e-5, 1e-5, 3e-5]):
        g = Gltf()
        ball(g, g.material((0, 0, 0)))
        g.json["nodes"][0].update(scale=scale, translation=[700, -50, 20])
        dark = picture(pathtracer, g, "--spp", 1, "--env", even_sky)[..., 0] < 0.5
        rows, columns = np.where(dark)
        assert len(rows) > 0
        extent = max(np.ptp(rows), np.ptp(columns)) + 1
        assert 12 <= extent <= 24, scale
        assert not (dark[0].any() or dark[-1].any() or dark[:, 0].any() or dark[:, -1].any()), scale


def test_lamps_replace_the_sky_and_glows_do_not(pathtracer):
    """A speck of emission 1 is a glow, one of a little more a lamp, and so is any punctual light; without either there is sky."""

    def scene(radiance):
        g = floor()
        g.quads([0.01 * QUAD + np.float32([0, 9, 0])], g.material((0, 0, 0), **g.glow((radiance, 0.5, 0), radiance)))
        return over_floor(g)

    glow, lamp = scene(1), scene(1.01)
    for dim in (floor(), glow):
        assert picture(pathtracer, dim, "--spp", 4).mean() > 0.1
        assert picture(pathtracer, dim, "--spp", 4, "--env", "none").mean() < 1e-3
    assert picture(pathtracer, lamp, "--spp", 4).mean() < 1e-3
    assert picture(pathtracer, lamp, "--spp", 4, "--env", "sky").mean() > 0.1
    g = floor()
    g.light("point", 1e-3, translation=[0, 1, 0])
    assert picture(pathtracer, over_floor(g), "--spp", 4).mean() < 1e-3


def test_ignored_features_are_named_once(pathtracer):
    g = floor()
    g.add("animations", channels=[], samplers=[])
    skin = g.add("skins", joints=[0])
    g.json["nodes"][0]["skin"] = skin
    mesh = g.json["meshes"][0]["primitives"]
    mesh.append({**mesh[0], "mode": 1})
    mesh.append({**mesh[0], "mode": 0})
    mesh[0]["targets"] = [{"POSITION": mesh[0]["attributes"]["POSITION"]}]
    g.use("VENDOR_thing")
    g.material(extensions={"KHR_materials_sheen": {}})
    g.node(camera=g.add("cameras", type="orthographic", orthographic={"xmag": 1, "ymag": 1, "znear": 1, "zfar": 2}))
    path = g.save(pathtracer.folder / "odd.gltf")
    arguments = ["--scene", path, *SMALL, "--spp", 1, "-o", "out.exr"]
    done = pathtracer.success(*arguments)
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"pathtracer: {path}: ignores ")
    for name in ("animations", "skins", "morph targets", "points and lines", "VENDOR_thing", "orthographic cameras"):
        assert done.stderr.count(name) == 1, name
    assert "sheen" not in done.stderr  # nothing has that material
    assert pathtracer.run(*arguments, "--quiet").stderr == ""
