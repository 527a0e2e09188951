# SPDX-License-Identifier: Apache-2.0
"""Tests what scripts/to-gltf does around Blender. tests/blender runs Blender itself."""

import json
import struct
import sys

import numpy as np
import pytest
from own_scene import to_gltf

FAR = [4_500_000.125, 5_200_000.25, 431.5]
TREE = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 3]}], "meshes": [{"primitives": [{"attributes": {}}]}],
        "nodes": [{"children": [1], "mesh": 0}, {"camera": 0, "name": "a"}, {"camera": 2, "name": "c"}, {"camera": 1, "name": "b"}],
        "cameras": [{"type": "perspective"}, {"type": "perspective"}, {"type": "orthographic"}]}


def corners(offset, size=1.0):
    return np.array([[0, 0, 0], [size, 0, 0], [size, size, 0]]) + offset


@pytest.mark.parametrize("keyword", ["v", "vertex"])
def test_far_coordinates_of_text_files_are_moved(keyword):
    """They keep their digits, which a float would lose; colours after them and all other lines stay."""
    text = lambda points: "".join(f"{keyword} {x!r} {y!r} {z!r} 1 0.5 0\n" for x, y, z in points.tolist()) + "vt 0 1\nf 1 2 3\n"
    near = text(corners(10.0)).encode()
    assert to_gltf.moved_text(near, keyword.encode()) == (near, None)
    moved, centre = to_gltf.moved_text(text(corners(FAR)).encode(), keyword.encode())
    assert moved.decode() == text(corners(FAR) - centre) and np.abs(corners(FAR) - centre).max() < 2


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_far_coordinates_of_ply_files_are_moved(form):
    order = ">" if "big" in form else "<"
    header = f"ply\nformat {form} 1.0\ncomment by a test\nelement vertex 3\nproperty uchar red\n" + "".join(
        f"property double {c}\n" for c in "xyz") + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"

    def ply(points):
        if form == "ascii":
            return (header + "".join(f"7 {x!r} {y!r} {z!r}\n" for x, y, z in points.tolist()) + "3 0 1 2\n").encode()
        return header.encode() + b"".join(struct.pack(order + "Bddd", 7, *p) for p in points) + struct.pack(order + "Biii", 3, 0, 1, 2)

    assert to_gltf.moved_ply(ply(corners(0.0))) == (ply(corners(0.0)), None)
    moved, centre = to_gltf.moved_ply(ply(corners(FAR)))
    assert moved == ply(corners(FAR) - centre) and np.abs(corners(FAR) - centre).max() < 2
    assert to_gltf.moved_ply(b"ply\nno header") == (b"ply\nno header", None)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_texture_coordinates_of_ply_faces_become_those_of_vertices(form):
    """Two triangles share an edge and disagree about its coordinates, so that each of their corners becomes a vertex."""
    order = ">" if "big" in form else "<"
    header = f"ply\nformat {form} 1.0\ncomment TextureFile t.png\nelement vertex 4\n" + "".join(f"property double {c}\n" for c in "xyz") + (
        "property uchar red\nelement face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n")
    points, faces = [(0, 0, 0, 9), (1, 0, 0, 8), (1, 1, 0, 7), (0, 1, 0, 6)], [(0, 1, 2), (0, 2, 3)]
    uv = [(0, 0, 1, 0, 1, 1), (0.5, 0, 0.5, 0.5, 0, 1)]
    if form == "ascii":
        rows = [*points, *((3, *corners, 6, *places) for corners, places in zip(faces, uv))]
        data = (header + "".join(" ".join(map(str, row)) + "\n" for row in rows)).encode()
    else:
        data = header.encode() + b"".join(struct.pack(order + "dddB", *p) for p in points) + b"".join(
            struct.pack(order + "B3iB6f", 3, *corners, 6, *places) for corners, places in zip(faces, uv))
    text, _, body = to_gltf.with_corners(data).partition(b"end_header\n")
    assert b"TextureFile t.png" in text and b"element vertex 6" in text and b"texcoord" not in text
    expected = [(*points[i], *uv[k][2 * c:2 * c + 2]) for k, face in enumerate(faces) for c, i in enumerate(face)]
    assert [struct.unpack_from("<dddBff", body, 33 * i) for i in range(6)] == expected
    assert body[33 * 6:] == struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 3, 4, 5)
    plain = data.replace(b"property list uchar float texcoord\n", b"")
    assert to_gltf.with_corners(plain) == plain


