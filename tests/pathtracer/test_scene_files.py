# SPDX-License-Identifier: Apache-2.0
"""Scenes from files: what they say is what is rendered, wherever and however large it is, and what is wrong with them
is one line.

Most pictures are known without rendering, or are those of another file that says the same in another way. Seeds are
fixed; the false-alarm rate of the statistical tests, had seeds been drawn anew, is stated with each.
"""

import json
import struct

import numpy as np
import OpenEXR
import pytest
from scene_files import (
    DOWN,
    QUAD,
    QUAD_COORDINATES,
    Gltf,
    cornell,
    cornell_obj,
    encoded,
    linear,
)
from scipy import stats

SMALL = ["--size", "24x24", "--threads", 1]
SIX = np.array([0, 1, 2, 0, 2, 3], np.uint16)


def write_environment(path, colour):
    texels = np.ascontiguousarray(np.broadcast_to(np.float32(colour), (4, 8, 3)))
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": texels}) as file:
        file.write(str(path))
    return path


@pytest.fixture
def even_sky(pathtracer):
    """An environment of radiance 1 all around: a diffuse surface in it shows its albedo, without noise."""
    return write_environment(pathtracer.folder / "even.exr", 1.0)


def picture(pathtracer, scene, *arguments, name="scene.glb"):
    return pathtracer.image("--scene", scene.save(pathtracer.folder / name), *SMALL, *arguments)


def over_floor(scene, height=1.0, yfov=0.4):
    """A camera that looks straight down on the origin, the top of the picture towards -z."""
    scene.camera(yfov, translation=[0, height, 0], rotation=DOWN)
    return scene


def floor(material=None, **node):
    g = Gltf()
    g.quads([QUAD], g.material((0.5, 0.5, 0.5)) if material is None else material, **node)
    return g


# ---- The same scene said in other ways


def part_means(image):
    image = image.astype(np.float64)
    quarters = image.reshape(2, 12, 2, 12, 3).mean(axis=(1, 3)).ravel()
    return np.concatenate([image.mean(axis=(0, 1)), quarters])


def test_the_cornell_box_from_a_file_is_the_one_built_in(pathtracer):
    """Welch's t-tests of the means of the picture and its quarters over 16 seeds each; false-alarm rate one in ten
    thousand."""
    path = cornell().save(pathtracer.folder / "cornell.glb")
    means = {}
    for scene, first_seed in ((path, 0), ("cornell", 100)):
        arguments = ["--scene", scene, *SMALL, "--spp", 16, "--sampler", "sobol"]
        means[scene] = [part_means(pathtracer.image(*arguments, "--seed", first_seed + i)) for i in range(16)]
    read, built = np.array(means[path]), np.array(means["cornell"])
    p_values = stats.ttest_ind(read, built, equal_var=False).pvalue
    assert np.nanmin(p_values) * len(p_values) > 1e-4
    # The test has teeth: a bias of a tenth in the means of the whole would be seen.
    deviation = np.hypot(read[:, 1].std(ddof=1), built[:, 1].std(ddof=1)) / 4
    assert 6 * deviation < 0.1 * built[:, 1].mean()


def test_the_cornell_box_as_obj(pathtracer):
    """Without a camera both are framed in the same way. Welch's t-tests over 16 seeds each; false-alarm rate one in ten
    thousand."""
    gltf = cornell(scale=(1, 1, -1), camera=False).save(pathtracer.folder / "framed.gltf")
    means = []
    for number, path in enumerate((gltf, cornell_obj(pathtracer.folder))):
        arguments = ["--scene", path, *SMALL, "--spp", 16, "--sampler", "sobol"]
        means.append([part_means(pathtracer.image(*arguments, "--seed", 50 * number + i)) for i in range(16)])
    p_values = stats.ttest_ind(*means, equal_var=False).pvalue
    assert np.nanmin(p_values) * len(p_values) > 1e-4
    assert np.mean(means) > 0.02


@pytest.mark.parametrize("scale, shift_in_sizes", [(1e-4, 0), (1e4, 0), (1, 1000), (1e-4, 1000), (1e4, 1000)])
def test_scale_and_place_do_not_matter(pathtracer, scale, shift_in_sizes):
    """The same samples give the same picture, but for the few paths that rounding sends elsewhere."""
    plain = picture(pathtracer, cornell(), "--spp", 4)
    shift = shift_in_sizes * 559.2 * scale * np.array([1, -1, 0.5])
    moved = picture(pathtracer, cornell(scale, shift), "--spp", 4)
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


