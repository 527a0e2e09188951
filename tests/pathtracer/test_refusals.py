# SPDX-License-Identifier: Apache-2.0
"""Tests that invalid, endless and huge files are refused quickly, with little memory, no image, and one line that names the file."""

import functools
import operator
import os
import struct
import subprocess

import numpy as np
import pytest
import scene_files as files
from scene_files import DOWN, FOUR, LARGE_FOUR, ONE, QUAD, SIX, Gltf, ball, encoded, floor, picture, textured_floor, write_exr

BOUND = 0.25  # --max-memory in GiB; a normal run takes 0.03
OUT = [*ONE, "-o", "out.exr"]


def refused(pathtracer, *arguments, said=()):
    """Returns the error line, which must contain all strings in `said` and name the last argument's file."""
    bound = [] if pathtracer.has_address_sanitizer else ["--max-memory", BOUND]
    log = pathtracer.folder / "said.txt"
    with open(log, "w") as file:
        process = pathtracer.start(*arguments, *bound, *OUT, stderr=file, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    line = log.read_text()
    assert process.returncode == 1 and line.startswith("pathtracer: ") and line.count("\n") == 1, line
    assert not (pathtracer.folder / "out.exr").exists()
    assert os.path.basename(arguments[-1]) in line or "out of memory" in line, line
    assert all(word in line for word in ([said] if isinstance(said, str) else said)), line
    assert pathtracer.has_address_sanitizer or usage.ru_maxrss < (BOUND + 0.1) * 2**20, f"{usage.ru_maxrss} KiB: {line}"
    return line


def put(path, data):
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


# ---- Each case writes files to a folder and returns the arguments of one or two runs, whose last argument is the invalid file


def scene(data, name="wrong.gltf"):
    return lambda folder: [["--scene", put(folder / name, data)]]


def gltf(change):
    """A modified floor, as GLB and as glTF."""

    def write(folder):
        g = floor()
        change(g)
        return [["--scene", g.save(folder / name)] for name in ("wrong.glb", "wrong.gltf")]

    return write


def part(*path, **properties):
    """A floor with changed properties of the element at `path`, such as "accessors", 0."""
    return gltf(lambda g: functools.reduce(operator.getitem, path, g.json).update(properties))


def image(data):
    return gltf(lambda g: texture_on_floor(g, bufferView=g.view(data), mimeType="image/png"))


def exr(change):
    """An EXR file with the contents `change`, or with the result of the function `change` for the bytes of an 8 x 8 image."""

    def write(folder):
        path = write_exr(folder / "a.exr", RGB=np.zeros((8, 8, 3), np.float32))
        put(path, change(path.read_bytes()) if callable(change) else change)
        return [[option, "a.exr"] for option in ("--env", "--merge")]

    return write


def texture_on_floor(g, **source):
    number = g.add("textures", source=g.add("images", **source))
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": number}


def two_parents(g):
    """Each node has two references to the same child. After forty generations, following all of them would visit 2^40 nodes."""
    last = g.node(root=False, mesh=0)
    for _ in range(40):
        last = g.node(root=False, children=[last, last])
    g.json["scenes"][0]["nodes"].append(last)


def zeros(g, count=2**26, place=None):
    """An accessor of `count` zeros without a buffer view, with an optional sparse value at index `place`."""
    g.json["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": count}
    if place is not None:
        indices = {"bufferView": g.view(struct.pack("<I", place)), "componentType": 5125}
        g.json["accessors"][0]["sparse"] = {"count": 1, "indices": indices, "values": {"bufferView": g.view(bytes(12))}}


def one_mesh_in_many_nodes(g):
    mesh = g.mesh(np.random.default_rng(0).random((5000, 3), np.float32), np.arange(3000, dtype=np.uint16))
    for _ in range(2000):
        g.node(mesh=mesh)


def many_large_images(g):
    primitives = g.json["meshes"][0]["primitives"]
    data = encoded(np.zeros((4096, 4096)))
    for _ in range(5):
        source = g.add("images", bufferView=g.view(data))
        pbr = {"baseColorTexture": {"index": g.add("textures", source=source)}}
        primitives.append({**primitives[0], "material": g.add("materials", pbrMetallicRoughness=pbr)})


def claiming(data, at, layout, *values):
    """Returns a copy of a file with false values in its header."""
    return data[:at] + struct.pack(layout, *values) + data[at + struct.calcsize(layout):]


FLOOR, PNG, JPEG = floor().glb(), encoded(FOUR), encoded(FOUR, "JPEG")
PROGRESSIVE = encoded(LARGE_FOUR, "JPEG", progressive=True)
EXR_START, NO_EXR = struct.pack("<II", 20000630, 2), "cannot read the EXR file a.exr"
WINDOW = struct.pack("<4i", 0, 0, 7, 7)  # of an 8 x 8 image
START = '{"asset": {"version": "2.0"}, '
CASES = {
    # Indices, counts and offsets out of range
    "index_out_of_range": (gltf(lambda g: g.bytes.__setitem__(slice(48, 50), b"\x04\0")), "index out of range"),
    "sparse_index_out_of_range": (gltf(lambda g: zeros(g, 4, 9)), "index out of range"),
    "count_beyond_the_buffer_view": (part("accessors", 0, count=5), "runs past the end"),
    "count_overflows": (part("accessors", 0, count=2**60), ""),
    "many_zeros_without_a_buffer_view": (gltf(zeros), "out of memory"),
    "many_sparse_zeros": (gltf(lambda g: zeros(g, place=0)), "out of memory"),
    "offset_beyond_the_buffer_view": (part("accessors", 0, byteOffset=2**40), "runs past the end"),
    "positions_with_two_components": (part("accessors", 0, type="VEC2"), "number of components"),
    "unknown_component_type": (part("accessors", 0, componentType=5124), ""),
    "indices_are_floats": (part("accessors", 1, componentType=5126), "unsigned integers"),
    "buffer_view_beyond_the_buffer": (part("bufferViews", 0, byteLength=10**9), "past the end"),
    "buffer_view_offset_overflows": (part("bufferViews", 0, byteOffset=2**62), ""),
    "missing_buffer_view": (part("accessors", 0, bufferView=77), "refers to bufferViews[77]"),
    "missing_mesh": (part("nodes", 0, mesh=3), "refers to meshes[3]"),
    "missing_node": (gltf(lambda g: g.json["scenes"][0]["nodes"].append(9)), "refers to nodes[9]"),
    "missing_scene": (part(scene=4), "refers to scenes[4]"),
    "missing_material": (part("meshes", 0, "primitives", 0, material=5), "refers to materials[5]"),
    "missing_camera": (part("nodes", 0, camera=5), "refers to cameras[5]"),
    "missing_light": (part("nodes", 0, extensions={"KHR_lights_punctual": {"light": 2}}), "refers to lights[2]"),
    # Files that do not describe a valid scene
    "vertex_is_nan": (gltf(lambda g: g.bytes.__setitem__(slice(4, 8), struct.pack("<f", np.nan))), "not a finite number"),
    "vertex_beyond_1e15": (part("nodes", 0, translation=[1e30, 0, 0]), "not a finite number"),
    "extent_beyond_1e10": (part("nodes", 0, scale=[1.01e10] * 3), "more than 1e10 from its centre"),
    "node_cycle": (gltf(lambda g: g.json["nodes"][0].update(children=[g.node(root=False, children=[0])])), "twice"),
    "node_with_two_parents": (gltf(two_parents), "twice"),
    "no_triangles": (part("scenes", 0, nodes=[]), "no triangles"),
    "version_1": (part("asset", version="1.0"), "version 2"),
    "version_2_1": (part("asset", version="2.1", minVersion="2.1"), "is glTF 2.1"),
    "unknown_required_extension": (part(extensionsRequired=["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression"),
    "one_mesh_in_many_nodes": (gltf(one_mesh_in_many_nodes), ""),
    "large_images": (gltf(many_large_images), ""),
    "many_materials": (scene(START + '"materials": [' + "{}," * 300000 + "{}]}"), ""),
    "many_json_values": (scene(START + '"extras": [' + "0," * 2**22 + "0]}"), ""),
    "missing_file": (lambda folder: [["--scene", "none.glb"]], "none.glb: there is no such file"),
    **{f"glb_claims_{file}_bytes_and_a_chunk_of_{first}": (scene(claiming(FLOOR, 8, "<II", file, first), "wrong.glb"), "cut short")
       for file in (0, 12, 19, len(FLOOR), len(FLOOR) + 1) for first in (2**32 - 1, 2**31, len(FLOOR) - 19)},
    "truncated_glb": (scene(textured_floor(files.LARGE_FOUR).glb()[:900], "wrong.glb"), "cut short"),
    "truncated_gltf": (scene(floor().gltf()[:300]), "not valid glTF"),
    "empty_file": (scene("", "wrong.glb"), ""),
    "gltf_is_text": (scene("no glTF"), ""), "gltf_is_a_json_list": (scene("[1, 2]"), ""),
    "deeply_nested_json": (scene(START + '"extras": ' + "[" * 100000 + "]" * 100000 + "}"), "no triangles"),
    # Images
    "data_uri_is_not_an_image": (gltf(lambda g: texture_on_floor(g, uri="data:image/png;base64,eHh4eA==")), "image 0: is neither"),
    "data_uri_is_not_base64": (gltf(lambda g: texture_on_floor(g, uri="data:image/png;base64,??")), "image 0: is not valid base64"),
    "image_is_text": (image(b"x" * 64), "neither PNG nor JPEG"),
    "image_is_tga": (image(encoded(FOUR, "TGA")), "neither PNG nor JPEG"),
    **{f"png_without_its_last_{n}_bytes": (image(PNG[:-n]), "damaged") for n in (1, 8, 13, 20, 30)},
    **{f"png_with_another_byte_{n}": (image(PNG[:n] + bytes([PNG[n] ^ 4]) + PNG[n + 1:]), "damaged") for n in (12, 30, 45, len(PNG) - 17)},
    **{f"{kind}_jpeg_without_its_last_{n}_bytes": (image(data[:-n]), "damaged")
       for kind, data in (("plain", JPEG), ("progressive", PROGRESSIVE)) for n in (8, 99, len(data) - 30)},
    "progressive_jpeg_without_an_end": (image(PROGRESSIVE[:-2]), "damaged"),
    "png_claims_2_60_texels": (image(claiming(PNG, 16, ">II", 2**30, 2**30)), "damaged"),
    "image_outside_its_buffer": (
        gltf(lambda g: texture_on_floor(g, bufferView=g.add("bufferViews", buffer=0, byteOffset=10**6, byteLength=99))), "past the end"),
    "large_png": (image(claiming(PNG, 16, ">II", 30000, 16000)), ""),
    "large_one_bit_png": (image(claiming(PNG, 16, ">IIBB", 30000, 16000, 1, 0)), ""),
    "large_jpeg": (image(claiming(JPEG, JPEG.index(b"\xff\xc0") + 5, ">HH", 16000, 30000)), ""),
    **{f"png_chunk_{kind.decode()}_claims_1_gib": (image(PNG[:33] + struct.pack(">I", 2**30) + kind + bytes(90)), "damaged")
       for kind in (b"IDAT", b"PLTE", b"iCCP", b"aaaa")},
    # EXR
    "attribute_of_1_5_gib": (exr(EXR_START + b"a\0string\0" + struct.pack("<i", 0x60000000) + bytes(40)), NO_EXR),
    "attribute_of_negative_size": (exr(EXR_START + b"a\0string\0" + struct.pack("<i", -1) + bytes(40)), NO_EXR),
    "unterminated_attribute_name": (exr(EXR_START + b"a" * 400), NO_EXR),
    "truncated_exr_header": (exr(lambda data: data[:200]), NO_EXR),
    "exr_is_text": (exr("text" * 999), NO_EXR),
    "empty_exr": (exr(""), NO_EXR),
    **{f"exr_claims_{w}x{h}": (exr(lambda data, window=struct.pack("<4i", 0, 0, w - 1, h - 1): data.replace(WINDOW, window)), NO_EXR)
       for w, h in ((16384, 8192), (2**24, 1), (1, 2**24))},
    "environment_is_grey": (lambda folder: [["--env", write_exr(folder / "a.exr", Y=np.ones((4, 8), np.float32))]], "it has no channel R"),
    "environment_is_not_finite": (lambda folder: [["--env", files.write_environment(folder / "a.exr", np.nan)]], "not finite"),
}


@pytest.mark.parametrize("what", CASES)
def test_an_invalid_file_is_refused_in_one_line(pathtracer, what, monkeypatch):
    # The address sanitizer fills new memory with this byte.
    monkeypatch.setenv("ASAN_OPTIONS", "malloc_fill_byte=255:max_malloc_fill_size=1000000:allocator_may_return_null=1")
    write, said = CASES[what]
    if pathtracer.has_address_sanitizer and (said == "out of memory" or what.startswith(("large_", "one_mesh_"))):
        pytest.skip("only --max-memory refuses this file, which does not work with the address sanitizer")
    for arguments in write(pathtracer.folder):
        refused(pathtracer, *arguments, said=said)


def test_deeply_nested_nodes_are_read(pathtracer):
    """Fifty thousand nested nodes move a mesh by the sum of their translations."""
    g, count = Gltf(), 50_000
    g.json["nodes"] = [{"children": [i + 1], "translation": [0.25, 0, 0]} for i in range(count)]
    g.json["nodes"].append({"mesh": g.mesh(QUAD, SIX, g.material())})
    g.json["scenes"][0]["nodes"] = [0]
    g.light("directional", np.pi, rotation=DOWN)
    g.camera(0.4, translation=[0.25 * count, 1, 0], rotation=DOWN)
    np.testing.assert_allclose(picture(pathtracer, g, "--spp", 1, "--max-depth", 1), 0.5, rtol=1e-3)


def test_largest_extents_and_distances(pathtracer):
    """Images are correct for extents of up to 1e10 from the scene's centre. Lights beyond 1e15 are left out."""
    far, near = (picture(pathtracer, files.room(scale), "--spp", 4) for scale in (0.99e10, 1))
    np.testing.assert_allclose(far, near, rtol=1e-3)
    g = Gltf()
    ball(g, g.material())
    g.json["nodes"][0].update(scale=[0.99e10] * 3, translation=[9e14, 0, 0])
    picture(pathtracer, g, "--spp", 4)
    for distance in (0.9e15, 1.1e15, 1e30):
        g = floor()
        g.light("point", 1, translation=[0, distance, 0])
        line = pathtracer.success("--scene", g, "--env", "sky", *OUT).stderr
        assert ("a light beyond 1e15" in line) == (distance > 1e15)


def apart(pathtracer, buffer="a.bin", image=None, folder="."):
    """Saves a textured floor that refers to buffer and image files with these names. Returns its path and the buffer's contents."""
    g = textured_floor()
    if image:
        g.json["images"] = [{"uri": image}]
    return put(pathtracer.folder / folder / "scene.gltf", g.text(uri=buffer)), bytes(g.bytes)


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_only_regular_files_are_read(pathtracer, kind):
    """Reading a pipe or device may never end."""
    make = {"pipe": os.mkfifo, "folder": os.mkdir, "device": lambda path: path.symlink_to("/dev/zero")}[kind]
    for name in ("a.bin", "a.png", "a.exr", "whole.glb"):
        make(pathtracer.folder / name)
    path, data = apart(pathtracer, "b.bin", "a.png")
    put(pathtracer.folder / "b.bin", data)
    refused(pathtracer, "--scene", path, said=["a.png", "not a regular file"])
    refused(pathtracer, "--scene", apart(pathtracer)[0], said=["a.bin", "not a regular file"])
    for arguments in (["--scene", "whole.glb"], ["--env", "a.exr"], ["--merge", "a.exr"], ["--resume", "a.exr"]):
        refused(pathtracer, *arguments, said="not a regular file")


def test_uris_are_relative_to_the_scene(pathtracer):
    """They may use links and parent folders. Files in the current folder are not found."""
    folder = pathtracer.folder
    path, data = apart(pathtracer, "sub/../link.bin", "../a%20b.png", "in")
    (folder / "in/sub").mkdir()
    put(folder / "in/a.bin", data)
    (folder / "in/link.bin").symlink_to("a.bin")
    put(folder / "a b.png", encoded(FOUR))
    assert pathtracer.image("--scene", path, *ONE).max() > 0
    path, data = apart(pathtracer, "b.bin", folder="in")
    put(folder / "b.bin", data)
    refused(pathtracer, "--scene", path, said="buffer b.bin: there is no such file")
    put(folder / "in/b.bin", data[:-1])
    refused(pathtracer, "--scene", path, said="is cut short: buffer b.bin has")
    path, _ = apart(pathtracer, "\x1b[2J\n" + "long" * 1000)
    refused(pathtracer, "--scene", path, said="buffer ?[2J?longlong")


def test_no_control_characters_reach_the_terminal(pathtracer):
    """File names and attributes contain control characters, including a sequence that sets the window's title."""
    evil = "a\x1b]0;b\x07\x7f\n.exr"
    controls = [chr(c) for c in [*range(10), *range(11, 32), 127]]

    def said(*arguments, code):
        done = pathtracer.run(*arguments)
        assert done.returncode == code, done.stderr
        text = done.stdout + done.stderr
        assert text and not any(c in text for c in controls) and text.count("\n") <= 2, repr(text)
        return text

    said(*ONE, "-o", evil, code=0)
    for wrong in (["--scene", evil], ["--scene", evil.replace("exr", "glb")], ["--env", "no" + evil], ["-" + evil]):
        said(*wrong, *OUT, code=1)
    said("--merge", evil, "-o", "b" + evil, code=0)
    # Replaces the ten-letter file name in the image's attributes by one of the same length.
    floor().save(pathtracer.folder / "scene1.glb")
    begun = pathtracer.render(*ONE, "--scene", "scene1.glb")
    put(begun, begun.read_bytes().replace(b"scene1.glb", b"\x1b]0;1m.glb"))
    assert "]0;1m.glb" in said("--resume", begun, "--spp", 2, "-o", "out.exr", code=1)
    said("--merge", begun, pathtracer.render(*ONE), "-o", "out.exr", code=1)
