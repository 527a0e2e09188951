# SPDX-License-Identifier: Apache-2.0
"""Tests lights, textures and materials of scenes from files. Most images are known without rendering."""

import io
import struct

import numpy as np
import OpenEXR
import png
import pytest
import scene_files as files
from pathtracer_driver import assert_equal_means, read_exr
from PIL import Image, PngImagePlugin
from scene_files import DOWN, FOUR, FOUR_COLOURS, ONE, QUAD, Gltf, add_floor, assert_corners, floor, over_floor, picture, textured_floor

MIRROR = {"metallicFactor": 1, "roughnessFactor": 0}
TRANSMISSION = "KHR_materials_transmission"
HALF = np.pi / 6  # half of 60 degrees, by which a light turns downwards from -z


@pytest.mark.parametrize(("kind", "node", "radiance"), [
    ("point", {"translation": [0, 2, 0]}, 0.5 / np.pi * 10 / 4),  # candela over the distance squared
    ("spot", {"translation": [0, 2, 0], "rotation": DOWN, "light": {"spot": {}}}, 0.5 / np.pi * 10 / 4),
    # Lux times the cosine, wherever the node is
    ("directional", {"translation": [5, -7, 100], "rotation": [-np.sin(HALF), 0, 0, np.cos(HALF)]}, 0.5 / np.pi * 10 * np.sin(2 * HALF)),
])
def test_punctual_lights(pathtracer, kind, node, radiance):
    """--photometric divides punctual lights by 683 and leaves other lights unchanged."""

    def image(intensity, *arguments):
        g = floor()
        g.light(kind, intensity, (1, 0.5, 0.25), **node)
        g.quads([0.2 * QUAD + [0.6, 0.5, 0.6]], g.material((0, 0, 0), emissiveFactor=[0.1, 0.2, 0.3], doubleSided=True))
        return picture(pathtracer, over_floor(g, 3, 0.8), "--spp", 4, "--max-depth", 1, *arguments)

    radiometric = image(10)
    np.testing.assert_allclose(radiometric[12, 12], radiance * np.array([1, 0.5, 0.25]), rtol=0.05)
    np.testing.assert_allclose(image(10 * 683, "--photometric"), radiometric, rtol=1e-4)


