# SPDX-License-Identifier: Apache-2.0
"""Tests that scenes from files are rendered as described, at any scale and position, and tests the cameras of all scenes.

Most images are known without rendering, or must equal those of a file that describes the same scene differently. Seeds are fixed.
"""

import numpy as np
import pytest
import scene_files as files
from pathtracer_driver import SCENES, assert_same, read_exr, read_layers
from scene_files import COMPONENT_TYPES, DOWN, ONE, QUAD, ROOM_EYE, SIX, Gltf, ball, floor, over_floor, picture, room


def test_furnace_from_a_file(pathtracer):
    """The walls emit light and reflect one half of it, so three bounces add 7/8 of the emission, by light samples and by hits."""
    light, g = np.array([2, 1.5, 0.5]), Gltf()
    for axis in range(3):
        wall = np.roll(QUAD - np.float32([0, 1, 0]), axis, axis=1)
        g.quads([wall, -wall[::-1]], g.material(**g.glow(light, 2)))
    image = picture(pathtracer, g, "--spp", 64, "--max-depth", 3, "--eye", "0,0,0", "--target", "0,-1,-1", "--fov", 90)
    np.testing.assert_allclose(image.mean(axis=(0, 1)), 1.875 * light, rtol=0.01)


@pytest.mark.parametrize("scale, shift_in_sizes", [(1e-4, 0), (1e4, 0), (1, 1000), (1e-4, 1000), (1e4, 1000)])
def test_scale_and_position_do_not_change_the_image(pathtracer, scale, shift_in_sizes):
    """The same samples give the same image, except for the few paths that rounding changes."""
    plain = picture(pathtracer, room(), "--spp", 4)
    shift = shift_in_sizes * 2 * scale * np.array([1, -1, 0.5])
    moved = picture(pathtracer, room(scale, shift), "--spp", 4)
    assert np.mean(np.abs(moved - plain) > 0.01 * plain) < 0.05
    assert moved.mean() == pytest.approx(plain.mean(), rel=0.01)


def test_node_transforms_matrices_and_nested_nodes_agree(pathtracer):
    """A rotation by 0.3 about z, a scale by (1, 2, 0.5) and a translation are stored in one node, as a matrix, and in nested nodes."""
    c, s = np.cos(0.3), np.sin(0.3)
    turn = {"rotation": [0, 0, np.sin(0.15), np.cos(0.15)]}
    scale, move = {"scale": [1, 2, 0.5]}, {"translation": [0.2, -0.3, 0.1]}
    matrix = [c, s, 0, 0, -2 * s, 2 * c, 0, 0, 0, 0, 0.5, 0, 0.2, -0.3, 0.1, 1]

    def row(g, mesh):
        inner = g.node(root=False, mesh=mesh, **scale)
        g.node(children=[g.node(root=False, children=[inner], **turn)], **move)

    def image(place):
        g = Gltf()
        place(g, g.mesh(QUAD, SIX, g.material((0.6, 0.5, 0.4)), NORMAL=np.tile(np.float32([0.1, 0.9, 0]), (4, 1))))
        g.light("point", 5, translation=[0.5, 2, 0.3])
        return picture(pathtracer, over_floor(g, 4), "--spp", 4)

    expected = image(lambda g, mesh: g.node(mesh=mesh, **turn, **scale, **move))
    assert 0.05 < expected.mean() < 1
    for place in (lambda g, mesh: g.node(mesh=mesh, matrix=matrix), row):
        np.testing.assert_allclose(image(place), expected, rtol=2e-4, atol=1e-5)


def test_mirrored_nodes_keep_front_faces(pathtracer):
    """A single-sided light still faces down if its node mirrors two axes, and if it mirrors one, which reverses the winding."""

    def lit(corners, **node):
        g = floor()
        g.quads([corners], g.material((0, 0, 0), emissiveFactor=[2, 2, 2]), **node)
        return picture(pathtracer, over_floor(g, 0.9), "--spp", 8).mean()

    up = QUAD * 0.5 + np.float32([0, 1, 0])
    down = up[::-1]
    assert lit(down) > 0.1 and lit(up) == 0
    for corners, scale in ((down, [-1, 1, 1]), (down, [-1, 1, -1]), (up * np.float32([1, -1, 1]), [1, -1, 1])):
        assert lit(corners, scale=scale) == pytest.approx(lit(down), rel=0.02), scale


def sparse(g, values, count, places):
    """Adds an accessor whose first elements are `values` and whose other elements are zeros."""
    number = g.accessor(values)
    accessor = g.json["accessors"][number]
    indices = {"bufferView": g.view(np.arange(len(values), dtype=places).tobytes()), "componentType": COMPONENT_TYPES[places]}
    accessor.update(count=count, sparse={"count": len(values), "indices": indices, "values": {"bufferView": accessor.pop("bufferView")}})
    return number


