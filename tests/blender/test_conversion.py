# SPDX-License-Identifier: Apache-2.0
"""Tests scripts/to-gltf with Blender: meshes in every format, and a scene made in Blender, which must look as in Cycles."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from own_scene import to_gltf
from pathtracer_driver import read_exr
from scene_files import FOUR, FOUR_COLOURS, encoded, linear

SQUARE = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"
VIEW = ["--eye", "1,1,6", "--target", "1,1,0", "--fov", 18, "--size", "16x16", "--spp", 1, "--env", "sky"]  # of the square


def albedo(pathtracer, name, *options):
    """Converts a file; returns the albedo at the four quarters of the square, and what is lost."""
    lost, *_ = to_gltf.convert(pathtracer.folder / name, pathtracer.folder / "a.glb")
    layers = pathtracer.layers("--scene", "a.glb", *VIEW, *options)
    return np.array([[layers[f"albedo.{c}"][place] for c in "RGB"] for place in ((3, 3), (3, 12), (12, 3), (12, 12))]), lost


@pytest.mark.parametrize(("obj", "mtl", "expected", "lost"), [
    # Relative indices, tabs, comments, continued lines, a byte order mark, and two material libraries
    ("v\t9 9 9\nmtllib s.mtl\nusemtl a # one\n" + SQUARE + "f -4/-4 -3/-3 \\\n-2/-2 -1/-1\n",
     "newmtl a\nKd .5 .25 .125\n", [0.5, 0.25, 0.125], ""),
    ("\ufeffmtllib none.mtl s.mtl\nusemtl a\n" + SQUARE + FACE, "newmtl a\nKd .5 .25 .125\n", [0.5, 0.25, 0.125], "none.mtl"),
    (SQUARE + FACE, "", 0.8, ""),
    (SQUARE.replace("0\n", "0 .5 .5 .5\n") + FACE, "", linear([127.5])[0], ""),
    ("mtllib s.mtl\nusemtl a\n" + SQUARE.replace("0\n", "0 .5 .5 .5\n") + FACE, "newmtl a\nKd 1 1 1\n", linear([127.5])[0], ""),
    ("mtllib s.mtl\nusemtl a\n" + SQUARE + FACE, "newmtl a\nmap_Kd none.png\n", 1, "none.png"),
    ("mtllib s.mtl\nusemtl a\n" + SQUARE + FACE, "newmtl a\nKd .5 .25 .125\nillum 4\nTf 1 1 1\nNi 1.00\n", [0.5, 0.25, 0.125], ""),
    ("mtllib s.mtl\nusemtl a\n" + SQUARE + FACE, "newmtl a\nillum 7\nNi 1.5\nKd .1 .1 .1\n", 1, "")])
def test_obj_files_of_other_programs(pathtracer, obj, mtl, expected, lost):
    (pathtracer.folder / "s.obj").write_text(obj)
    (pathtracer.folder / "s.mtl").write_text(mtl)
    found, said = albedo(pathtracer, "s.obj")
    np.testing.assert_allclose(found, np.broadcast_to(expected, (4, 3)), atol=4e-3)
    assert lost in "".join(said) and bool(lost) == bool(said), said


def test_textures_are_copied_and_named_by_ply_files(pathtracer):
    (pathtracer.folder / "t.jpg").write_bytes(data := encoded(FOUR.repeat(16, 0).repeat(16, 1), "JPEG"))
    (pathtracer.folder / "s.mtl").write_text("newmtl a\nmap_Kd t.jpg\n")
    (pathtracer.folder / "s.obj").write_text(f"mtllib s.mtl\nusemtl a\n{SQUARE}{FACE}")
    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    points = "".join(f"{x} {y} 0 {x / 2} {y / 2}\n" for x, y in ((0, 0), (2, 0), (2, 2), (0, 2)))
    (pathtracer.folder / "s.ply").write_text("ply\nformat ascii 1.0\ncomment TextureFile t.jpg\nelement vertex 4\n" + "".join(
        f"property float {c}\n" for c in "xyzst") + f"{faces}{points}4 0 1 2 3\n")
    for name in ("s.obj", "s.ply"):
        found, lost = albedo(pathtracer, name)
        np.testing.assert_allclose(found, FOUR_COLOURS, atol=0.03)
        assert lost == [] and data in (pathtracer.folder / "a.glb").read_bytes()


def test_far_meshes_keep_their_digits(pathtracer):
    far = np.array([4_500_000.125, 5_200_000.25, 431.5])
    corners = "".join("v {!r} {!r} {!r}\n".format(*map(float, p)) for p in far + [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    (pathtracer.folder / "s.obj").write_text(f"{corners}f 1 2 3 4\n")
    to_gltf.convert(pathtracer.folder / "s.obj", pathtracer.folder / "a.glb")
    place = lambda *p: ",".join(map(repr, map(float, far + p)))
    view = ["--eye", place(1, 1, 6), "--target", place(1, 1, 0), "--fov", 36.87]
    layers = pathtracer.layers("--scene", "a.glb", *view, "--size", "32x32", "--spp", 4, "--env", "sky")
    assert (layers["A"][9:23, 9:23] == 1).all() and layers["A"].mean() == pytest.approx(0.25, abs=0.01)
    np.testing.assert_allclose(layers["depth.Z"][16, 16], 6, rtol=1e-5)


# A red square in every format that Blender exports, and a camera and a light where the format has them
EXPORT = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_plane_add(size=2, location=(1, 0, 1), rotation=(1.5707963, 0, 0))
material = bpy.data.materials.new("red")
material.use_nodes = True
shader = material.node_tree.nodes["Principled BSDF"].inputs
shader["Base Color"].default_value = (0.5, 0.25, 0.125, 1)
shader["Specular IOR Level"].default_value = 0
bpy.context.object.data.materials.append(material)
bpy.ops.wm.stl_export(filepath="s.stl", forward_axis="NEGATIVE_Z", up_axis="Y")
bpy.ops.wm.ply_export(filepath="s.ply", forward_axis="NEGATIVE_Z", up_axis="Y")
bpy.ops.export_scene.fbx(filepath="s.fbx")
bpy.ops.wm.usd_export(filepath="s.usdc")
bpy.ops.wm.usd_export(filepath="s.usda")
bpy.ops.wm.alembic_export(filepath="s.abc", as_background_job=False)
bpy.ops.wm.collada_export(filepath="s.dae")
bpy.ops.wm.save_as_mainfile(filepath="s.blend")
"""