def test_mirrors_keep_fronts_in_front(pathtracer):
    """A light that shines from its front only still faces down after two mirrors, and after one that is made up for by
    the order of its corners."""
    def lamp(corners, **node):
        g = floor()
        g.quads([corners], g.material((0, 0, 0), emissiveFactor=[1, 1, 1]), **node)
        return over_floor(g, 0.9)

    above = QUAD * 0.5 + np.float32([0, 1, 0])
    down, up = above[::-1], above
    lit = picture(pathtracer, lamp(down), "--spp", 8)
    assert lit.mean() > 0.1
    assert picture(pathtracer, lamp(up), "--spp", 8).mean() == 0
    for corners, scale in ((down, [-1, 1, 1]), (down, [-1, 1, -1]), (up * [1, -1, 1], [1, -1, 1])):
        mirrored = picture(pathtracer, lamp(np.float32(corners), scale=scale), "--spp", 8)
        assert mirrored.mean() == pytest.approx(lit.mean(), rel=0.02), scale


@pytest.mark.parametrize(
    "way", ["uint8", "uint32", "none", "strip", "fan", "sparse", "strided", "quantised", "normalized"]
)
def test_ways_to_store_a_mesh(pathtracer, way):
    """A square in every way a glTF can hold it: albedo on the floor, nothing beside it, in each the same."""
    def scene(way):
        g = Gltf()
        material = g.material((0.25, 0.5, 0.75), doubleSided=True)
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
            indices_view = g.view(np.arange(4, dtype=np.uint8).tobytes())
            g.json["accessors"][positions]["sparse"] = {
                "count": 4,
                "indices": {"bufferView": indices_view, "componentType": 5121},
                "values": {"bufferView": g.view(QUAD.tobytes())},
            }
        elif way == "strided":
            rows = np.full((4, 5), 99, np.float32)
            rows[:, 1:4] = QUAD
            view = g.view(rows.tobytes(), byteStride=20)
            positions = g.add("accessors", bufferView=view, byteOffset=4, componentType=5126, count=4, type="VEC3")
        elif way == "quantised":
            padded = np.zeros((4, 4), np.int8)
            padded[:, :3] = QUAD
            view = g.view(padded.tobytes(), byteStride=4)
            positions = g.add("accessors", bufferView=view, componentType=5120, count=4, type="VEC3")
        elif way == "normalized":
            padded = np.zeros((4, 4), np.int16)
            padded[:, :3] = 32767 * QUAD
            view = g.view(padded.tobytes(), byteStride=8)
            positions = g.add(
                "accessors", bufferView=view, componentType=5122, count=4, type="VEC3", normalized=True
            )
        g.node(mesh=g.mesh(positions, indices, material, mode))
        g.light("directional", 2, rotation=DOWN)
        return over_floor(g, 4, 0.9)

    image = picture(pathtracer, scene(way), "--spp", 2)
    np.testing.assert_allclose(image, picture(pathtracer, scene("uint16"), "--spp", 2), rtol=1e-4)
    np.testing.assert_allclose(image[12, 12], 2 / np.pi * np.array([0.25, 0.5, 0.75]), rtol=1e-4)
    assert (image[0] == 0).all()


def test_broken_faces_change_nothing(pathtracer):
    """Faces without area, double ones, needles, normals of length zero."""
    clean = cornell()
    broken = cornell()
    corners = np.array([[278, 200, 100], [300, 250, 120], [289, 225, 110], [0, 100, 10], [550, 100, 10]], np.float32)
    needle = np.array([[550, 100.00002, 10]], np.float32)
    faces = np.array([0, 0, 0, 0, 1, 1, 0, 1, 2, 3, 4, 5], np.uint16)
    zero = np.zeros((6, 3), np.float32)
    mesh = broken.mesh(np.concatenate([corners, needle]), faces, 0, NORMAL=zero)
    root = broken.json["nodes"][broken.json["scenes"][0]["nodes"][0]]
    root["children"] += [broken.node(root=False, mesh=mesh), broken.node(root=False, mesh=0)]
    expected, seen = picture(pathtracer, clean, "--spp", 8), picture(pathtracer, broken, "--spp", 8)
    assert np.isfinite(seen).all() and (seen >= 0).all()
    assert seen.mean() == pytest.approx(expected.mean(), rel=0.005)


# ---- Lights


def test_point_lights(pathtracer):
    """Candela over the distance squared."""
    g = floor()
    g.light("point", 10, (1, 0.5, 0.25), translation=[0, 2, 0])
    image = picture(pathtracer, over_floor(g, yfov=0.01), "--spp", 2)
    np.testing.assert_allclose(image[12, 12], 0.5 / np.pi * 10 / 4 * np.array([1, 0.5, 0.25]), rtol=1e-3)


def test_directional_lights(pathtracer):
    """Lux times the cosine, wherever the node stands."""
    g = floor()
    half = np.pi / 6  # half of 60 degrees, from looking along -z towards straight down
    g.light("directional", 3, translation=[5, -7, 100], rotation=[-np.sin(half), 0, 0, np.cos(half)])
    image = picture(pathtracer, over_floor(g), "--spp", 2)
    np.testing.assert_allclose(image, 0.5 / np.pi * 3 * np.sin(2 * half), rtol=1e-3)


