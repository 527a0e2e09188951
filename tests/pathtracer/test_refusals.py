# SPDX-License-Identifier: Apache-2.0
"""Files that are wrong, or made to read what is not theirs, to never end or to take all memory: one clear line that names
the file, soon, with little memory, and no picture."""

import io
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np
import pytest
import scene_files as files
from PIL import Image
from scene_files import DOWN, FOUR, QUAD, SIX, SMALL, Gltf, ball, encoded, floor, picture, textured_floor

BOUND = 0.75  # GiB of --max-memory; a run takes 0.03 without any of this
OUT = [*SMALL, "--spp", 1, "-o", "out.exr"]


def run(pathtracer, *arguments, code=1, gib=BOUND):
    """The bytes that a run takes at most, and its one line."""
    said = pathtracer.folder / "said.txt"
    bound = [] if pathtracer.has_address_sanitizer else ["--max-memory", gib]
    with open(said, "w") as file:
        process = pathtracer.start(*arguments, *bound, *OUT, stderr=file, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    line = said.read_text()
    assert process.returncode == code and line.count("\n") <= 1, line
    assert code == 0 or (line.startswith("pathtracer: ") and not (pathtracer.folder / "out.exr").exists()), line
    return usage.ru_maxrss * 1024, line


def refused(pathtracer, *arguments, words=(), name=""):
    memory, line = run(pathtracer, *arguments)
    for word in (words,) if isinstance(words, str) else words:
        assert word in line, line
    assert str(name) in line or "out of memory" in line, line
    assert pathtracer.has_address_sanitizer or memory < (BOUND + 0.1) * 2**30, f"{memory / 1e6:.0f} MB: {line}"


def put(path, data):
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


# ---- What is wrong: each case writes files in a folder, and returns the arguments that name them, and the file at fault


def scene(data, name="wrong.gltf"):
    return lambda folder: [(["--scene", put(folder / name, data)], name)]


def gltf(change, base=floor):
    def write(folder):
        g = base()
        change(g)
        return [(["--scene", g.save(folder / name)], name) for name in ("wrong.glb", "wrong.gltf")]

    return write


def texture(data):
    return gltf(lambda g: texture_on_floor(g, bufferView=g.view(data), mimeType="image/png"))


def mask(data):
    return lambda folder: [(["--sampler", "mask", "--mask", put(folder / "a.png", data)], "a.png")]


def exr(data):
    def write(folder):
        put(folder / "a.exr", data)
        return [([option, "a.exr"], "cannot read the EXR file a.exr") for option in ("--env", "--merge", "--reference")]

    return write


def environment(**channels):
    return lambda folder: [(["--env", put(folder / "a.exr", exr_of(**channels))], "a.exr")]


def texture_on_floor(g, **image):
    number = g.add("textures", source=g.add("images", **image))
    g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": number}


def accessor(number, **properties):
    return gltf(lambda g: g.json["accessors"][number].update(properties))


def node(**properties):
    return gltf(lambda g: g.json["nodes"][0].update(properties))


def cycle(g):
    g.json["nodes"][0]["children"] = [g.node(root=False, children=[0])]


def two_parents(g):
    """Forty generations of twins of twins would be 2^40 nodes if they were followed."""
    last = g.node(root=False, mesh=0)
    for _ in range(40):
        last = g.node(root=False, children=[last, last])
    g.json["scenes"][0]["nodes"].append(last)


def zeros(g, count=2**26, place=None):
    """A count that no buffer has to fill, and one value at a place."""
    g.json["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": count}
    if place is not None:
        indices = {"bufferView": g.view(struct.pack("<I", place)), "componentType": 5125}
        g.json["accessors"][0]["sparse"] = {"count": 1, "indices": indices, "values": {"bufferView": g.view(bytes(12))}}


def many_times(g):
    """One mesh of many nodes."""
    mesh = g.mesh(np.random.default_rng(0).random((5000, 3), np.float32), np.arange(3000, dtype=np.uint16))
    for _ in range(1500):
        g.node(mesh=mesh)


def many_textures(g):
    """Textures that share a picture are decoded one by one."""
    source = g.add("images", bufferView=g.view(encoded(np.zeros((4096, 4096)))))
    primitives = g.json["meshes"][0]["primitives"]
    for _ in range(12):
        pbr = {"baseColorTexture": {"index": g.add("textures", source=source)}}
        primitives.append({**primitives[0], "material": g.add("materials", pbrMetallicRoughness=pbr)})


def buffer_apart(data=None):
    """A floor whose buffer is a file of these bytes, or of none."""

    def write(folder):
        if data is not None:
            put(folder / "apart.bin", data)
        return [(["--scene", put(folder / "wrong.gltf", json.dumps(floor().document(uri="apart.bin")))], "wrong.gltf")]

    return write


FLOOR = floor().glb()


def glb_lengths(file, first_chunk):
    """What its header says of the whole and of its first chunk."""
    return scene(FLOOR[:8] + struct.pack("<II", file, first_chunk) + FLOOR[16:], "wrong.glb")


def claiming(data, at, layout, *size):
    """A picture whose header claims something else."""
    changed = bytearray(data)
    struct.pack_into(layout, changed, at, *size)
    return bytes(changed)


def png(*claims):
    """Width and height; depth and colours, if given."""
    return claiming(encoded(FOUR), 16, ">IIBB"[:1 + len(claims)], *claims)


def long_chunk(kind):
    """A chunk that claims more than there is."""
    return encoded(FOUR)[:33] + struct.pack(">I", 2**30) + kind + bytes(90)


def jpeg(pixels=FOUR, mode="RGB", **options):
    stream = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).convert(mode).save(stream, "JPEG", **options)
    return stream.getvalue()