def test_every_format_is_read(pathtracer, in_blender):
    in_blender(EXPORT)
    for name in ("s.blend", "s.usdc", "s.usda", "s.fbx", "s.dae", "s.stl", "s.ply", "s.abc"):
        found, _ = albedo(pathtracer, name)
        expected = 0.8 if name in ("s.stl", "s.ply", "s.abc") else [0.5, 0.25, 0.125]  # these have no materials
        np.testing.assert_allclose(found, np.broadcast_to(expected, (4, 3)), atol=4e-3, err_msg=name)


# A point light of radius 0.4 over a cube, whose shadow on the floor is soft
POINT = """
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_plane_add(size=6)
bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.5))
bpy.ops.object.light_add(type="POINT", location=(0.8, 0.5, 2.2))
bpy.context.object.scale = 3, 1, 0.5  # does not change the light
light = bpy.context.object.data
light.energy, light.color, light.shadow_soft_size, light.use_soft_falloff = 300, (1, 0.5, 0.2), 0.4, False
bpy.ops.object.camera_add(location=(0, -5, 5), rotation=(0.8, 0, 0))
bpy.context.scene.camera = bpy.context.object
bpy.context.object.data.lens = 85
bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 64
bpy.ops.wm.save_as_mainfile(filepath="s.blend")
"""


def in_cycles(pathtracer):
    """s.blend, rendered in Cycles with 64x64 pixels."""
    files = {"file": str(pathtracer.folder / "s.blend"), "output": str(pathtracer.folder / "cycles.exr")}
    (pathtracer.folder / "request.json").write_text(json.dumps([{**files, "size": 64, "spp": 256, "bounces": 16}]))
    command = [to_gltf.blender("test"), Path(__file__).with_name("render_in_cycles.py"), pathtracer.folder / "request.json"]
    subprocess.run(command, check=True, capture_output=True)
    return read_exr(pathtracer.folder / "cycles.exr")[0]


def test_point_lights_keep_their_size(pathtracer, in_blender):
    in_blender(POINT)
    lost, options, _ = to_gltf.convert(pathtracer.folder / "s.blend", pathtracer.folder / "s.glb")
    assert lost == [] and options == ["--env", "none"]
    image = pathtracer.image("--scene", "s.glb", *options, "--size", "64x64", "--spp", 256, "--max-depth", 16)
    wanted = in_cycles(pathtracer)
    print("a point light with a radius:", image.mean((0, 1)) / wanted.mean((0, 1)), "times Cycles' mean")
    np.testing.assert_allclose(image.mean((0, 1)), wanted.mean((0, 1)), rtol=0.03)
    blocks = lambda picture: picture.reshape(8, 8, 8, 8, 3).mean((1, 3))
    np.testing.assert_allclose(blocks(image), blocks(wanted), rtol=0.05, atol=0.02 * wanted.mean())  # also where it is half in shadow


SCENE = (Path(__file__).with_name("make_scene.py")).read_text()


def test_a_scene_made_in_blender_looks_as_in_cycles(pathtracer, in_blender):
    """An area light, a textured floor, glass, metal, a camera with focus, and a turned HDR world: means agree within 3%."""
    in_blender(SCENE)
    lost, options, _ = to_gltf.convert(pathtracer.folder / "s.blend", pathtracer.folder / "s.glb")
    assert lost == ["Noise Texture in Base Color of material unseen"] and options[2:4] == ["--env", str(pathtracer.folder / "s.world.exr")]
    assert options[:2] == ["--camera", "1"] and options[4:] == ["--lens", "0.05625", "--focus", "5.5"]
    image = pathtracer.image("--scene", "s.glb", *options, "--size", "64x64", "--spp", 256, "--max-depth", 16)
    wanted = in_cycles(pathtracer)
    ratio = image.mean((0, 1)) / wanted.mean((0, 1))
    said = ", ".join(f"{value:.3f}" for value in ratio)
    print(f"a scene made in Blender: {said} times Cycles' mean; all channels: {image.mean() / wanted.mean():.3f}")
    assert image.mean() == pytest.approx(wanted.mean(), rel=0.03)
    np.testing.assert_allclose(ratio, 1, atol=0.04)  # the lamp shines steeply on the red parts of a coated floor
    np.testing.assert_allclose(image[2, 2], wanted[2, 2], rtol=0.02)  # the sky, which is turned