def test_spot_lights(pathtracer):
    """Full within the inner cone, nothing beyond the outer one, the square of a ramp in the cosine between."""
    g = floor()
    cone = {"spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}
    g.light("spot", 4, translation=[0, 1, 0], rotation=DOWN, light=cone)
    over_floor(g, yfov=2 * np.arctan(0.9))
    row = picture(pathtracer, g, "--spp", 64, "--size", "41x41")[20, :, 0]
    x = (np.arange(41) + 0.5) / 20.5 - 1
    angle = np.arctan(np.abs(x) * 0.9)
    share = np.clip((np.cos(angle) - np.cos(0.5)) / (np.cos(0.2) - np.cos(0.5)), 0, 1) ** 2
    expected = 0.5 / np.pi * 4 * share * np.cos(angle) ** 3
    np.testing.assert_allclose(row, expected, atol=0.03)
    assert (row[angle > 0.55] == 0).all() and row[20] == pytest.approx(0.5 / np.pi * 4, rel=0.01)


def test_emission_from_one_side_or_both(pathtracer):
    for both, low in ((False, 0), (True, 0.05)):
        g = floor()
        glow = g.material((0, 0, 0), emissiveFactor=[1, 1, 1], doubleSided=both)
        g.quads([0.5 * QUAD + np.float32([0, 1, 0])], glow)  # faces away from the floor
        image = picture(pathtracer, over_floor(g, 0.9), "--spp", 8)
        assert image.mean() >= low and (both or image.mean() == 0)
        seen = picture(pathtracer, over_floor(g, 3, 0.2), "--spp", 4)
        # The second camera of the file is not the one that is used.
        np.testing.assert_array_equal(seen[:2, :2], picture(pathtracer, g, "--spp", 4)[:2, :2])


def test_emission_by_a_texture(pathtracer):
    """A panel of four colours lights a floor as four panels of one colour do: Welch's t-tests of the picture's means
    over 12 seeds, false-alarm rate one in ten thousand; seen straight, the panel shows its colours."""
    colours = np.array([[[255, 40, 40], [0, 0, 0]], [[30, 200, 60], [90, 90, 255]]], np.uint8)
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 3}}

    def scene(textured):
        g = floor()
        g.use("KHR_materials_emissive_strength")
        panel = np.float32([[-1, 0, 1], [-1, 0, -1], [1, 0, -1], [1, 0, 1]]) * 0.5 + np.float32([0, 0.8, 0])
        if textured:
            texture = g.texture(colours, magFilter=9728)
            material = g.material(
                (0, 0, 0), emissiveFactor=[1, 1, 1], emissiveTexture={"index": texture}, extensions=strength
            )
            coordinates = np.float32([[0, 1], [0, 0], [1, 0], [1, 1]])
            g.node(mesh=g.mesh(panel, SIX, material, TEXCOORD_0=coordinates))
        else:
            for row in range(2):
                for column in range(2):
                    part = panel * np.float32([0.5, 1, 0.5]) + np.float32([column - 0.5, 0, row - 0.5]) * 0.5
                    factor = [float(v) for v in linear(colours[row, column])]
                    material = g.material((0, 0, 0), emissiveFactor=factor, extensions=strength)
                    g.quads([part], material)
        return g

    means = []
    for textured in (True, False):
        path = over_floor(scene(textured), 0.7, 1.5).save(pathtracer.folder / "panel.glb")
        # The sky that a file gets whose only lights are pictures is not wanted here.
        arguments = ["--scene", path, "--env", "none", *SMALL, "--spp", 16, "--sampler", "sobol"]
        means.append([pathtracer.image(*arguments, "--seed", 50 * textured + i).mean(axis=(0, 1)) for i in range(12)])
    assert np.min(stats.ttest_ind(*means, equal_var=False).pvalue) * 3 > 1e-4
    assert np.mean(means) > 0.05
    g = scene(True)
    up = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    g.camera(2 * np.arctan(0.5 / 0.4), translation=[0, 0.4, 0], rotation=up)
    seen = picture(pathtracer, g, "--spp", 1, "--env", "none", "--max-depth", 0)
    # Looking up, the picture's top is +z: the panel's last row is on top.
    np.testing.assert_allclose(seen[4, 4], 3 * linear(colours[1, 0]), rtol=1e-3)
    np.testing.assert_allclose(seen[20, 4], 3 * linear(colours[0, 0]), rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(seen[4, 20], 3 * linear(colours[1, 1]), rtol=1e-3)


def test_a_spark_on_a_dark_texture_shines(pathtracer):
    """One texel of a million, between all the points by which its triangles are judged."""
    pixels = np.zeros((1024, 1024, 3), np.uint8)
    pixels[515, 533] = 255
    g = Gltf()
    glow = g.material((0, 0, 0), emissiveFactor=[1, 1, 1], emissiveTexture={"index": g.texture(pixels, magFilter=9728)})
    g.node(mesh=g.mesh(QUAD, SIX, glow, TEXCOORD_0=QUAD_COORDINATES))
    place = 2 * (np.array([533.5, 515.5]) / 1024 - 0.5)
    g.camera(2e-4, translation=[float(place[0]), 1, float(place[1])], rotation=DOWN)
    image = picture(pathtracer, g, "--spp", 1, "--env", "none")
    np.testing.assert_allclose(image, 1, rtol=1e-3)


# ---- Textures

FOUR = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [128, 64, 200]]], np.uint8)
CORNERS = ((6, 6), (6, 18), (18, 6), (18, 18))