EXR_START = struct.pack("<II", 20000630, 2)


def exr_of(**channels):
    with tempfile.TemporaryDirectory() as folder:
        return files.write_exr(pathlib.Path(folder) / "a.exr", **channels).read_bytes()


def exr_window(width, height):
    """A picture of 8 x 8 that claims to be so large."""
    data = exr_of(RGB=np.zeros((8, 8, 3), np.float32))
    return data.replace(struct.pack("<iiii", 0, 0, 7, 7), struct.pack("<iiii", 0, 0, width - 1, height - 1))


CASES = {
    # glTF: numbers that lead out of their arrays
    "an index out of range": (gltf(lambda g: g.bytes.__setitem__(slice(48, 50), b"\x04\0")), "index out of range"),
    "a count beyond its view": (accessor(0, count=5), "run past the end"),
    "a huge count": (accessor(0, count=2**60), ""),
    "zeros without end": (gltf(zeros), "more memory"),
    "zeros and a value": (gltf(lambda g: zeros(g, place=0)), "more memory"),
    "an offset beyond its view": (accessor(0, byteOffset=2**40), "run past the end"),
    "no such view": (accessor(0, bufferView=77), "refers to buffer view 77"),
    "positions of two numbers": (accessor(0, type="VEC2"), "number of components"),
    "a number type of its own": (accessor(0, componentType=5124), ""),
    "indices that are floats": (accessor(1, componentType=5126), "unsigned integers"),
    "a view beyond its buffer": (gltf(lambda g: g.json["bufferViews"][0].update(byteLength=10**9)), "past the end"),
    "a bufferView whose offset overflows": (gltf(lambda g: g.json["bufferViews"][0].update(byteOffset=2**62)), ""),
    "no such mesh": (node(mesh=3), "refers to mesh 3"),
    "no such node": (gltf(lambda g: g.json["scenes"][0]["nodes"].append(9)), "refers to node 9"),
    "no such scene": (gltf(lambda g: g.json.update(scene=4)), "refers to scene 4"),
    "no such material": (
        gltf(lambda g: g.json["meshes"][0]["primitives"][0].update(material=5)), "refers to material 5"),
    "no such camera": (node(camera=5), "refers to camera 5"),
    "no such light": (node(extensions={"KHR_lights_punctual": {"light": 2}}), "refers to light 2"),
    # What makes no scene
    "a vertex that is no number": (
        gltf(lambda g: g.bytes.__setitem__(slice(4, 8), struct.pack("<f", np.nan))), "not a finite number"),
    "a vertex beyond all bounds": (node(translation=[1e30, 0, 0]), "not a finite number"),
    "too far from the centre": (node(scale=[1.01e10] * 3), "more than 1e10 from its centre"),
    "a cycle of nodes": (gltf(cycle), "twice"),
    "nodes with two parents": (gltf(two_parents), "twice"),
    "no triangles": (gltf(lambda g: g.json["scenes"][0].update(nodes=[])), "no triangles"),
    "a missing buffer": (buffer_apart(), "apart.bin: there is no such file"),
    "a buffer cut short": (buffer_apart(b"0"), "apart.bin"),
    "another version": (gltf(lambda g: g.json["asset"].update(version="1.0")), "version 2"),
    "a later version": (gltf(lambda g: g.json["asset"].update(version="2.1", minVersion="2.1")), "is glTF 2.1"),
    "a sparse index out of range": (gltf(lambda g: zeros(g, 4, 9)), "index out of range"),
    "an extension it requires": (
        gltf(lambda g: g.json.update(extensionsRequired=["KHR_draco_mesh_compression"])), "KHR_draco_mesh_compression"),
    # Much of little
    "a mesh of many nodes": (gltf(many_times), ""),
    "many textures of one picture": (gltf(many_textures), "more memory"),
    "many materials": (scene('{"asset": {"version": "2.0"}, "materials": [' + "{}," * 300000 + "{}]}"), ""),
    "many values": (scene('{"asset": {"version": "2.0"}, "extras": [' + "0," * 2**22 + "0]}"), ""),
    # No glTF
    "a missing file": (lambda folder: [(["--scene", "none.glb"], "none.glb")], "none.glb: there is no such file"),
    **{f"a GLB of {file} and {first} bytes": (glb_lengths(file, first), "cut short")
       for file in (0, 12, 19, len(FLOOR), len(FLOOR) + 1) for first in (2**32 - 1, 2**31, len(FLOOR) - 19)},
    "a GLB cut short": (scene(textured_floor(files.LARGE_FOUR).glb()[:900], "wrong.glb"), "cut short"),
    "a glTF cut short": (scene(floor().gltf()[:300]), "not valid glTF"),
    "an empty file": (scene("", "wrong.glb"), ""),
    "text": (scene("no glTF"), ""),
    "a list": (scene("[1, 2]"), ""),
    "nested deeply": (scene('{"asset":{"version":"2.0"},"extras":' + "[" * 100000 + "]" * 100000 + "}"), "no triangles"),
    # Pictures
    "a picture in a URI": (gltf(lambda g: texture_on_floor(g, uri="data:image/png;base64,eHh4eA==")), "image 0: is not an image"),
    "a URI that is no base64": (gltf(lambda g: texture_on_floor(g, uri="data:image/png;base64,??")), "image 0: is not valid base64"),
    "a picture that is none": (texture(b"x" * 64), "not an image"),
    "a picture cut short": (texture(encoded(FOUR)[:50]), "damaged"),
    "a damaged picture": (texture(encoded(FOUR).replace(b"IDATx", b"IDAT-")), "damaged"),
    "a picture of 2^60 texels": (texture(png(2**30, 2**30)), "damaged"),
    "a picture of 2^32 texels": (texture(png(2**16, 2**16)), "texels; at most"),
    "a picture of another kind": (texture(encoded(FOUR, "TGA")), "PNG or JPEG"),
    "a picture for print": (texture(jpeg(mode="CMYK")), "CMYK"),
    "a picture outside of its buffer": (
        gltf(lambda g: texture_on_floor(g, bufferView=g.add("bufferViews", buffer=0, byteOffset=10**6, byteLength=99))),
        "past the end"),
    **{f"a large {name}": (texture(data), "") for name, data in {
        "PNG": png(30000, 16000), "PNG of bits": png(30000, 16000, 1, 0),
        "JPEG": claiming(jpeg(), jpeg().index(b"\xff\xc0") + 5, ">HH", 16000, 30000)}.items()},
    **{f"a long {kind.decode()}": (texture(long_chunk(kind)), "damaged") for kind in (b"IDAT", b"PLTE", b"iCCP", b"aaaa")},
    "a mask with a long chunk": (mask(long_chunk(b"iTXt")), ""),
    "a mask that is none": (mask("no picture"), ""),
    "a large mask": (mask(encoded(np.zeros((5000, 5000)))), "at most 2^24 texels"),
    # EXR
    "an attribute of 1.5 GiB": (exr(EXR_START + b"a\0string\0" + struct.pack("<i", 0x60000000) + bytes(40)), ""),
    "a negative size": (exr(EXR_START + b"a\0string\0" + struct.pack("<i", -1) + bytes(40)), ""),
    "a name without an end": (exr(EXR_START + b"a" * 400), ""),
    "a header cut short": (exr(exr_window(8, 8)[:200]), ""),
    "an EXR of text": (exr("text" * 999), ""),
    "an empty EXR": (exr(""), ""),
    "a picture that is not there": (exr(exr_window(16384, 8192)), ""),
    "a wide row": (exr(exr_window(2**24, 1)), ""),
    "many rows": (exr(exr_window(1, 2**24)), ""),
    "an environment of grey": (environment(Y=np.ones((4, 8), np.float32)), "it has no channel R"),
    "an environment that is not finite": (environment(RGB=np.full((4, 8, 3), np.nan, np.float32)), "not finite"),
}