def test_spot_light_falloff(pathtracer):
    """Intensity is full inside the inner cone, zero outside the outer cone, and a squared linear ramp in the cosine between them."""
    g = over_floor(floor(), yfov=2 * np.arctan(0.9))
    g.light("spot", 4, translation=[0, 1, 0], rotation=DOWN, light={"spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}})
    row = picture(pathtracer, g, "--spp", 64, "--size", "41x41")[20, :, 0]
    x = (np.arange(41) + 0.5) / 20.5 - 1
    angle = np.arctan(np.abs(x) * 0.9)
    share = np.clip((np.cos(angle) - np.cos(0.5)) / (np.cos(0.2) - np.cos(0.5)), 0, 1) ** 2
    np.testing.assert_allclose(row, 0.5 / np.pi * 4 * share * np.cos(angle) ** 3, atol=0.03)
    assert (row[angle > 0.55] == 0).all() and row[20] == pytest.approx(0.5 / np.pi * 4, rel=0.01)


def test_textured_emission(pathtracer):
    """A panel with a four-colour texture lights a floor like four single-colour panels, and the camera sees its colours."""
    colours = np.array([[[255, 40, 40], [0, 0, 0]], [[30, 200, 60], [90, 90, 255]]], np.uint8)
    light = 3 * files.linear(colours)

    def scene(textured):
        g = floor()
        panel = QUAD[[0, 3, 2, 1]] * 0.5 + np.float32([0, 0.8, 0])  # faces down
        if textured:
            add_floor(g, (0, 0, 0), panel, files.QUAD_COORDINATES[[0, 3, 2, 1]], **g.glow((3, 3, 3), 3),
                      emissiveTexture={"index": g.texture(colours, magFilter=9728)})
        for x, z in ((0, 0), (1, 1), (0, 1)) if not textured else ():
            quarter = panel * np.float32([0.5, 1, 0.5]) + np.float32([x / 2 - 0.25, 0, z / 2 - 0.25])
            g.quads([quarter], g.material((0, 0, 0), **g.glow(light[z, x], 3)))
        return g

    # Without --env, a file whose only lights are textured would get a sky.
    options = [*ONE, "--env", "none", "--sampler", "white", "--spp", 384]
    layers = [pathtracer.layers("--scene", over_floor(scene(textured), 0.7, 1.5), *options, "--seed", textured) for textured in (0, 1)]
    assert_equal_means(*layers, bias=0.05)
    g = scene(True)
    g.camera(2 * np.arctan(0.5 / 0.4), translation=[0, 0.4, 0], rotation=[np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    seen = picture(pathtracer, g, "--spp", 1, "--env", "none", "--max-depth", 0)
    # Looking up, the image's top is +z: the panel's last row is on top.
    np.testing.assert_allclose([[seen[y, x] for x in (4, 20)] for y in (20, 4)], light, rtol=1e-3, atol=1e-6)


def test_a_bright_texel_in_a_dark_texture_emits_light(pathtracer):
    """The one bright texel in a million lies between all points at which the emission of its triangles is tested."""
    pixels = np.zeros((1024, 1024, 3), np.uint8)
    pixels[515, 533] = 255
    g = Gltf()
    add_floor(g, (0, 0, 0), emissiveFactor=[1, 1, 1], emissiveTexture={"index": g.texture(pixels, magFilter=9728)})
    g.camera(2e-4, translation=[533.5 / 512 - 1, 1, 515.5 / 512 - 1], rotation=DOWN)
    np.testing.assert_allclose(picture(pathtracer, g, "--spp", 1, "--env", "none"), 1, rtol=1e-3)


def test_texture_file_formats(pathtracer, even_sky):
    """Textures are upright, with (0, 0) at the top left, and use sRGB. The files are JPEGs (one scan, progressive, grey, CMYK, stray bytes
    between segments, no end marker) and PNGs (grey, 16 bits, alpha, palette, interlaced, and with a gamma, which glTF ignores)."""
    grey, palette, gamma = np.array([[10, 90], [160, 250]], np.uint8), Image.new("P", (2, 2)), PngImagePlugin.PngInfo()
    palette.putpalette(FOUR.tobytes())
    palette.putdata([2, 0, 3, 1])
    gamma.add(b"gAMA", struct.pack(">I", 100000))
    greys = np.tile(files.linear(grey.ravel())[:, None], 3)
    interlaced, large = io.BytesIO(), Image.fromarray(files.LARGE_FOUR)
    png.Writer(2, 2, bitdepth=16, greyscale=False, interlace=True).write(interlaced, (FOUR.astype(int) * 257).reshape(2, 6))
    jpeg = files.encoded(files.LARGE_FOUR, "JPEG")
    for image, expected, options in [
        (FOUR, FOUR_COLOURS, {}), (files.LARGE_FOUR, FOUR_COLOURS, {"kind": "JPEG"}),
        (large, FOUR_COLOURS, {"kind": "JPEG", "progressive": True}), (interlaced.getvalue(), FOUR_COLOURS, {}),
        (large.convert("L"), np.tile(files.linear(np.asarray(large.convert("L"))[8::16, 8::16].reshape(4, 1)), 3), {"kind": "JPEG"}),
        (large.convert("CMYK"), FOUR_COLOURS, {"kind": "JPEG"}), (np.dstack([grey, grey]), greys, {}),
        *((jpeg[:-2] + end, FOUR_COLOURS, {"kind": "JPEG"}) for end in (b"", bytes(9) + b"\xff\0" + bytes(5) + b"\xff\xd9")),
        (grey, greys, {}), (Image.fromarray(grey.astype(np.uint16) * 257 + 100), greys, {}),
        (np.dstack([FOUR, np.full((2, 2), 7)]), FOUR_COLOURS, {}),  # alphaMode is OPAQUE
        (palette, FOUR_COLOURS[[2, 0, 3, 1]], {"transparency": b"\0\1"}), (FOUR, FOUR_COLOURS, {"pnginfo": gamma}),
    ]:
        atol = 0.03 if "kind" in options else 1e-3
        data = image if isinstance(image, bytes) else files.encoded(image, **options)
        assert_corners(pathtracer, textured_floor(data), expected, "--env", even_sky, atol=atol)


@pytest.mark.parametrize(("moved", "wrap", "transform", "order"), [
    (1, {}, {}, [0, 1, 2, 3]), (1, {"wrapS": 33648}, {}, [1, 0, 3, 2]), (1, {"wrapS": 33071}, {}, [1, 1, 3, 3]),
    (0, {}, {"offset": [1, 0]}, [0, 1, 2, 3]), (0, {}, {"offset": [0.5, 0]}, [1, 0, 3, 2]),
    (0, {}, {"offset": [0, 1], "scale": [1, -1]}, [2, 3, 0, 1]),
    # The extension turns the coordinates counter-clockwise, here by a quarter turn, and the offset moves them back into the
    # square, so the image turns clockwise.
    (0, {}, {"offset": [0, 1], "rotation": np.pi / 2}, [2, 0, 3, 1])])
def test_texture_wrapping_and_transforms(pathtracer, even_sky, moved, wrap, transform, order):
    info = {"extensions": {"KHR_texture_transform": transform}} if transform else {}
    scene = textured_floor(sampler={"magFilter": 9728, **wrap}, coordinates=files.QUAD_COORDINATES + np.float32([moved, 0]), info=info)
    assert_corners(pathtracer, scene, FOUR_COLOURS[order], "--env", even_sky)


def test_second_texture_coordinates_and_vertex_colours(pathtracer, even_sky):
    upside_down = {"TEXCOORD_1": files.QUAD_COORDINATES[::-1], "COLOR_0": np.full((4, 4), 0.5, np.float32)}
    scene = textured_floor(info={"texCoord": 1}, attributes=upside_down)
    assert_corners(pathtracer, scene, 0.5 * FOUR_COLOURS[[2, 3, 0, 1]], "--env", even_sky)


def test_alpha_masks_cut_holes(pathtracer, even_sky):
    """Where alpha is below the cut-off, the sky is visible and light passes through."""
    pixels = np.dstack([np.zeros((2, 2, 3)), [[255, 100], [200, 0]]]).astype(np.uint8)
    shown = np.tile([[0], [1], [0], [1]], 3)
    assert_corners(pathtracer, textured_floor(pixels, alphaMode="MASK", alphaCutoff=0.5), shown, "--env", even_sky)
    # The shadow of the masked floor on a floor below.
    g = textured_floor(pixels, alphaMode="MASK")
    g.json["scenes"][0]["nodes"].pop()
    g.quads([QUAD * 2 - np.float32([0, 1, 0])], g.material((1, 1, 1)))
    g.light("directional", np.pi, rotation=DOWN)
    g.camera(np.pi / 2, translation=[0, -0.01, 0], rotation=DOWN)
    assert_corners(pathtracer, g, shown)


def test_normal_maps(pathtracer):
    """A map that tilts all normals makes a floor as bright as a tilted floor. Red tilts to +x, green to -z, which is up in the image."""
    x, h = [0.6, 0, 0.8], np.sqrt(0.5)
    for lean, to_light, cosine in [(x, [0, 1, 0], 0.8), (x, [h, h, 0], 1.4 * h), ([0, 0.6, 0.8], [0, h, -h], 1.4 * h)]:
        g = Gltf()
        add_floor(g, (0.5, 0.5, 0.5), normalTexture={"index": g.texture(np.round(255 * (0.5 + 0.5 * np.array([[lean]]))))})
        g.light("point", 1e4 * np.pi, translation=[100 * v for v in to_light])
        image = picture(pathtracer, over_floor(g, yfov=0.01), "--spp", 1, "--max-depth", 1)
        assert image[12, 12, 0] == pytest.approx(0.5 * cosine, rel=0.01)


def ior(value, **specular):
    return {"KHR_materials_ior": {"ior": value}, **({"KHR_materials_specular": specular} if specular else {})}


@pytest.mark.parametrize(("colour", "metallic", "transmission", "extensions", "mode", "distance", "expected"), [
    # Clear glass under a uniform sky is invisible, from outside and from inside; tinted glass is not.
    ([1, 1, 1, 1], 0, 1, ior(1.4), "OPAQUE", 4, 1), ([1, 1, 1, 1], 0, 1, ior(1.4), "OPAQUE", 0.3, 1),
    ([0.5, 0.5, 0.5, 1], 0, 1, ior(1.01), "OPAQUE", 4, 0.25),
    # Converters write an index of 1000 together with a specular colour. An index of 1.5 reflects 4%.
    ([0.5, 0.5, 0.5, 1], 0, 1, ior(1000, specularColorFactor=[0.0401606] * 3), "OPAQUE", 4, 0.04 + 0.96**2 / 4 / 0.96),
    # Black with an alpha of one quarter transmits three quarters at each of two surfaces, even without metallicFactor.
    ([0, 0, 0, 0.25], 0, 0.75, ior(1.01), "BLEND", 4, 0.75**2), ([0, 0, 0, 0.25], None, 0.75, ior(1.01), "BLEND", 4, 0.75**2),
    # With an alpha of 1 and no metallicFactor, the material is metal: a mirror, where glass would transmit a quarter.
    ([0.5, 0.5, 0.5, 1], None, 0.75, ior(1.01), "BLEND", 4, 0.5),
    # Black glass that is masked out shows the sky.
    ([0, 0, 0, 0.2], 0, 1, ior(1.5), "MASK", 4, 1)])
def test_transmissive_materials_are_glass(pathtracer, even_sky, colour, metallic, transmission, extensions, mode, distance, expected):
    g = Gltf()
    pbr = {"baseColorFactor": colour, "roughnessFactor": 0.0, **({} if metallic is None else {"metallicFactor": metallic})}
    extensions = {TRANSMISSION: {"transmissionFactor": transmission}, **extensions}
    files.ball(g, g.add("materials", pbrMetallicRoughness=pbr, extensions=extensions, alphaMode=mode))
    g.camera(0.1, translation=[0, 0, distance])
    np.testing.assert_allclose(picture(pathtracer, g, "--spp", 64, "--env", even_sky, "--max-depth", 100), expected, atol=0.02)


@pytest.mark.parametrize(("extensions", "coat"), [
    ({}, 0.04), ({"KHR_materials_specular": {"specularFactor": 0.5}}, 0.02), (ior(2), 1 / 9), (ior(1), 0),
    # As written by converters from specular-glossiness
    (ior(1000, specularColorFactor=[0.3, 0.3, 0.3]), 0.3), (ior(0, specularColorFactor=[0.3, 0.3, 0.3]), 0.3),
    (ior(1000, specularColorTexture={"index": 0}), 0.04)])
def test_reflectance_of_coats(pathtracer, even_sky, extensions, coat):
    """A smooth coat over black reflects the sky as Schlick's formula says, where the reflectance at grazing angles is the specularFactor.
    Roughness and metalness are factors or a texture's green and blue."""
    edge = 0 if coat == 0 else extensions.get("KHR_materials_specular", {}).get("specularFactor", 1)
    for factors in (True, False):
        g = Gltf()
        texture = {"metallicRoughnessTexture": {"index": g.texture([[[255, 13, 0]]])}}
        pbr = {"baseColorFactor": [0, 0, 0, 1], **({"metallicFactor": 0, "roughnessFactor": 0.05} if factors else texture)}
        g.quads([QUAD], g.add("materials", pbrMetallicRoughness=pbr, extensions=extensions))
        for angle in (0, 80):
            sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
            view = ["--eye", f"0,{cosine},{sine}", "--target", "0,0,0", "--fov", 0.5, "--spp", 64, "--env", even_sky]
            expected = coat + (edge - coat) * (1 - cosine) ** 5
            assert picture(pathtracer, g, *view).mean() == pytest.approx(expected, rel=0.05, abs=1e-4)


@pytest.mark.parametrize("plus", [False, True])
def test_plus_signs_in_texture_uris_and_alternatives_to_webp(pathtracer, even_sky, plus):
    """A plus sign in a URI does not mean a space. If a texture has a PNG and a WebP image, the PNG is used, even if WebP is required."""
    g = textured_floor()
    if plus:
        g.json["images"] = [{"uri": "a+b.png"}]
        for name, pixels in (("a+b.png", FOUR), ("a b.png", 0 * FOUR)):
            (pathtracer.folder / name).write_bytes(files.encoded(pixels))
    else:
        g.json["textures"][0]["extensions"] = {"EXT_texture_webp": {"source": g.add("images", mimeType="image/webp", uri="a.webp")}}
        g.json.update(extensionsUsed=["EXT_texture_webp"], extensionsRequired=["EXT_texture_webp"])
    assert_corners(pathtracer, g, FOUR_COLOURS, "--env", even_sky)


@pytest.mark.parametrize(("texture", "said"), [
    ({"extensions": {"EXT_texture_webp": {"source": 0}}}, ["textures without a PNG or JPEG"]),
    ({"source": 0}, ["the missing image none.png", "emissiveFactor"])])
def test_unavailable_textures_are_white_and_reported(pathtracer, even_sky, texture, said):
    """Emissive textures that a missing emissiveFactor makes black are reported too."""
    g = textured_floor(**({"emissiveTexture": {"index": 0}} if len(said) > 1 else {}))
    g.json.update(images=[{"uri": "none.png"}], textures=[texture])
    path = g.save(pathtracer.folder / "scene.gltf")
    image = pathtracer.image("--scene", path, *ONE, "--env", even_sky, "--max-depth", 1)
    assert pathtracer.said.count("\n") == 1 and pathtracer.said.startswith(f"pathtracer: {path}: ignores ")
    assert all(word in pathtracer.said for word in said), pathtracer.said
    np.testing.assert_allclose(image, 1, atol=1e-3)


def test_backs_of_single_sided_surfaces_are_invisible(pathtracer, even_sky):
    """From below, a floor is visible only if it is double-sided or glass. Mirrors do not show back faces either."""
    for properties, share in (({}, 0), ({"doubleSided": True}, 1), ({"extensions": {TRANSMISSION: {"transmissionFactor": 1}}}, 1)):
        g = Gltf()
        g.quads([QUAD], g.material(**properties))
        view = ["--scene", g, *ONE, "--env", even_sky, "--target", "0,0,0", "--fov", 60]
        for eye, seen in (("0,-1,0", share), ("0,1,0", 1)):
            assert (pathtracer.layers(*view, "--eye", eye)["A"] == seen).all(), (properties, eye)
    # The camera looks up into a mirror that reflects the front or the back of a black card below the camera.
    for card, shows in ((QUAD, True), (QUAD[::-1], False)):
        g = Gltf()
        g.quads([QUAD[::-1] * 4 + np.float32([0, 1, 0])], g.material((1, 1, 1), pbr=MIRROR))
        g.quads([card * 0.4], g.material((0, 0, 0)))
        view = ["--eye", "0,0.5,0", "--target", "0,1,0", "--fov", 20, "--env", even_sky, "--max-depth", 2]
        image = picture(pathtracer, g, "--spp", 1, *view)
        assert (image < 0.01).all() if shows else (image > 0.99).all()


def test_a_mirror_with_any_normal_map_reflects_only_the_sky(pathtracer, even_sky):
    """A white mirror is as bright as the uniform sky: no reflected ray goes below the mirror's surface."""
    pixels = np.random.default_rng(4).integers(0, 256, (16, 16, 3), dtype=np.uint8)
    g = Gltf()
    add_floor(g, pbr=MIRROR, normalTexture={"index": g.texture(pixels, magFilter=9728)})
    for eye in ("0,1,0.3", "0,0.1,1"):
        view = ["--eye", eye, "--target", "0,0,0", "--fov", 5, "--env", even_sky]
        np.testing.assert_allclose(picture(pathtracer, g, "--spp", 8, *view), 1, rtol=1e-4)


def test_masked_parts_of_a_lamp_do_not_emit_light(pathtracer):
    """A lamp with one half masked out equals a lamp of half the size. A lamp that is masked out completely emits nothing."""

    def mean(half=1.0, **pbr):
        g = floor()
        lamp = 0.2 * QUAD[::-1] * np.float32([half, 1, 1]) + np.float32([0.2 * (half - 1), 0.7, 0])
        pbr = pbr or {"baseColorTexture": {"index": g.texture([[[0, 0, 0, 255], [0, 0, 0, 0]]], magFilter=9728)}}
        add_floor(g, (0, 0, 0), lamp, **g.glow((5, 5, 5), 5), alphaMode="MASK", pbr=pbr)
        return picture(pathtracer, over_floor(g, 0.6, 1.5), "--spp", 64, "--env", "none", "--max-depth", 1).mean()

    assert mean(baseColorFactor=[1, 1, 1, 0.2]) == 0
    assert mean() == pytest.approx(mean(0.5, baseColorFactor=[1, 1, 1, 1]), rel=0.02)


@pytest.mark.parametrize(("mode", "alpha", "there"), [("MASK", 0.4, 0), ("MASK", 0.5, 1), ("BLEND", 0.4, 0), ("BLEND", 0.5, 1),
                                                      ("OPAQUE", 0.4, 1)])
def test_vertex_alpha(pathtracer, even_sky, mode, alpha, there):
    g = Gltf()
    add_floor(g, attributes={"COLOR_0": np.tile(np.float32([0.5, 0.5, 0.5, alpha]), (4, 1))}, alphaMode=mode)
    layers = pathtracer.layers("--scene", over_floor(g), *ONE, "--env", even_sky)
    assert (layers["A"] == there).all() and layers["albedo.R"].mean() == pytest.approx(0.5 * there)


@pytest.mark.parametrize("metal", [False, True])
def test_vertex_normals_override_the_winding(pathtracer, metal):
    """On a double-sided surface, vertex normals determine the front, so both winding orders give the same image."""
    sky = files.write_exr(pathtracer.folder / "key.exr", RGB=np.float32(np.random.default_rng(1).random((8, 16, 3))))

    def image(turned):
        g = Gltf()
        metallic = {"metallicFactor": float(metal), "roughnessFactor": 0.3}
        files.ball(g, g.material((0.9, 0.9, 0.9), doubleSided=True, pbr=metallic), turned=turned)
        g.camera(0.4, translation=[0, 0, 6])
        return picture(pathtracer, g, "--spp", 16, "--env", sky)

    np.testing.assert_allclose(image(True).mean(), image(False).mean(), rtol=2e-3)


def patch(attributes, zigzag=0.0, pixel=(217, 128, 217), turned=False, scale=1):
    """A quarter of a cylinder in eight strips, whose normal map tilts all normals along the tangent. With `zigzag` texture coordinates,
    every face has different tangents. With `turned`, the winding contradicts the normals. `scale` scales the node along x."""
    angle = np.tile(np.linspace(-np.pi / 4, np.pi / 4, 9), 2)
    vectors = lambda *components: np.stack(np.broadcast_arrays(*components), -1).astype(np.float32)
    normals, across = vectors(np.sin(angle), 0, np.cos(angle)), vectors(np.cos(angle), 0, -np.sin(angle))
    points = normals + vectors(0, np.repeat([-1, 1], 9), 0)
    uv = vectors(angle / (np.pi / 2) + 0.5, np.concatenate([np.ones(9), zigzag * (np.arange(9) % 2)]))
    faces = (np.arange(8)[:, None] + [0, 1, 10, 0, 10, 9]).ravel().astype(np.uint16)
    g = Gltf()
    material = g.material((1, 1, 1), normalTexture={"index": g.texture([[pixel]])}, doubleSided=turned)
    mesh = g.mesh(points, faces[::-1] if turned else faces, material, NORMAL=normals, TEXCOORD_0=uv, **attributes(across))
    g.node(mesh=mesh, scale=[scale, 1, 1])
    g.camera(0.5, translation=[0, 0, 4])
    return g


def test_tangents(pathtracer, even_sky):
    """Tangents in a file override texture coordinates. Computed tangents match tangents in a file and are smooth across edges."""

    def normals(attributes, *options, **named):
        layers = pathtracer.layers("--scene", patch(attributes, *options, **named), *ONE, "--spp", 16, "--env", even_sky)
        return np.stack([layers[f"normal.{c}"] for c in "XYZ"], -1)[6:18, 6:18]

    signed = lambda t, sign: {"TANGENT": np.concatenate([t, np.full((len(t), 1), sign)], 1).astype(np.float32)}
    computed, written = normals(lambda t: {}), normals(lambda t: signed(t, 1))
    np.testing.assert_allclose(computed, written, atol=0.01)
    other = normals(lambda t: signed(-t, -1))
    np.testing.assert_allclose(other[..., 0] + written[..., 0], 2 * normals(lambda t: signed(0 * t + [0, 1, 0], 1))[..., 0], atol=0.05)
    assert abs(other[6, 6, 0] - written[6, 6, 0]) > 0.5
    up = {"pixel": (128, 217, 217)}
    np.testing.assert_allclose(normals(lambda t: {}, turned=True, **up), normals(lambda t: {}, **up), atol=0.01)
    for attributes in (lambda t: {}, lambda t: signed(t, 1)):  # a mirrored node gives the mirror image
        np.testing.assert_allclose(normals(attributes, scale=-1, **up)[:, ::-1] * [-1, 1, 1], normals(attributes, **up), atol=0.01)
    seamless = normals(lambda t: {}, 0.15)
    assert max(np.abs(np.diff(seamless, axis=axis)).max() for axis in (0, 1)) < 0.1  # 0.7 with one tangent per face


def test_the_display_window_of_an_environment_is_the_sphere(pathtracer):
    """Where a file has no data, the sky is black; data outside of the display window is cut off."""
    full = np.zeros((6, 12, 3), np.float32)
    full[1:3, 4:9] = np.arange(30).reshape(2, 5, 3)
    wide = np.pad(full, ((1, 2), (3, 4), (0, 0)), constant_values=99)
    view = ["--scene", floor(), *ONE, "--env", "sky.exr", "--max-depth", 0, "--eye", "0,9,0", "--target", "0,9.7,1", "--fov", 120]
    images = []
    for data, corner in ((full, (0, 0)), (full[1:3, 4:9], (4, 1)), (wide, (-3, -1))):
        low = np.int32(corner) + np.int32(7)  # the display window need not start at the origin
        size = np.int32(data.shape[1::-1])
        windows = {"displayWindow": (np.int32([7, 7]), np.int32([18, 12])), "dataWindow": (low, low + size - np.int32(1))}
        files.write_exr(pathtracer.folder / "sky.exr", windows, RGB=data)
        images.append(pathtracer.image(*view))
    assert images[0].max() == 29
    np.testing.assert_array_equal(images[1:], [images[0]] * 2)


def test_exr_attributes_that_change_the_pixels(pathtracer):
    """Cube maps are refused, other primaries are converted, and texels that are not finite are reported, or bounded with --clamp."""
    texels = np.full((4, 8, 3), np.float32([0, 1, 0]))
    view = ["--scene", "lens", "--max-depth", 0, *ONE, "--env", "sky.exr"]
    write = lambda **header: files.write_exr(pathtracer.folder / "sky.exr", header, RGB=texels)
    write(chromaticities=(0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329))  # Rec. 2020
    # Out-of-gamut components are negative and become zero.
    np.testing.assert_allclose(pathtracer.image(*view)[0, 0], [0, 1.1329, 0], atol=1e-3)
    write(envmap=OpenEXR.ENVMAP_CUBE if hasattr(OpenEXR, "ENVMAP_CUBE") else OpenEXR.Envmap(1))
    pathtracer.failure(*view, said=["sky.exr", "cube map"])
    texels[2, 5] = np.inf, np.nan, 1
    write()
    pathtracer.failure(*view, said=["texel 5,2 is not finite", "--clamp"])
    image, header = read_exr(pathtracer.render(*view, "--clamp"))
    assert np.isfinite(image).all() and header["clamp"] == "1"
    texels[:] = np.inf, 0.25, 0.5  # also if a file states the primaries of Rec. 709
    write(chromaticities=(0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))
    np.testing.assert_allclose(pathtracer.image(*view, "--clamp")[0, 0], [65504, 0.25, 0.5], rtol=1e-3)