def textured_floor(texture_of, coordinates=QUAD_COORDINATES, info=None, attributes=None, **material):
    """A floor that fills the picture exactly, with a base-colour texture."""
    g = Gltf()
    texture = {"index": texture_of(g), **(info or {})}
    number = g.material((1, 1, 1), pbr={"baseColorTexture": texture}, **material)
    g.node(mesh=g.mesh(QUAD, SIX, number, TEXCOORD_0=coordinates, **(attributes or {})))
    return over_floor(g, 1, np.pi / 2)


def corner_colours(pathtracer, scene, even_sky):
    image = picture(pathtracer, scene, "--spp", 4, "--env", even_sky, "--max-depth", 1)
    return np.array([image[y, x] for y, x in CORNERS])


@pytest.mark.parametrize("kind", ["PNG", "JPEG"])
def test_a_base_colour_texture(pathtracer, even_sky, kind):
    """The picture lies upright, its corner (0, 0) is top left, and its colours are those of sRGB."""
    big = FOUR.repeat(16, axis=0).repeat(16, axis=1)
    seen = corner_colours(pathtracer, textured_floor(lambda g: g.texture(big, kind)), even_sky)
    np.testing.assert_allclose(seen, linear(FOUR.reshape(4, 3)), atol=1e-3 if kind == "PNG" else 0.03)


def test_pictures_of_other_depths(pathtracer, even_sky):
    """Grey, with alpha, with a palette."""
    grey = np.array([[10, 90], [160, 250]], np.uint8)
    nearest = {"magFilter": 9728}
    seen = corner_colours(pathtracer, textured_floor(lambda g: g.texture(grey, **nearest)), even_sky)
    np.testing.assert_allclose(seen, np.tile(linear(grey.ravel())[:, None], 3), atol=1e-3)
    alpha = np.dstack([FOUR, np.full((2, 2), 7, np.uint8)])
    seen = corner_colours(pathtracer, textured_floor(lambda g: g.texture(alpha, **nearest)), even_sky)
    np.testing.assert_allclose(seen, linear(FOUR.reshape(4, 3)), atol=1e-3)  # alphaMode is OPAQUE


def test_wrapping_and_transforms(pathtracer, even_sky):
    nearest = lambda **wrap: lambda g: g.texture(FOUR, magFilter=9728, **wrap)
    plain = linear(FOUR.reshape(4, 3))

    def seen(texture, coordinates, **info):
        return corner_colours(pathtracer, textured_floor(texture, np.float32(coordinates), **info), even_sky)

    moved = QUAD_COORDINATES + np.float32([1, 0])
    np.testing.assert_allclose(seen(nearest(), moved), plain, atol=1e-3)
    np.testing.assert_allclose(seen(nearest(wrapS=33648), moved), plain[[1, 0, 3, 2]], atol=1e-3)
    np.testing.assert_allclose(seen(nearest(wrapS=33071), moved), plain[[1, 1, 3, 3]], atol=1e-3)
    transform = lambda **t: {"info": {"extensions": {"KHR_texture_transform": t}}}
    np.testing.assert_allclose(seen(nearest(), QUAD_COORDINATES, **transform(offset=[1, 0])), plain, atol=1e-3)
    shifted = seen(nearest(), QUAD_COORDINATES, **transform(offset=[0.5, 0]))
    np.testing.assert_allclose(shifted, plain[[1, 0, 3, 2]], atol=1e-3)
    upside_down = seen(nearest(), QUAD_COORDINATES, **transform(offset=[0, 1], scale=[1, -1]))
    np.testing.assert_allclose(upside_down, plain[[2, 3, 0, 1]], atol=1e-3)
    # A quarter turn of the coordinates, counter-clockwise as the extension has it, and back into the square: the
    # picture turns clockwise.
    turned = seen(nearest(), QUAD_COORDINATES, **transform(offset=[0, 1], rotation=np.pi / 2))
    np.testing.assert_allclose(turned, plain[[2, 0, 3, 1]], atol=1e-3)


def test_the_second_set_and_vertex_colours(pathtracer, even_sky):
    nearest = lambda g: g.texture(FOUR, magFilter=9728)
    second = {"TEXCOORD_1": QUAD_COORDINATES[::-1].copy()}  # upside down
    scene = textured_floor(nearest, info={"texCoord": 1}, attributes=second)
    plain = linear(FOUR.reshape(4, 3))
    np.testing.assert_allclose(corner_colours(pathtracer, scene, even_sky), plain[[2, 3, 0, 1]], atol=1e-3)
    half = {"COLOR_0": np.full((4, 4), 0.5, np.float32)}
    scene = textured_floor(nearest, attributes=half)
    np.testing.assert_allclose(corner_colours(pathtracer, scene, even_sky), 0.5 * plain, atol=1e-3)