@pytest.mark.parametrize(("lines", "wanted"), [
    ("illum 2\nKd 1 0 0", None), ("Kd 1 0 0\nd 0.5", None),
    ("illum 4\nTf 1 1 1\nNi 1.00", {"Transmission Weight": 0, "Metallic": 0}),
    ("illum 7\nNi 1.00\nd 1.0", {"Transmission Weight": 0, "Metallic": 0}),
    ("illum 6\nNi 1.5\nd 0.9\nTf .9 .8 .7", {"Transmission Weight": 1, "IOR": 1.5, "Base Color": [0.9, 0.8, 0.7], "Metallic": 0}),
    ("illum 7\nNi 1.4", {"Transmission Weight": 1, "IOR": 1.4}), ("illum 4\nTr 0.7\nNi 1.3", {"Transmission Weight": 1, "IOR": 1.3}),
    ("illum 3\nKd 0 0 0\nKs .9 .8 .7", {"Metallic": 1, "Base Color": [0.9, 0.8, 0.7]}), ("illum 3\nKd .5 0 0\nKs 1 1 1", {"Metallic": 0}),
    ("illum 3\nPm 0.5", None), ("illum 4\nd -halo 0.9", {"Transmission Weight": 1}), ("illum 4\nNi glass\nd", {"Transmission Weight": 0})])
def test_mtl_materials_that_blender_takes_for_metal_or_glass(lines, wanted):
    found = to_gltf.mtl_corrections(f"# one\nnewmtl other\nKd 1 1 1\n\nnewmtl a b \r\n{lines}\n")
    assert ("a b" in found) == (wanted is not None) and "other" not in found
    for name, value in (wanted or {}).items():
        assert found["a b"][name] == pytest.approx(value), name


def test_names_of_material_libraries(tmp_path):
    (tmp_path / "my lib.mtl").touch()
    for line, names in (("my lib.mtl", ["my lib.mtl"]), ("a.mtl b.MTL # two", ["a.mtl", "b.MTL"]), ("..\\c.mtl", ["../c.mtl"])):
        text, found = to_gltf.mtl_files(f"mtllib {line}\nv 0 0 0\n".encode(), tmp_path)
        assert found == [tmp_path / name for name in names]
        assert [line[7:].split(" #")[0].strip() for line in text.decode().splitlines() if line.startswith("mtllib ")] == names


def test_the_files_beside_a_moved_mesh_are_still_found(tmp_path):
    source, work = tmp_path / "models/here", tmp_path / "work"
    for folder in (source / "images", work):
        folder.mkdir(parents=True)
    (source / "images/t.png").write_bytes(b"png")
    (source.parent / "up.mtl").write_text("newmtl a\nillum 4\n")
    text = "mtllib ../up.mtl\n" + "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in corners(FAR).tolist()) + "f 1 2 3\n"
    (source / "m.obj").write_text(text)
    copy, centre, more = to_gltf.prepared(source / "m.obj", work)
    assert centre and copy.read_text() != text and (source / "m.obj").read_text() == text and set(more["mtl"]) == {"a"}
    assert (copy.parent / "images/t.png").read_bytes() == b"png" and (copy.parent / "../up.mtl").is_file()


def test_moved_scenes_and_camera_numbers():
    """The translation keeps all digits. Cameras are numbered like the path tracer's: in the order of nodes, without orthographic ones."""
    tree = json.loads(json.dumps(TREE))
    assert [to_gltf.camera_number(tree, name) for name in "abz"] == [0, 1, 0]
    to_gltf.move(tree, FAR)
    assert tree["scenes"][0]["nodes"] == [4] and tree["nodes"][4] == {"translation": FAR, "children": [0, 3]}
    assert to_gltf.camera_number(tree, "b") == 1
    again, rest = to_gltf.parts_of(to_gltf.glb_of(tree, b"rest"))
    assert again == tree and rest == b"rest"