def stored(g, kind, width, first, scale=1, **properties):
    """Adds an accessor of the scaled square. Each corner is stored in a row of `width` numbers, from index `first`."""
    rows = np.full((4, width), 99, kind)
    rows[:, first:first + 3] = QUAD * scale
    return g.add("accessors", bufferView=g.view(rows.tobytes(), byteStride=rows.strides[0]), count=4, type="VEC3",
                 byteOffset=first * rows.itemsize, componentType=COMPONENT_TYPES[kind], **properties)


# Each function returns positions, indices and an optional mode
WAYS = {
    "uint8 indices": lambda g: (QUAD, SIX.astype("uint8")),
    "uint32 indices": lambda g: (QUAD, SIX.astype("uint32")),
    "no indices": lambda g: (QUAD[SIX], None),
    "triangle strip": lambda g: (QUAD, np.uint16([1, 2, 0, 3]), 5),
    "triangle fan": lambda g: (QUAD, np.uint16([1, 2, 3, 0]), 6),
    "sparse positions": lambda g: (sparse(g, QUAD, 4, "uint8"), SIX),
    "sparse indices": lambda g: (QUAD, sparse(g, SIX, 21, "uint16")),  # the other indices are zeros: triangles without area
    "strided positions": lambda g: (stored(g, "float32", 5, 1), SIX),
    "quantised positions": lambda g: (stored(g, "int8", 4, 0), SIX),
    "normalized positions": lambda g: (stored(g, "int16", 4, 0, 32767, normalized=True), SIX),
}


@pytest.mark.parametrize("way", WAYS)
def test_storage_formats_of_meshes(pathtracer, way):
    """A square gives the same image however it is stored: its albedo where it is visible, and black around it."""

    def image(way):
        g = Gltf()
        positions, indices, *mode = way(g)
        g.node(mesh=g.mesh(positions, indices, g.material((0.25, 0.5, 0.75)), *mode))  # the back is invisible
        g.light("directional", 2, rotation=DOWN)
        return picture(pathtracer, over_floor(g, 4, 0.9), "--spp", 2)

    found = image(WAYS[way])
    np.testing.assert_allclose(found, image(lambda g: (QUAD, SIX)), rtol=1e-4)
    np.testing.assert_allclose(found[12, 12], 2 / np.pi * np.array([0.25, 0.5, 0.75]), rtol=1e-4)
    assert (found[0] == 0).all()


@pytest.mark.parametrize("scene", SCENES)
def test_the_listed_camera_reproduces_the_scenes_image(pathtracer, scene):
    listing = pathtracer.success("--scene", scene, "--list-cameras")
    (line,) = listing.stdout.splitlines()
    number, *options = line.split()[:7]
    assert number == "0" and listing.stderr == ""
    own = pathtracer.render("--scene", scene, *ONE)
    assert_same(pathtracer.layers("--scene", scene, *ONE, *options), read_layers(own))
    assert read_exr(own)[1]["camera"] == "--camera 0 " + " ".join(options)


def test_eye_target_and_fov(pathtracer):
    """A floor two units wide, seen from one unit above, fills an image of 90 degrees. From twice as far, it fills the middle half."""
    common = ["--scene", floor(), *ONE, "--max-depth", 0]
    # Looking straight down, -z is up in the image.
    for height, fov in ((1, 90), (2, 2 * np.degrees(np.arctan(0.5)))):
        layers = pathtracer.layers(*common, "--eye", f"0,{height},0", "--target", "0,0,0", "--fov", fov)
        assert (layers["A"] == 1).all()
        np.testing.assert_allclose(layers["depth.Z"], height, rtol=1e-5)
    for x, z, rows, columns in ((0, 0, slice(6, 18), slice(6, 18)), (1, 0, slice(6, 18), slice(12)), (0, -1, slice(12, 24), slice(6, 18))):
        shown = pathtracer.layers(*common, "--eye", f"{x},2,{z}", "--target", f"{x},0,{z}", "--fov", 90)["A"]
        assert (shown[rows, columns] == 1).all() and shown.sum() == 144