def test_masks_cut_out(pathtracer, even_sky):
    """Where alpha is below the cut-off there is nothing: the sky shows, and light falls through."""
    pixels = np.dstack([np.zeros((2, 2, 3)), [[255, 100], [200, 0]]]).astype(np.uint8)
    scene = textured_floor(lambda g: g.texture(pixels, magFilter=9728), alphaMode="MASK", alphaCutoff=0.5)
    np.testing.assert_allclose(corner_colours(pathtracer, scene, even_sky)[:, 0], [0, 1, 0, 1], atol=1e-3)
    # The shadow of the same on a floor below.
    g = textured_floor(lambda g: g.texture(pixels, magFilter=9728), alphaMode="MASK")
    g.json["scenes"][0]["nodes"].pop()
    g.quads([QUAD * 2 - np.float32([0, 1, 0])], g.material((1, 1, 1)))
    g.light("directional", np.pi, rotation=DOWN)
    g.camera(np.pi / 2, translation=[0, -0.01, 0], rotation=DOWN)
    image = picture(pathtracer, g, "--spp", 1, "--max-depth", 1)
    np.testing.assert_allclose([image[y, x, 0] for y, x in CORNERS], [0, 1, 0, 1], atol=1e-3)


def test_normal_maps(pathtracer):
    """A map that leans all normals to +x makes a floor as bright as one that leans."""
    lean = np.array([0.6, 0, 0.8])
    pixels = np.full((2, 2, 3), np.round(255 * (0.5 + 0.5 * lean)), np.uint8)
    for to_light in (np.array([0, 1, 0]), np.sqrt(0.5) * np.array([1, 1, 0])):
        g = Gltf()
        material = g.material((0.5, 0.5, 0.5), normalTexture={"index": g.texture(pixels)})
        g.node(mesh=g.mesh(QUAD, SIX, material, TEXCOORD_0=QUAD_COORDINATES))
        g.light("point", 1e4 * np.pi, translation=[float(v) for v in 100 * to_light])
        image = picture(pathtracer, over_floor(g, yfov=0.01), "--spp", 1, "--max-depth", 1)
        assert image[12, 12, 0] == pytest.approx(0.5 * np.dot(to_light, [0.6, 0.8, 0]), rel=0.01)
    # Green is up in the picture, which is -z here.
    pixels = np.full((2, 2, 3), np.round(255 * (0.5 + 0.5 * np.array([0, 0.6, 0.8]))), np.uint8)
    g = Gltf()
    material = g.material((0.5, 0.5, 0.5), normalTexture={"index": g.texture(pixels)})
    g.node(mesh=g.mesh(QUAD, SIX, material, TEXCOORD_0=QUAD_COORDINATES))
    g.light("point", 1e4 * np.pi, translation=[0, 100 * float(np.sqrt(0.5)), -100 * float(np.sqrt(0.5))])
    image = picture(pathtracer, over_floor(g, yfov=0.01), "--spp", 1, "--max-depth", 1)
    assert image[12, 12, 0] == pytest.approx(0.5 * np.sqrt(0.5) * 1.4, rel=0.01)


# ---- Materials


def ball(g, material, around=24):
    """A unit sphere with normals."""
    angles = np.linspace(0, np.pi, around + 1), np.linspace(0, 2 * np.pi, 2 * around + 1)
    theta, phi = np.meshgrid(*angles, indexing="ij")
    n = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=-1)
    n = n.reshape(-1, 3).astype(np.float32)
    rows = np.arange(around)[:, None] * (2 * around + 1) + np.arange(2 * around)
    a, b, c, d = rows, rows + 1, rows + 2 * around + 1, rows + 2 * around + 2
    faces = np.stack([a, c, d, a, d, b], axis=-1).reshape(-1).astype(np.uint16)
    return g.node(mesh=g.mesh(n, faces, material, NORMAL=n))


@pytest.mark.parametrize("metallic", [0, 0.5, 1])
@pytest.mark.parametrize("roughness", [0, 0.3, 1])
def test_white_things_under_an_even_sky_cannot_be_seen(pathtracer, even_sky, metallic, roughness):
    g = Gltf()
    pbr = {"metallicFactor": metallic, "roughnessFactor": roughness}
    material = g.add("materials", pbrMetallicRoughness=pbr)
    ball(g, material)
    g.camera(0.8, translation=[0, 0, 4])
    image = picture(pathtracer, g, "--spp", 64, "--env", even_sky, "--max-depth", 100, "--sampler", "sobol")
    assert image.mean() == pytest.approx(1, abs=0.01)