def test_messages_of_blender():
    text = ("WARN (io.obj): source/x.cc:73 load_image_at_path: Cannot load image file: 'a.png'\nInfo: fine\n"
            "00:59:54 | WARNING: More than one texture\n00:59:54 | WARNING: The active Vertex Color will not be exported, as\n"
            "Error: Cannot open")
    assert to_gltf.messages(text) == {"Cannot load image file: 'a.png'", "More than one texture", "Cannot open"}


# A program in place of Blender. It writes what the request's source asks for.
STAND_IN = """
import json, sys
request = json.load(open(sys.argv[-1]))
report = json.load(open(request["source"]))
print("Warning: said twice\\nWarning: said twice")
for key, name in (("glb", "output"), ("exr", "world")):
    if key in report: open(request[name], "wb").write(bytes.fromhex(report[key]))
if "glb" in report: json.dump(report, open(request["report"], "w"))
"""


def test_conversion_with_a_stand_in_for_blender(tmp_path, monkeypatch, capsys):
    """The world lies beside the GLB; unchanged files keep their time; the second line has the options that the path tracer needs."""
    python = tmp_path / "python"
    python.write_text(f"#!{sys.executable}\n{STAND_IN}")
    python.chmod(0o755)
    monkeypatch.setattr(to_gltf, "blender", lambda program: python)
    scene, glb = tmp_path / "s.blend", tmp_path / "s.glb"

    def said(**report):
        scene.write_text(json.dumps({"lost": ["hair"], "bounds": [[0, 0, 0], [1, 1, 1]], "glb": to_gltf.glb_of(TREE, b"").hex(), **report}))
        to_gltf.run([str(scene)])
        return capsys.readouterr().out

    first = f"to-gltf: wrote {glb}, without: hair, said twice\nto-gltf: render it with --scene {glb} "
    assert said(brightest=2.0, exr="00ff", camera="b", lens=0.0125, focus=3.0) == (
        f"{first}--camera 1 --env {tmp_path}/s.world.exr --lens 0.0125 --focus 3\n")
    assert (tmp_path / "s.world.exr").read_bytes() == b"\x00\xff"
    before = glb.stat().st_mtime_ns
    assert said(brightest=0.0) == f"{first}--env none\n" and glb.stat().st_mtime_ns == before
    lines = [f"{tmp_path}/out/scene/s.glb is {scene} as glTF, with --env none", f"{scene}: conversion to glTF loses hair, said twice"]
    assert to_gltf.scene_for(scene, tmp_path / "out", "demo")[1:] == (["--env", "none"], lines)
    assert to_gltf.scene_for(glb, tmp_path / "out", "demo") == (str(glb), [], [])
    empty = {"glb": to_gltf.glb_of({**TREE, "meshes": []}, b"").hex()}
    scene.write_text(json.dumps({"lost": [], "bounds": [[1e5, 0, 0], [1e5 + 1, 1, 1]], "glb": to_gltf.glb_of(TREE, b"").hex()}))
    assert "the last digits" in to_gltf.convert(scene, glb)[0][1]
    for wrong, message in ((empty, "s.blend has no triangles"), ({}, "cannot read .*s.blend")):
        scene.write_text(json.dumps({"lost": [], **wrong}))
        with pytest.raises(to_gltf.CommandError, match=message):
            to_gltf.run([str(scene)])


def test_other_files_are_refused_and_the_size_of_blender_is_said(tmp_path, monkeypatch, capsys):
    (tmp_path / "s.txt").write_text("no mesh")
    (tmp_path / "s.obj").write_text("v 0 0 0\n")
    for arguments, message in ((["s.txt"], "none of .blend, .obj"), (["none.obj"], "there is no file"),
                               (["s.obj", "-o", "a.obj"], "named .glb")):
        with pytest.raises(to_gltf.CommandError, match=message):
            to_gltf.run([str(tmp_path / arguments[0]), *arguments[1:]])
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PYTHON311", "/bin/false")
    with pytest.raises(to_gltf.CommandError, match="cannot install Blender"):
        to_gltf.run([str(tmp_path / "s.obj")])
    assert "400 MB" in (said := capsys.readouterr().err) and str(tmp_path / "libbn/blender-4.5") in said
    monkeypatch.setattr(to_gltf.shutil, "which", lambda name: None)
    with pytest.raises(to_gltf.CommandError, match="needs Python 3.11"):
        to_gltf.run([str(tmp_path / "s.obj")])