def test_lens_and_focus(pathtracer):
    """A floor that fills the middle of an image has sharp edges through a pinhole and in focus, by default at the target. Out of focus at
    twice the distance, they blur by the radius of the lens, here 1.8 pixels."""
    view = ["--scene", floor(), *ONE, "--spp", 64, "--max-depth", 0, "--eye", "0,2,0", "--target", "0,0,0", "--fov", 90]
    for options, sharp in (([], True), (["--lens", 0.3], True), (["--focus", 2, "--lens", 1], True),
                           (["--focus", 1, "--lens", 0.3], False)):
        seen = pathtracer.layers(*view, *options)["A"]
        partial = (seen > 0) & (seen < 1)
        for blurred in (partial[9:15].any(axis=0), partial[:, 9:15].any(axis=1)):
            assert [*np.flatnonzero(blurred)] == ([] if sharp else [4, 5, 6, 7, 16, 17, 18, 19]), options
        assert seen.sum() == pytest.approx(144, rel=0.1), options


def test_camera_options_default_to_the_scenes_camera(pathtracer):
    camera = lambda *arguments: pathtracer.header(*ONE, *arguments)["camera"]
    assert camera("--fov", 20) == "--camera 0 --eye 278,273,-800 --target 278,273,0 --fov 20"
    assert camera("--eye", "278,273,-900").startswith("--camera 0 --eye 278,273,-900 --target 278,273,0 --fov 39.3")
    assert camera("--target", "0,0,0").startswith("--camera 0 --eye 278,273,-800 --target 0,0,0 --fov 39.3")


def test_cameras_of_scenes_far_from_the_origin(pathtracer):
    """--eye, --target and --list-cameras use the file's coordinates, even far from the origin."""
    shift = np.array([3e4, -2e4, 1e4])
    place = lambda by, *p: ",".join(map(str, p + by))
    images = [pathtracer.image("--scene", room(shift=by), *ONE, "--max-depth", 1, "--eye", place(by, 0.3, 1.2, 3.5),
                               "--target", place(by, -0.1, 0.8, 0)) for by in (0 * shift, shift)]
    # Vertices may round differently: the file stores seven digits before its node moves them.
    assert (np.abs(images[0] - images[1]) > 1e-3).mean() < 0.02
    line = pathtracer.success("--scene", room(shift=shift), "--list-cameras").stdout
    np.testing.assert_allclose([float(v) for v in line.split()[2].split(",")], shift + ROOM_EYE, rtol=1e-9)


def test_cameras_of_a_file_are_chosen_by_number(pathtracer):
    listing = pathtracer.success("--scene", floor(), "--list-cameras").stdout
    assert all(word in listing for word in ("none", "--eye", "--fov"))
    pathtracer.failure("--scene", floor(), "--camera", 0, said=["no camera 0", "has 0 of its own", "--eye"])
    g = floor()
    g.camera(np.pi / 2, translation=[0, 1, 0], rotation=DOWN, name="close")
    g.camera(np.pi / 2, translation=[0, 2, 0], rotation=DOWN, name="far off")
    for options, expected in (([], 1), (["--camera", 0], 1), (["--camera", 1], 2), (["--camera", 1, "--eye", "0,3,0"], 3)):
        assert pathtracer.layers("--scene", g, *ONE, *options)["depth.Z"][12, 12] == pytest.approx(expected)
        assert "first of 2 cameras" in pathtracer.said and "--camera" in pathtracer.said if not options else pathtracer.said == ""
    close, far = pathtracer.success("--scene", g, "--list-cameras").stdout.splitlines()
    assert "'close'" in close and far.startswith("1") and "'far off'" in far
    pathtracer.failure("--scene", g, "--camera", 2, said=["scene.glb", "no camera 2", "has 2 of its own", "--list-cameras"])


def test_without_a_camera_the_whole_scene_is_visible(pathtracer, even_sky):
    """Long, flat, tiny and large objects are completely visible, with a margin, and extend over at least half of an image of any shape."""
    for scale, size in (([1, 1, 1], "24x24"), ([5, 1, 1], "24x24"), ([1e3, 1e4, 1e3], "24x24"), ([1e-5, 1e-5, 3e-5], "24x60"),
                        ([5, 1, 1], "24x96"), ([1, 1, 1], "60x24")):
        g = Gltf()
        ball(g, g.material((0, 0, 0)))
        g.json["nodes"][0].update(scale=scale, translation=[700, -50, 20])
        dark = picture(pathtracer, g, "--spp", 1, "--env", even_sky, "--size", size)[..., 0] < 0.5
        extent = max(np.ptp(places) for places in np.where(dark)) + 1
        assert 12 <= extent <= 24, scale
        assert not (dark[0].any() or dark[-1].any() or dark[:, 0].any() or dark[:, -1].any()), scale