def test_transmission_is_glass(pathtracer, even_sky):
    """Clear glass under an even sky cannot be seen, from outside or from within; tinted glass can."""
    for distance, colour in ((4, 1), (0.3, 1), (4, 0.5)):
        g = Gltf()
        extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.4}}
        pbr = {"metallicFactor": 0, "roughnessFactor": 0.0, "baseColorFactor": [colour, colour, colour, 1]}
        ball(g, g.add("materials", pbrMetallicRoughness=pbr, extensions=extensions))
        g.camera(0.3, translation=[0, 0, distance])
        image = picture(pathtracer, g, "--spp", 64, "--env", even_sky, "--max-depth", 100)
        if colour == 1:
            assert image.mean() == pytest.approx(1, abs=0.01)
        else:
            assert image[12, 12, 0] == pytest.approx(0.25, abs=0.06)


def test_obj_materials(pathtracer, even_sky):
    """Kd with a picture, upside down as OBJ has it; a hole by map_d; glass by illum 7."""
    (pathtracer.folder / "four.png").write_bytes(encoded(FOUR.repeat(16, axis=0).repeat(16, axis=1)))
    mask = np.array([[255, 255], [0, 255]], np.uint8).repeat(16, axis=0).repeat(16, axis=1)
    (pathtracer.folder / "hole.jpg").write_bytes(encoded(mask, "JPEG"))
    text = "mtllib a.mtl\nusemtl a\n"
    text += "".join(f"v {x} {z} 0\n" for x, z in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    text += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
    path = pathtracer.folder / "a.OBJ"  # in any case
    path.write_text(text)
    arguments = ["--scene", path, *SMALL, "--spp", 16, "--env", even_sky]
    material = pathtracer.folder / "a.mtl"
    material.write_text("newmtl a\nKd 1 1 1\nmap_Kd four.png\n")
    opaque = pathtracer.image(*arguments)
    material.write_text("newmtl a\nKd 1 1 1\nmap_Kd four.png\nmap_d hole.jpg\n")
    holed = pathtracer.image(*arguments)
    red, blue = opaque[7, 7], opaque[17, 7]
    assert red[0] > 0.9 and red[1] < 0.1 and red[2] < 0.1
    assert blue[2] > 0.9 and blue[0] < 0.1
    np.testing.assert_allclose(holed[7, 7], red, atol=0.05)
    np.testing.assert_allclose(holed[17, 7], 1, atol=0.05)
    material.write_text("newmtl a\nKd 0 0 0\nillum 7\nNi 1.5\nTf 1 1 1\n")
    np.testing.assert_allclose(pathtracer.image(*arguments, "--max-depth", 50), 1, rtol=1e-3)


def write_polygon(path, corners):
    """A polygon that faces the framing camera squarely; two specks fix where that camera stands."""
    to_eye = np.array([0.55, 0.42, 1]) / np.linalg.norm([0.55, 0.42, 1])
    right = np.cross([0, 1, 0], to_eye) / np.linalg.norm(np.cross([0, 1, 0], to_eye))
    points = [x * right + y * np.cross(to_eye, right) for x, y in corners]
    for place in (-1.5, 1.5):
        points += [place + 2e-5 * np.array(corner) for corner in ((0, 0, 0), (1, 0, 0), (0, 1, 0))]
    text = "mtllib a.mtl\nusemtl a\n" + "".join("v {} {} {}\n".format(*map(float, p)) for p in points)
    text += "f " + " ".join(str(i + 1) for i in range(len(corners))) + "\nf -6 -5 -4\nf -3 -2 -1\n"
    path.write_text(text)
    path.with_name("a.mtl").write_text("newmtl a\nKd 0 0 0\n")


def test_polygons_of_an_obj_cover_what_they_should(pathtracer, even_sky):
    """Concave ones, of either turn and from any first corner: the share of the picture that is dark goes with their
    area, to within the pixels along their edges."""
    angles = np.linspace(0.15, 2 * np.pi - 0.15, 60)
    arc = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    hole = 0.5 * np.array([(-1, -1), (-1, 1), (1, 1), (1, -1), (-1, -1)])
    comb = [(-1, -1), (1, -1), (1, 1), (0.6, 1), (0.6, -0.5), (0.2, -0.5), (0.2, 1), (-0.2, 1), (-0.2, -0.5), (-1, -0.5)]
    shapes = {
        "square": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
        "corner": [(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)],
        "dart": [(-1, -1), (0, -0.6), (1, -1), (0, 1)],
        "comb": comb,
        "ring": [*arc, *(0.6 * arc[::-1])],
        "frame": [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1), *hole],
    }
    path = pathtracer.folder / "polygon.obj"
    arguments = ["--scene", path, "--size", "64x64", "--spp", 4, "--env", even_sky, "--max-depth", 0]
    share_of_square = None
    for name, shape in shapes.items():
        x, y = np.array(shape, float).T
        area = abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2
        for shift, step in ((0, 1), (1, 1), (2, -1), (3, -1)):
            write_polygon(path, np.roll(np.array(shape, float), shift, axis=0)[::step])
            dark = 1 - pathtracer.image(*arguments)[..., 0].mean()
            share_of_square = share_of_square or dark
            assert dark / share_of_square == pytest.approx(area / 4, rel=0.04), name
    assert 0.1 < share_of_square < 0.9


