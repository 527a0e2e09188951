# SPDX-License-Identifier: Apache-2.0
"""Tests scripts/to-gltf: third-party meshes become scenes, and one line lists the features that are lost."""

import numpy as np
import pytest
import trimesh
from own_scene import to_gltf
from scene_files import encoded

SQUARE = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "usemtl a\nf 1/1 2/2 3/3 4/4\n"
PLAIN = f"mtllib s.mtl\n{SQUARE}{FACE}"


def albedo(pathtracer, capsys, obj, mtl, name="s.mtl"):
    """Converts and renders a square that fills the image. Returns its mean albedo and the conversion's output."""
    (pathtracer.folder / "s.obj").write_text(obj)
    (pathtracer.folder / name).write_text(mtl)
    to_gltf.run([str(pathtracer.folder / "s.obj")])
    view = ["--eye", "0,0,5", "--target", "0,0,0", "--fov", "22.6", "--env", "sky", "--size", "32x32", "--spp", "4"]
    layers = pathtracer.layers("--scene", "s.glb", *view)
    return [layers[f"albedo.{c}"].mean() for c in "RGB"], capsys.readouterr().out


TINTED, GREY = "newmtl a\nKd .5 .25 .125\n", "newmtl a\nKd .5 .5 .5\n"
TINT = [0.5, 0.25, 0.125]
# The square's vertices have colours, an unused vertex has none.
COLOURED = "v 9 9 9\n" + "".join(f"v {x} {y} 0 .5 .25 .125\n" for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))


@pytest.mark.parametrize(("obj", "mtl", "expected", "lost"), [
    # As written by other programs: spaces in and after names, a byte order mark, continued lines, backslashes
    (PLAIN, TINTED, TINT, ""),
    (PLAIN.replace("s.mtl", "my lib.mtl"), TINTED, TINT, ""),
    (PLAIN.replace("s.mtl", "s.mtl "), TINTED, TINT, ""),
    (f"\ufeff{PLAIN}", TINTED, TINT, ""),
    (PLAIN.replace(" 3/3", " \\\n3/3"), TINTED, TINT, ""),
    (PLAIN.replace("s.mtl", ".\\s.mtl"), TINTED, TINT, ""),
    # Colours that trimesh does not read
    (SQUARE + FACE, "", 0.6, ""),
    (PLAIN, "newmtl a\nKd 0.5\n", 0.5, ""),
    (PLAIN, f"\ufeff{GREY}", 0.5, ""),
    (PLAIN.replace("s.mtl", "none.mtl s.mtl # two"), GREY, 0.5, ", without: none.mtl, which is missing"),
    (PLAIN.replace("usemtl a", "usemtl a # one") + "l 1 2\n", GREY.replace("a\n", "a # two\n"), 0.5, ", without: lines and points"),
    (PLAIN, f"{GREY}d -halo .9\n", 0.5, ", without: d, as partial transparency"),
    (PLAIN, f"{GREY}Pr rough\n", 0.5, ", without: pr rough"),
    (PLAIN, "newmtl a\nKd xyz .5 .5 .5\n", 0.6, ", without: Kd xyz"),
    # Colours on some vertices, which multiply the material's colour
    (f"{COLOURED}f 2 3 4 5\n", "", TINT, ""),
    (f"mtllib s.mtl\n{COLOURED}usemtl a\nf 2 3 4 5\n", "newmtl a\nKd 1 1 1\n", TINT, "")])
def test_colours_and_lost_features(pathtracer, capsys, obj, mtl, expected, lost):
    found, said = albedo(pathtracer, capsys, obj, mtl, "my lib.mtl" if "my lib" in obj else "s.mtl")
    np.testing.assert_allclose(found, expected, atol=4e-3 if COLOURED in obj else 1e-3)
    assert said == f"to-gltf: wrote {pathtracer.folder / 's.glb'}{lost}\n"


def test_vertex_alpha_is_lost(tmp_path):
    trimesh.Trimesh(np.eye(3), [[0, 1, 2]], vertex_colors=np.full((3, 4), 100, np.uint8)).export(tmp_path / "s.ply")
    assert to_gltf.convert(tmp_path / "s.ply", tmp_path / "s.glb") == ["vertex alpha"]


@pytest.mark.parametrize("options", ["-s 2 2", "-s 2 2 1 -o 0.5 0", "-clamp on"])
def test_texture_options(pathtracer, capsys, options):
    """A texture with four different quarters is repeated as often as its scale says, which does not change the mean."""
    quarters = np.array([[[255, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 255, 0]]])
    (pathtracer.folder / "m.png").write_bytes(encoded(quarters.repeat(8, 0).repeat(8, 1)))
    found, _ = albedo(pathtracer, capsys, PLAIN, f"newmtl a\nmap_Kd {options} m.png\n")
    np.testing.assert_allclose(found, [0.25, 0.25, 0], atol=0.02)


def test_mtl_materials(tmp_path):
    """A roughness of 0, emission above 1 and glass are converted. Textures that are missing or not converted are reported."""
    glass = "newmtl c\nillum 7\nNi 1.4\nmap_Kd none.png\nmap_d d.png\n"
    (tmp_path / "s.mtl").write_text(f"newmtl a\nKd 1 1 1\nPr 0.000\nPm 1\nnewmtl b\nKe 3 2 1\n{glass}")
    faces = "".join(f"usemtl {name}\nf 1/1 2/2 3/3\n" for name in "abc")
    (tmp_path / "s.obj").write_text(f"mtllib s.mtl\n{SQUARE}{faces}")
    lost = to_gltf.convert(tmp_path / "s.obj", tmp_path / "s.glb")
    assert lost == ["map_d", "none.png, which is missing"]
    text = (tmp_path / "s.glb").read_bytes()
    for part in (b'"roughnessFactor":0.0', b'"emissiveStrength":3.0', b'"transmissionFactor":1.0', b'"ior":1.4'):
        assert part in text, part


def test_losses_are_reported_and_other_files_refused(tmp_path, capsys):
    (tmp_path / "s.mtl").write_text("newmtl a\nKd 1 1 1\nnewmtl b\nKd 1 0 0\n")
    corners = "".join(f"v {place} 0 1 0 0\n" for place in ("0 0", "1 0", "1 1", ".5 .5", "0 1"))
    (tmp_path / "s.obj").write_text(f"mtllib s.mtl\n{corners}usemtl a\nf 1 2 3 4 5\nusemtl b\nf 1 2 5\n")
    to_gltf.run([str(tmp_path / "s.obj"), "-o", str(tmp_path / "b.glb")])
    assert "without: the shape of concave polygons, vertex colours of objects with multiple materials" in capsys.readouterr().out
    (tmp_path / "s.txt").write_text("no mesh")
    for name, said in (("s.txt", "trimesh cannot read"), ("none.obj", "there is no file")):
        with pytest.raises(to_gltf.CommandError, match=said):
            to_gltf.run([str(tmp_path / name)])
