# SPDX-License-Identifier: Apache-2.0
"""Scene files in which something is wrong: one clear line, and no picture."""

import io
import json
import struct

import numpy as np
import pytest
from PIL import Image
from scene_files import DOWN, FOUR, QUAD, SIX, SMALL, Gltf, encoded, floor, picture, textured_floor


# ---- What is wrong


def refused(pathtracer, path, *words):
    message = pathtracer.failure("--scene", path, *SMALL, "--spp", 1, "-o", "out.exr", said=words)
    assert message.startswith(f"pathtracer: {path}: ")


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


def cmyk_jpeg():
    stream = io.BytesIO()
    Image.new("CMYK", (8, 8)).save(stream, "JPEG")
    return stream.getvalue()


def jpeg_without_codes():
    """A progressive scan of coefficients whose Huffman table is missing: some decoders read what they never wrote."""
    segment = lambda marker, body: struct.pack(">BBH", 255, marker, len(body) + 2) + body
    frame = segment(0xC2, struct.pack(">BHHBBBB", 8, 5, 7, 1, 1, 0x11, 0))
    scan = segment(0xDA, bytes([1, 1, 0, 52, 52, 0x34]))
    return b"\xff\xd8" + segment(0xDB, b"\0" + b"\1" * 64) + segment(0xC4, b"\0\1" + bytes(16)) + frame + scan


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
        "not an image",
    ),
    "a picture cut short": (
        lambda g: texture_on_floor(g, bufferView=g.view(encoded(FOUR)[:50]), mimeType="image/png"),
        "cut short",
    ),
    "a damaged picture": (
        lambda g: texture_on_floor(g, bufferView=g.view(encoded(FOUR).replace(b"IDATx", b"IDAT-")), mimeType="image/png"),
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
    "a TGA cut short": (
        lambda g: texture_on_floor(g, bufferView=g.view(encoded(FOUR, "TGA")[:-26 - 1])),  # 26: the footer
        "cut short",
    ),
    "a picture for print": (lambda g: texture_on_floor(g, bufferView=g.view(cmyk_jpeg())), "CMYK"),
    "a picture without codes": (lambda g: texture_on_floor(g, bufferView=g.view(jpeg_without_codes())), "damaged"),
    "a picture outside of its buffer": (
        lambda g: texture_on_floor(g, bufferView=g.add("bufferViews", buffer=0, byteOffset=10**6, byteLength=99)),
        "past the end",
    ),
    "no triangles": (lambda g: g.json["scenes"][0].update(nodes=[]), "no triangles"),
    "another version": (lambda g: g.json["asset"].update(version="1.0"), "version 2"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_file_is_refused_with_one_line(pathtracer, what, monkeypatch):
    # The address sanitizer fills memory with these bytes.
    monkeypatch.setenv("ASAN_OPTIONS", "malloc_fill_byte=255:max_malloc_fill_size=1000000")
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


def test_a_length_in_the_header_that_ends_before_the_first_chunk(pathtracer):
    whole = bytearray(floor().glb())
    path = pathtracer.folder / "lengths.glb"
    for length in (0, 12, 19, len(whole) + 1):
        for chunk in (2**32 - 1, 2**31, 1000):
            whole[8:12], whole[12:16] = struct.pack("<I", length), struct.pack("<I", chunk)
            path.write_bytes(whole)
            refused(pathtracer, path, "cut short")


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
    done = pathtracer.success("--scene", path, *SMALL, "--spp", 1, "--env", even_sky, "-o", "out.exr")
    assert done.stderr == f"pathtracer: {path}: ignores the missing material file lost.mtl\n"


@pytest.mark.parametrize("name", ["a.glb", "a.gltf"])
def test_an_extension_that_keeps_buffers_elsewhere_is_named(pathtracer, name):
    """Its fallback buffers have no bytes and no URI."""
    g = floor()
    document = g.document()
    document["buffers"] += [{"byteLength": 96, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}] * 2
    document["extensionsUsed"] = document["extensionsRequired"] = ["KHR_mesh_quantization", "EXT_meshopt_compression"]
    g.document = lambda **buffer: document
    g.save(pathtracer.folder / name)
    refused(pathtracer, pathtracer.folder / name, "requires the extension EXT_meshopt_compression")