# ---- Cameras and skies


def test_without_a_camera_everything_is_in_the_picture(pathtracer, even_sky):
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


def test_a_file_without_light_gets_a_sky(pathtracer):
    g = floor()
    assert picture(pathtracer, g, "--spp", 4).mean() > 0.1
    assert picture(pathtracer, g, "--spp", 4, "--env", "none").mean() == 0
    lamp = floor()
    lamp.quads([QUAD + np.float32([0, 9, 0])], lamp.material((0, 0, 0), emissiveFactor=[1e-3, 0, 0]))
    assert picture(pathtracer, lamp, "--spp", 4).max() <= 1e-3
    assert picture(pathtracer, lamp, "--spp", 4, "--env", "sky").mean() > 0.1


def test_what_is_not_rendered_is_named_once(pathtracer):
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
    done = pathtracer.run(*arguments)
    assert done.returncode == 0 and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"pathtracer: {path}: ignores ")
    for name in ("animations", "skins", "morph targets", "points and lines", "VENDOR_thing", "orthographic cameras"):
        assert done.stderr.count(name) == 1, name
    assert "sheen" not in done.stderr  # nothing has that material
    assert pathtracer.run(*arguments, "--quiet").stderr == ""


# ---- What is wrong


def refused(pathtracer, path, *words):
    done = pathtracer.run("--scene", path, *SMALL, "--spp", 1, "-o", "out.exr")
    assert done.returncode == 1, done.stdout + done.stderr
    assert done.stdout == "" and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"pathtracer: {path}: "), done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
    assert not list(pathtracer.folder.glob("out*"))


def change_accessor(number, **properties):
    return lambda g: g.json["accessors"][number].update(properties)


def nan_vertex(g):
    g.bytes[4:8] = struct.pack("<f", np.nan)


def infinite_node(g):
    g.json["nodes"][0]["translation"] = [1e30, 0, 0]


def cycle(g):
    g.json["nodes"][0]["children"] = [g.node(root=False, children=[0])]


def two_parents(g):
    """Forty generations of twins of twins would be 2^40 nodes if they were followed."""
    last = g.node(root=False, mesh=0)
    for _ in range(40):
        last = g.node(root=False, children=[last, last])
    g.json["scenes"][0]["nodes"].append(last)


def require(g):
    g.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]


def texture_on_floor(g, **image):
    texture = g.add("textures", source=g.add("images", **image))
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": texture}