@pytest.mark.parametrize("what", CASES)
def test_a_wrong_file_is_refused_with_one_line(pathtracer, what, monkeypatch):
    # The address sanitizer fills memory with these bytes.
    monkeypatch.setenv("ASAN_OPTIONS", "malloc_fill_byte=255:max_malloc_fill_size=1000000:allocator_may_return_null=1")
    write, words = CASES[what]
    if pathtracer.has_address_sanitizer and (words == "more memory" or what == "a mesh of many nodes"):
        pytest.skip("only --max-memory refuses it, which has no place beside the sanitizer")
    for arguments, name in write(pathtracer.folder):
        refused(pathtracer, *arguments, words=words, name=name)


# ---- What is read still


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


@pytest.mark.parametrize("progressive", [False, True])
def test_jpeg_that_is_cut_short(pathtracer, progressive):
    """What is there is shown, and a line says so, unless the cut makes it no JPEG at all."""
    pixels = np.random.default_rng(1).integers(256, size=(64, 64, 3), dtype=np.uint8)
    whole = jpeg(pixels, quality=95, progressive=progressive)
    scene_of = lambda data: texture(data)(pathtracer.folder)[0][0]
    assert run(pathtracer, *scene_of(whole), code=0)[1] == ""
    for size in range(len(whole) // 2, len(whole), len(whole) // 9):
        done = pathtracer.run(*scene_of(whole[:size]), *OUT)
        said = "image 0 is cut short" if done.returncode == 0 else "image 0: is damaged"
        assert done.stderr.count("\n") == 1 and said in done.stderr, done.stderr


def test_a_scene_reaches_so_far(pathtracer):
    """Up to 1e10 from its middle a picture is right; lights beyond 1e15 are left out."""
    plain = picture(pathtracer, files.cornell(), "--spp", 4)
    # Its largest extent is 559.2, from the middle half of that.
    np.testing.assert_allclose(picture(pathtracer, files.cornell(0.99e10 / 279.6), "--spp", 4), plain, rtol=1e-3)
    g = Gltf()
    ball(g, g.material())
    g.json["nodes"][0].update(scale=[0.99e10] * 3, translation=[9e14, 0, 0])
    picture(pathtracer, g, "--spp", 4)
    for distance in (0.9e15, 1.1e15, 1e30):
        g = floor()
        g.light("point", 1, translation=[0, distance, 0])
        line = run(pathtracer, "--scene", g.save(pathtracer.folder / "a.glb"), "--env", "sky", code=0)[1]
        assert ("a light beyond 1e15" in line) == (distance > 1e15)


# ---- Files that are not a scene's to read


def apart(pathtracer, buffer="a.bin", image=None, folder="."):
    """A textured floor whose buffer and picture are files with these names."""
    g = textured_floor()
    if image:
        g.json["images"] = [{"uri": image}]
    return put(pathtracer.folder / folder / "scene.gltf", json.dumps(g.document(uri=buffer))), bytes(g.bytes)


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_only_regular_files_are_read(pathtracer, kind):
    """What else there is may never end. Devices are outside of all folders, and so allowed here."""
    make = {"pipe": os.mkfifo, "folder": os.mkdir, "device": lambda path: path.symlink_to("/dev/zero")}[kind]
    for name in ("a.bin", "a.png", "a.exr", "whole.glb"):
        make(pathtracer.folder / name)
    path, data = apart(pathtracer, "b.bin", "a.png")
    put(pathtracer.folder / "b.bin", data)
    refused(pathtracer, "--scene", path, "--allow-outside", words=["a.png", "not a regular file"])
    refused(pathtracer, "--scene", apart(pathtracer)[0], "--allow-outside", words=["a.bin", "not a regular file"])
    for arguments in (["--scene", "whole.glb"], ["--env", "a.exr"], ["--reference", "a.exr"],
                      ["--merge", "a.exr"], ["--resume", "a.exr"], ["--sampler", "mask", "--mask", "a.png"]):
        refused(pathtracer, *arguments, words=[arguments[-1], "not a regular file"])


@pytest.mark.parametrize("way", ["../a", "sub/../../a", "%2e%2e/a", "{folder}/a", "link", "linked/a",
                                 "../in-secret/a"])  # a name that begins like the scene's folder
def test_a_scene_reads_files_below_its_folder_only(pathtracer, way):
    """By whatever way their names lead there; with --allow-outside it reads them."""
    folder, name = pathtracer.folder, way.format(folder=pathtracer.folder)
    for inside in ("in", "in/sub", "in-secret"):
        (folder / inside).mkdir()
    (folder / "in/linked").symlink_to("..")
    for end in ("bin", "png"):
        (folder / f"in/link.{end}").symlink_to(f"../a.{end}")
    for outside in ("a.png", "in-secret/a.png"):
        put(folder / outside, encoded(FOUR))
    words = "outside the scene's folder; use --allow-outside"
    path, data = apart(pathtracer, f"{name}.bin", f"{name}.png", "in")
    for outside in ("a.bin", "in-secret/a.bin"):
        put(folder / outside, data)
    refused(pathtracer, "--scene", path, words=[f"{name}.bin".replace("%2e", "."), words])
    assert pathtracer.image("--scene", path, "--allow-outside", *SMALL, "--spp", 1).max() > 0
    path, data = apart(pathtracer, "b.bin", f"{name}.png", "in")
    put(folder / "in/b.bin", data)
    refused(pathtracer, "--scene", path, words=[f"{name}.png", words])


def test_names_that_stay_below_the_folder_are_taken(pathtracer):
    """Dots and links that lead back, and a folder that is a link itself, but nothing from the current folder."""
    folder = pathtracer.folder
    path, data = apart(pathtracer, "sub/../link.bin", "sub/a%20b.png", "in")
    put(folder / "in/a.bin", data)
    (folder / "in/link.bin").symlink_to("a.bin")
    put(folder / "in/sub/a b.png", encoded(FOUR))
    (folder / "door").symlink_to("in")
    plain = pathtracer.image("--scene", path, *SMALL, "--spp", 1)
    for way in ("door/scene.gltf", "in/sub/../scene.gltf"):
        np.testing.assert_array_equal(pathtracer.image("--scene", way, *SMALL, "--spp", 1), plain)
    path, data = apart(pathtracer, "b.bin", folder="in")
    put(folder / "b.bin", data)
    refused(pathtracer, "--scene", path, words="buffer b.bin: there is no such file")
    # A zero hides no part of a name; neither it nor what moves a terminal's cursor is printed.
    path, _ = apart(pathtracer, "../b.bin\0/../in/a.bin", folder="in")
    refused(pathtracer, "--scene", path, words="buffer ../b.bin?/../in/a.bin: has a zero byte in its name")
    path, _ = apart(pathtracer, "\x1b[2J\n" + "long" * 1000)
    refused(pathtracer, "--scene", path, words="buffer ?[2J?longlong")
    assert len(run(pathtracer, "--scene", path)[1]) < 500


# ---- Values, names and memory


def test_a_reference_that_is_not_finite_is_refused(pathtracer):
    """Its error would be no number, or seem perfect."""
    pixels = np.ones((24, 24, 3), np.float32)
    for value in (np.nan, np.inf, -np.inf):
        pixels[7, 9, 1] = value
        files.write_exr(pathtracer.folder / "reference.exr", RGB=pixels)
        refused(pathtracer, "--reference", "reference.exr", words=["reference.exr", "not finite"])
    # Elsewhere than in the crop it does no harm.
    assert "nan" not in pathtracer.success("--reference", "reference.exr", "--crop", "0,8,24,24", *OUT).stdout


def test_no_control_characters_reach_the_terminal(pathtracer):
    """A window's title, and both sets of controls, in names of files and in attributes."""
    evil = "a\x1b]0;b\x07\x7f\u009b31m\n.exr"
    controls = [chr(c) for c in [*range(10), *range(11, 32), *range(127, 160)]]

    def said(*arguments, code):
        done = pathtracer.run(*arguments)
        assert done.returncode == code, done.stderr
        text = done.stdout + done.stderr
        assert text and not any(c in text for c in controls) and text.count("\n") <= 2, repr(text)
        return text

    size = [*SMALL, "--spp", 1]
    said(*size, "-o", evil, code=0)
    for wrong in (["--scene", evil], ["--scene", evil.replace("exr", "glb")], ["--env", "no" + evil], ["-" + evil]):
        said(*size, *wrong, "-o", "out.exr", code=1)
    said("--merge", evil, "-o", "b" + evil, code=0)
    # Attributes of the same length: those of a picture of a file of ten letters.
    floor().save(pathtracer.folder / "scene1.glb")
    begun = pathtracer.render(*size, "--scene", "scene1.glb")
    put(begun, begun.read_bytes().replace(b"scene1.glb", b"\x1b]0;1m.glb"))
    assert "]0;1m.glb" in said("--resume", begun, "--spp", 2, "-o", "out.exr", code=1)
    said("--merge", begun, pathtracer.render(*size), "-o", "out.exr", code=1)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux keeps the bound")
def test_a_scene_that_takes_more_than_max_memory(pathtracer):
    """Two million triangles, which take a third of a GiB: with less it ends in one line, with enough it is rendered."""
    if pathtracer.has_address_sanitizer:
        pytest.skip("the address sanitizer takes more")
    x, z = np.meshgrid(np.arange(1000), np.arange(1000), indexing="ij")
    i = (1000 * x + z)[:-1, :-1].ravel()
    g = Gltf()
    g.node(mesh=g.mesh(np.stack([x, x * z % 7, z], -1).reshape(-1, 3).astype(np.float32),
                       np.stack([i, i + 1, i + 1001, i, i + 1001, i + 1000], -1).ravel().astype(np.uint32)))
    g.save(pathtracer.folder / "large.glb")
    assert "--max-memory" in run(pathtracer, "--scene", "large.glb", gib=0.25)[1]
    taken, _ = run(pathtracer, "--scene", "large.glb", gib=4, code=0)
    assert 0.25 * 2**30 < taken < 4 * 2**30