def test_lamps_replace_the_sky_and_dim_emission_does_not(pathtracer):
    """A surface whose emission exceeds 1 is a lamp, as is any punctual light. Scenes without lamps get a sky."""

    def mean(*arguments, radiance=0, light=False):
        g = floor()
        if radiance:
            g.quads([0.01 * QUAD + np.float32([0, 9, 0])], g.material((0, 0, 0), **g.glow((radiance, 0.5, 0), radiance)))
        if light:
            g.light("point", 1e-3, translation=[0, 1, 0])
        return picture(pathtracer, over_floor(g), "--spp", 4, *arguments).mean()

    for dim in (0, 1):
        assert mean(radiance=dim) > 0.1 and mean("--env", "none", radiance=dim) < 1e-3
    assert mean(radiance=1.01) < 1e-3 and mean("--env", "sky", radiance=1.01) > 0.1
    assert mean(light=True) < 1e-3


def test_ignored_features_are_named_once(pathtracer):
    g = floor()
    g.add("animations", channels=[], samplers=[])
    g.json["nodes"][0]["skin"] = g.add("skins", joints=[0])
    mesh = g.json["meshes"][0]["primitives"]
    mesh += [{**mesh[0], "mode": mode} for mode in (0, 1)]
    mesh[0]["targets"] = [{"POSITION": mesh[0]["attributes"]["POSITION"]}]
    g.use("VENDOR_thing")
    g.material(extensions={"KHR_materials_sheen": {}})
    g.node(camera=g.add("cameras", type="orthographic", orthographic={"xmag": 1, "ymag": 1, "znear": 1, "zfar": 2}))
    path = g.save(pathtracer.folder / "odd.gltf")
    pathtracer.render("--scene", path, *ONE)
    said = pathtracer.said
    assert said.count("\n") == 1 and said.startswith(f"pathtracer: {path}: ignores ")
    for name in ("animations", "skins", "morph targets", "points and lines", "VENDOR_thing", "orthographic cameras"):
        assert said.count(name) == 1, name
    assert "sheen" not in said  # no surface uses that material
    pathtracer.render("--scene", path, *ONE, "--quiet")
    assert pathtracer.said == said == pathtracer.success("--scene", path, "--list-inputs").stderr


@pytest.mark.parametrize(("transmission", "said"), [
    ({"transmissionFactor": 0.3}, "partial transmission"), ({"transmissionFactor": 0.9}, "partial transmission"), ({}, ""),
    ({"transmissionFactor": 1, "transmissionTexture": {"index": 0}}, "textures of transmission")])
def test_partial_transmission_is_reported(pathtracer, transmission, said):
    g = floor()
    g.json["materials"][0]["extensions"]["KHR_materials_transmission"] = transmission
    pathtracer.render("--scene", g, *ONE)
    assert said in pathtracer.said and bool(said) == bool(pathtracer.said)


def test_primitives_share_arrays_and_textures_share_images(pathtracer, even_sky):
    """Hundreds of primitives that use a few of 90,000 vertices each, and textures of one large image, need little memory."""
    g, side = Gltf(), 300
    y, x = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side), indexing="ij")
    points = np.concatenate([np.stack([x, 0 * x, -y], -1).reshape(-1, 3), [[1e6, 0, 0]]]).astype(np.float32)  # the last is not used
    first = np.arange(side * (side - 1)).reshape(side - 1, side)[:, :-1].ravel()
    faces = (first[:, None] + [0, 1, side + 1, 0, side + 1, side]).astype(np.uint32)
    image = g.add("images", bufferView=g.view(files.encoded(np.full((4096, 4096), 188))))
    textures = [g.add("textures", source=image, sampler=g.add("samplers", wrapS=mode)) for mode in (10497, 33648, 33071)]
    materials = [g.material((1, 1, 1), pbr={"baseColorTexture": {"index": texture}}) for texture in textures]
    attributes = {"POSITION": g.accessor(points), "TEXCOORD_0": g.accessor(points[:, :2].copy())}
    parts = [{"attributes": attributes, "indices": g.accessor(part.ravel()), "material": materials[i % 3]}
             for i, part in enumerate(np.array_split(faces, 400))]
    g.node(mesh=g.add("meshes", primitives=parts))
    bound = [] if pathtracer.has_address_sanitizer else ["--max-memory", 0.3]
    expected = files.linear([188])[0]
    image = picture(pathtracer, over_floor(g), "--spp", 1, "--env", even_sky, "--max-depth", 1, *bound)
    np.testing.assert_allclose(image, expected, rtol=2e-3)
    pathtracer.render("--scene", g, *ONE, "--eye", "0,9,0", "--target", "0,99,0")
    assert "reaches from -1,0,-1 to 1,0,1" in pathtracer.said