def hostile_png(width, height):
    header = struct.pack(">4sIIBBBBB", b"IHDR", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + b"\0" * 64


WRONG = {
    "an index out of range": (lambda g: g.bytes.__setitem__(slice(48, 50), b"\x04\0"), "index out of range"),
    "a count beyond its view": (change_accessor(0, count=5), "run past the end"),
    "a huge count": (change_accessor(0, count=2**60), ""),
    "a huge count of nothing": (
        lambda g: g.json["accessors"].__setitem__(0, {"componentType": 5126, "type": "VEC3", "count": 2**33}),
        "at most",
    ),
    "an offset beyond its view": (change_accessor(0, byteOffset=2**40), "run past the end"),
    "no such view": (change_accessor(0, bufferView=77), "refers to buffer view 77"),
    "positions of two numbers": (change_accessor(0, type="VEC2"), "number of components"),
    "a number type of its own": (change_accessor(0, componentType=5124), ""),
    "indices that are floats": (change_accessor(1, componentType=5126), "unsigned integers"),
    "a view beyond its buffer": (lambda g: g.json["bufferViews"][0].update(byteLength=10**9), "past the end"),
    "a view at the end of the world": (lambda g: g.json["bufferViews"][0].update(byteOffset=2**62), ""),
    "no such mesh": (lambda g: g.json["nodes"][0].update(mesh=3), "refers to mesh 3"),
    "no such node": (lambda g: g.json["scenes"][0]["nodes"].append(9), "refers to node 9"),
    "no such scene": (lambda g: g.json.update(scene=4), "refers to scene 4"),
    "no such material": (lambda g: g.json["meshes"][0]["primitives"][0].update(material=5), "refers to material 5"),
    "no such camera": (lambda g: g.json["nodes"][0].update(camera=5), "refers to camera 5"),
    "no such light": (
        lambda g: g.json["nodes"][0].update(extensions={"KHR_lights_punctual": {"light": 2}}),
        "refers to light 2",
    ),
    "a vertex that is no number": (nan_vertex, "not a finite number"),
    "a vertex beyond all bounds": (infinite_node, "not a finite number"),
    "a cycle of nodes": (cycle, "twice"),
    "nodes with two parents": (two_parents, "twice"),
    "an extension it requires": (require, "KHR_draco_mesh_compression"),
    "a missing picture": (lambda g: texture_on_floor(g, uri="none.png"), "none.png: there is no such file"),
    "a picture that is none": (
        lambda g: texture_on_floor(g, bufferView=g.view(b"x" * 64), mimeType="image/png"),
        "no picture",
    ),
    "a damaged picture": (
        lambda g: texture_on_floor(g, bufferView=g.view(encoded(FOUR)[:50]), mimeType="image/png"),
        "damaged",
    ),
    "a picture of 2^60 texels": (
        lambda g: texture_on_floor(g, bufferView=g.view(hostile_png(2**30, 2**30)), mimeType="image/png"),
        "texels",
    ),
    "a picture of 2^32 texels": (
        lambda g: texture_on_floor(g, bufferView=g.view(hostile_png(2**16, 2**16)), mimeType="image/png"),
        "texels",
    ),
    "a picture outside of its buffer": (
        lambda g: texture_on_floor(g, bufferView=g.add("bufferViews", buffer=0, byteOffset=10**6, byteLength=99)),
        "past the end",
    ),
    "no triangles": (lambda g: g.json["scenes"][0].update(nodes=[]), "no triangles"),
    "another version": (lambda g: g.json["asset"].update(version="1.0"), "version 2"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_file_is_refused_with_one_line(pathtracer, what):
    change, words = WRONG[what]
    g = floor()
    change(g)
    for name in ("wrong.glb", "wrong.gltf"):
        refused(pathtracer, g.save(pathtracer.folder / name), words)


def test_a_missing_buffer_and_files_that_are_none(pathtracer):
    g = floor()
    path = pathtracer.folder / "apart.gltf"
    path.write_text(json.dumps(g.document(uri="apart.bin")))
    refused(pathtracer, path, "apart.bin")
    (pathtracer.folder / "apart.bin").write_bytes(bytes(g.bytes)[:-1])
    refused(pathtracer, path, "apart.bin")
    refused(pathtracer, pathtracer.folder / "none.glb", "no such file")
    (pathtracer.folder / "folder.glb").mkdir()
    refused(pathtracer, pathtracer.folder / "folder.glb")
    deep = b'{"asset":{"version":"2.0"},"extras":' + b"[" * 100000 + b"]" * 100000 + b"}"
    for name, content in (("empty.glb", b""), ("text.gltf", b"no glTF"), ("deep.gltf", deep), ("list.gltf", b"[1, 2]")):
        (pathtracer.folder / name).write_bytes(content)
        refused(pathtracer, pathtracer.folder / name)


def test_a_file_cut_short_anywhere_is_refused(pathtracer):
    whole = textured_floor(lambda g: g.texture(FOUR.repeat(8, axis=0))).glb()
    path = pathtracer.folder / "short.glb"
    for length in np.linspace(0, len(whole) - 1, 25, dtype=int):
        path.write_bytes(whole[:length])
        refused(pathtracer, path)
    text = textured_floor(lambda g: g.texture(FOUR.repeat(8, axis=0))).gltf()
    path = pathtracer.folder / "short.gltf"
    for length in np.linspace(0, len(text) - 1, 15, dtype=int):
        path.write_bytes(text[:length])
        refused(pathtracer, path)


def test_a_long_chain_of_nodes_is_no_trouble(pathtracer):
    """Fifty thousand generations, moved by their sum."""
    g = Gltf()
    mesh = g.mesh(QUAD, SIX, g.material((0.5, 0.5, 0.5)))
    count = 50_000
    g.json["nodes"] = [{"children": [i + 1], "translation": [0.25, 0, 0]} for i in range(count)]
    g.json["nodes"].append({"mesh": mesh})
    g.json["scenes"][0]["nodes"] = [0]
    g.light("directional", np.pi, rotation=DOWN)
    g.camera(0.4, translation=[0.25 * count, 1, 0], rotation=DOWN)
    np.testing.assert_allclose(picture(pathtracer, g, "--spp", 1, "--max-depth", 1), 0.5, rtol=1e-3)


@pytest.mark.parametrize(
    "text, words",
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "index out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 9\n", "index out of range"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -7\n", ""),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", ""),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/7 2/8 3/9\n", "index out of range"),
        ("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n", "not a finite number"),
        ("mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "none.png"),
        ("", "no triangles"),
        ("\0\1\2 nothing", "no triangles"),
    ],
)
def test_wrong_obj_files(pathtracer, text, words):
    (pathtracer.folder / "a.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd none.png\n")
    path = pathtracer.folder / "wrong.obj"
    path.write_text(text)
    refused(pathtracer, path, words)


def test_an_obj_without_its_materials_is_grey(pathtracer, even_sky):
    path = pathtracer.folder / "alone.obj"
    path.write_text("mtllib lost.mtl\nusemtl a\nv -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n")
    done = pathtracer.run("--scene", path, *SMALL, "--spp", 1, "--env", even_sky, "-o", "out.exr")
    assert done.returncode == 0
    assert done.stderr == f"pathtracer: {path}: ignores the missing material file lost.mtl\n"
