# SPDX-License-Identifier: Apache-2.0
"""Files made to read what is not theirs, to never end or to take all memory: one clear line, soon and with little."""

import io
import json
import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from PIL import Image
from scene_files import FOUR, QUAD, SMALL, Gltf, ball, cornell, encoded, floor, textured_floor, write_exr

MEMORY = 700e6  # bytes; a run takes 35e6 without any of this, this process and its children 150e6


def one_line(pathtracer, *arguments, words=()):
    """Runs what must be refused, with one line, soon, and in little memory; returns the line."""
    said = [words] if isinstance(words, str) else words
    return pathtracer.failure(*arguments, *SMALL, "--spp", 1, "-o", "out.exr", said=said)


def peak_memory(pathtracer, *arguments, code=1):
    """Bytes that a run takes at most, and what it says in its one line."""
    said = pathtracer.folder / "said.txt"
    with open(said, "w") as file:
        process = pathtracer.start(*arguments, *SMALL, "--spp", 1, "-o", "out.exr", stderr=file, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == code, said.read_text()
    assert said.read_text().count("\n") <= 1, said.read_text()
    return usage.ru_maxrss * 1024, said.read_text()


def takes_little(pathtracer, *arguments, words):
    memory, line = peak_memory(pathtracer, *arguments)
    assert words in line
    assert memory < MEMORY, f"{memory / 1e6:.0f} MB: {line}"


# ---- Files that are none


def apart(pathtracer, buffer="a.bin", image=None, folder="."):
    """A textured floor whose buffer and picture are files with these names."""
    g = textured_floor(lambda g: g.texture(FOUR))
    if image:
        g.json["images"] = [{"uri": image}]
    path = pathtracer.folder / folder / "scene.gltf"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps(g.document(uri=buffer)))
    return path, bytes(g.bytes)


def obj(pathtracer, library, picture_name="a.png", folder="."):
    path = pathtracer.folder / folder / "scene.obj"
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"mtllib {library}\nusemtl a\nv -9 -9 0\nv 9 -9 0\nv 0 9 0\nvt 0 0\nf 1/1 2/1 3/1\n")
    return path, f"newmtl a\nmap_Kd {picture_name}\n"


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_only_regular_files_are_read(pathtracer, kind):
    """What else there is may never end. Devices are outside of all folders, and so allowed here."""

    def put(name):
        path = pathtracer.folder / name
        if kind == "pipe":
            os.mkfifo(path)
        elif kind == "folder":
            path.mkdir()
        else:
            path.symlink_to("/dev/zero")

    words = "not a regular file"
    for name in ("a.bin", "a.png", "a.mtl", "a.exr", "whole.glb", "whole.obj"):
        put(name)
    outside = ["--allow-outside"]
    one_line(pathtracer, "--scene", apart(pathtracer)[0], *outside, words=["a.bin", words])
    scene, data = apart(pathtracer, "b.bin", "a.png")
    (pathtracer.folder / "b.bin").write_bytes(data)
    one_line(pathtracer, "--scene", scene, *outside, words=["a.png", words])
    one_line(pathtracer, "--scene", obj(pathtracer, "a.mtl")[0], *outside, words=["a.mtl", words])
    scene, material = obj(pathtracer, "b.mtl")
    (pathtracer.folder / "b.mtl").write_text(material)
    one_line(pathtracer, "--scene", scene, *outside, words=["a.png", words])
    for name in ("whole.glb", "whole.obj"):
        one_line(pathtracer, "--scene", name, words=[name, words])
    for option in ("--env", "--reference", "--resume", "--merge"):
        one_line(pathtracer, option, "a.exr", words=["a.exr", words])
    one_line(pathtracer, "--sampler", "mask", "--mask", "a.png", words=["a.png", words])


# ---- Files elsewhere


@pytest.mark.parametrize("way", ["../a", "sub/../../a", "%2e%2e/a", "{folder}/a", "link", "linked/a"])
def test_a_scene_reads_files_below_its_folder_only(pathtracer, way):
    """By whatever way their names lead there; with --allow-outside it reads them."""
    name = way.format(folder=pathtracer.folder)
    (pathtracer.folder / "in").mkdir()
    (pathtracer.folder / "in/sub").mkdir()
    (pathtracer.folder / "in/linked").symlink_to("..")
    for end in ("bin", "png", "mtl"):
        (pathtracer.folder / f"in/link.{end}").symlink_to(f"../a.{end}")
    words = "outside the scene's folder; use --allow-outside"
    scene, data = apart(pathtracer, f"{name}.bin", f"{name}.png", "in")
    (pathtracer.folder / "a.bin").write_bytes(data)
    (pathtracer.folder / "a.png").write_bytes(encoded(FOUR))
    one_line(pathtracer, "--scene", scene, words=[f"{name}.bin".replace("%2e", "."), words])
    assert pathtracer.image("--scene", scene, "--allow-outside", *SMALL, "--spp", 1).max() > 0
    scene, data = apart(pathtracer, "b.bin", f"{name}.png", "in")
    (pathtracer.folder / "in/b.bin").write_bytes(data)
    one_line(pathtracer, "--scene", scene, words=[f"{name}.png", words])
    if "%" in way:
        return
    scene, material = obj(pathtracer, f"{name}.mtl", folder="in")
    (pathtracer.folder / "a.mtl").write_text(material)
    one_line(pathtracer, "--scene", scene, words=[f"{name}.mtl", words])
    scene, material = obj(pathtracer, "b.mtl", f"{name}.png", folder="in")
    (pathtracer.folder / "in/b.mtl").write_text(material)
    one_line(pathtracer, "--scene", scene, words=[f"{name}.png", words])
    assert pathtracer.image("--scene", scene, "--allow-outside", *SMALL, "--spp", 1).max() > 0


def test_ways_that_lead_back_are_taken(pathtracer):
    """Dots and links that stay below the folder, and a folder that is a link itself."""
    scene, data = apart(pathtracer, "sub/../link.bin", "sub/a%20b.png", "in")
    (pathtracer.folder / "in/sub").mkdir()
    (pathtracer.folder / "in/a.bin").write_bytes(data)
    (pathtracer.folder / "in/link.bin").symlink_to("a.bin")
    (pathtracer.folder / "in/sub/a b.png").write_bytes(encoded(FOUR))
    (pathtracer.folder / "door").symlink_to("in")
    plain = pathtracer.image("--scene", scene, *SMALL, "--spp", 1)
    for way in ("door/scene.gltf", "in/sub/../scene.gltf"):
        np.testing.assert_array_equal(pathtracer.image("--scene", way, *SMALL, "--spp", 1), plain)


def test_nothing_is_taken_from_the_current_folder(pathtracer):
    scene, data = apart(pathtracer, "a.bin", folder="in")
    (pathtracer.folder / "a.bin").write_bytes(data)
    one_line(pathtracer, "--scene", scene, words="buffer a.bin: there is no such file")


def test_what_names_are_made_of(pathtracer):
    """A zero hides no part of one; neither it nor what moves a terminal's cursor is printed."""
    scene, data = apart(pathtracer, "../a.bin\0/../in/a.bin", folder="in")
    (pathtracer.folder / "a.bin").write_bytes(data)
    one_line(pathtracer, "--scene", scene, words="buffer ../a.bin?/../in/a.bin: has a zero byte in its name")
    scene, _ = apart(pathtracer, "\x1b[2J\n" + "long" * 1000)
    assert len(one_line(pathtracer, "--scene", scene, words="buffer ?[2J?longlong")) < 500


# ---- More than a file can hold


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width, height, depth=8, colour=6, data=b""):
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def test_accessors_without_bytes(pathtracer):
    """A count that no buffer has to fill, alone and with a sparse part."""
    count = {"componentType": 5126, "type": "VEC3", "count": 2**26}
    g = floor()
    g.json["accessors"][0] = count
    takes_little(pathtracer, "--scene", g.save(pathtracer.folder / "a.glb"), words="positions; at most")
    g = floor()
    indices = {"bufferView": g.view(struct.pack("<I", 0)), "componentType": 5125}
    values = {"bufferView": g.view(bytes(12))}
    g.json["accessors"][0] = {**count, "sparse": {"count": 1, "indices": indices, "values": values}}
    path = g.save(pathtracer.folder / "a.glb")
    assert path.stat().st_size < 1100
    takes_little(pathtracer, "--scene", path, words="positions; at most")


def test_few_sparse_values_are_read_still(pathtracer, even_sky):
    """The floor's corners as sparse values over a hundred thousand zeros."""
    g = floor()
    indices = {"bufferView": g.view(np.arange(4, dtype=np.uint32).tobytes()), "componentType": 5125}
    values = {"bufferView": g.view(QUAD.tobytes())}
    sparse = {"count": 4, "indices": indices, "values": values}
    whole = pathtracer.image("--scene", g.save(pathtracer.folder / "a.glb"), *SMALL, "--spp", 1, "--env", even_sky)
    g.json["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 10**5, "sparse": sparse}
    path = g.save(pathtracer.folder / "b.glb")
    image = pathtracer.image("--scene", path, *SMALL, "--spp", 1, "--env", even_sky)
    np.testing.assert_allclose(image, whole, atol=1e-4)


def test_one_mesh_many_times(pathtracer):
    """Nodes and primitives that use the same bytes again and again."""
    g = Gltf()
    mesh = g.mesh(np.random.default_rng(0).random((5000, 3), np.float32), np.arange(3000, dtype=np.uint16))
    for _ in range(1500):
        g.node(mesh=mesh)
    takes_little(pathtracer, "--scene", g.save(pathtracer.folder / "a.glb"), words="vertices, too many for a file")
    g.json["meshes"][mesh]["primitives"] *= 1500
    g.json["nodes"] = [{"mesh": mesh}]
    g.json["scenes"][0]["nodes"] = [0]
    takes_little(pathtracer, "--scene", g.save(pathtracer.folder / "a.glb"), words="vertices, too many for a file")


def test_one_chunk_for_many_buffers(pathtracer):
    """Each buffer of a GLB that names no file would be a copy of the chunk, however the name is left out."""
    g = floor()
    g.bytes += bytes(1 << 20)
    buffer = f'{{"byteLength": {len(g.bytes)}}}'
    others = (
        "",
        ', "uri": ""',
        ', "uri": "a.bin", "uri": ""',
        ', "extras": {"uri": "a.bin"}',
        r', "uri": "a.bin", "\u0075ri": ""',
    )
    for key in ("buffers", r"b\u0075ffers"):
        for other in others:
            text = json.dumps(g.document()).replace('"buffers"', f'"{key}"').replace(
                buffer, ", ".join([buffer] + [buffer[:-1] + other + "}"] * 2000)
            )
            text = text.encode() + b" " * (-len(text) % 4)
            data = bytes(g.bytes) + b"\0" * (-len(g.bytes) % 4)
            chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
            path = pathtracer.folder / "a.glb"
            path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
            escaped = "\\" in key + other
            takes_little(pathtracer, "--scene", path, words="escaped" if escaped else "buffer without a URI")


@pytest.mark.parametrize(
    "text, words",
    [
        ('"materials": [' + ",".join(["{}"] * 65537) + "]", "materials"),
        ('"nodes": [' + ",".join(["{}"] * (2**20 + 1)) + "]", "JSON objects"),
        ('"extras": [' + ",".join("0" * (2**23 + 2)) + "]", "JSON values"),
    ],
)
def test_short_texts_of_many_things(pathtracer, text, words):
    path = pathtracer.folder / "a.gltf"
    path.write_text(f'{{"asset": {{"version": "2.0"}}, {text}}}')
    takes_little(pathtracer, "--scene", path, words=words)


def test_pictures_that_claim_more_than_they_hold(pathtracer):
    bmp = b"BM" + bytes(16) + struct.pack("<ii", 8192, 8192) + bytes(60)
    tga = bytes([0, 0, 10]) + bytes(9) + struct.pack("<HHBB", 8192, 8192, 32, 0) + bytes(60)
    frame = struct.pack(">BBHBHHB", 255, 0xC0, 17, 8, 8192, 8192, 3) + bytes(60)
    for picture in (png(8192, 8192), png(8192, 8192, 1, 0), b"\xff\xd8" + frame, bmp, tga):
        takes_little(pathtracer, "--scene", with_picture(pathtracer, picture), words="8192x8192 texels, more than its")


def with_picture(pathtracer, picture):
    """A scene with this texture."""
    g = textured_floor(lambda g: g.texture(FOUR))
    g.json["images"][0]["bufferView"] = g.view(picture)
    return g.save(pathtracer.folder / "a.glb")


@pytest.mark.parametrize("kind", [b"IDAT", b"PLTE", b"tRNS", b"iCCP", b"iTXt", b"aaaa"])
@pytest.mark.parametrize("place", ["before", "after"])
def test_png_chunks_that_claim_more_than_there_is(pathtracer, kind, place):
    """Before the texels of a picture or of a mask, and after them."""
    whole = png(1, 1, data=zlib.compress(bytes(5)))
    for size in (1000, 2**30):
        picture = whole[: 33 if place == "before" else -12] + struct.pack(">I", size) + kind + bytes(90)
        takes_little(pathtracer, "--scene", with_picture(pathtracer, picture), words="is cut short")
        (pathtracer.folder / "a.png").write_bytes(picture)
        takes_little(pathtracer, "--sampler", "mask", "--mask", "a.png", words="a.png: is cut short")


def test_png_data_that_never_ends(pathtracer):
    """A single texel, and then 2 GiB of zeros in 2 MB."""
    packer, size = zlib.compressobj(9), 1 << 31
    start = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    checksum = struct.pack(">HH", size % 65521, 1)  # Adler-32 of so many zeros
    # After a full flush the same bytes decompress to the same megabyte; the first two are the header.
    data = start + start[2:] * (size // (1 << 20) - 1) + b"\3\0" + checksum
    takes_little(pathtracer, "--scene", with_picture(pathtracer, png(1, 1, data=data)), words="is damaged")


def test_jpeg_scans_without_data(pathtracer):
    """Each would go over the whole image once more."""
    segment = lambda marker, body: struct.pack(">BBH", 255, marker, len(body) + 2) + body
    tables = segment(0xDB, b"\0" + b"\1" * 64) + segment(0xC4, b"\0\1" + bytes(16))
    frame = segment(0xC2, struct.pack(">BHHBBBB", 8, 1024, 1024, 1, 1, 0x11, 0))
    scan = segment(0xDA, bytes([1, 1, 0, 0, 0, 0]))
    for scans, code in ((100, 0), (101, 1), (9999, 1)):
        picture = b"\xff\xd8" + tables + frame + scan * scans + bytes(1000) + b"\xff\xd9"
        line = peak_memory(pathtracer, "--scene", with_picture(pathtracer, picture), code=code)[1]
        assert code == 0 or f"has {scans} scans; at most 100 of this extent are read" in line


@pytest.mark.parametrize("progressive", [False, True])
def test_jpeg_that_is_cut_short(pathtracer, progressive):
    """What is there is shown, and a line says so, unless the cut makes it no JPEG at all."""
    stream = io.BytesIO()
    pixels = np.random.default_rng(1).integers(256, size=(64, 64, 3), dtype=np.uint8)
    Image.fromarray(pixels).save(stream, "JPEG", quality=95, progressive=progressive)
    whole = stream.getvalue()
    assert peak_memory(pathtracer, "--scene", with_picture(pathtracer, whole), code=0)[1] == ""
    for size in range(len(whole) // 2, len(whole), len(whole) // 9):
        done = pathtracer.run("--scene", with_picture(pathtracer, whole[:size]), *SMALL, "--spp", 1, "-o", "out.exr")
        said = "image 0 is cut short" if done.returncode == 0 else "image 0: is damaged"
        assert done.stderr.count("\n") == 1 and said in done.stderr, done.stderr
    # The same in an OBJ
    path, materials = obj(pathtracer, "a.mtl", "half.jpg")
    (pathtracer.folder / "a.mtl").write_text(materials)
    (pathtracer.folder / "half.jpg").write_bytes(whole[:-100])
    assert "half.jpg is cut short" in peak_memory(pathtracer, "--scene", path, code=0)[1]


def test_even_pictures_are_read_still(pathtracer):
    """The most that deflate makes of a byte."""
    for depth, colour, row in ((8, 6, 4 * 2048), (1, 0, 2048 // 8)):
        picture = png(2048, 2048, depth, colour, zlib.compress(bytes((row + 1) * 2048), 9))
        pathtracer.render("--scene", with_picture(pathtracer, picture), *SMALL, "--spp", 1)


def test_one_picture_many_times(pathtracer):
    """Textures that share a picture are decoded one by one."""
    data = zlib.compress(bytes((4 * 4096 + 1) * 4096), 9)
    g = textured_floor(lambda g: g.texture(FOUR))
    g.json["images"][0]["bufferView"] = g.view(png(4096, 4096, 8, 6, data))
    primitives = g.json["meshes"][0]["primitives"]
    for _ in range(8):
        texture = g.add("textures", source=0)
        material = g.add("materials", pbrMetallicRoughness={"baseColorTexture": {"index": texture}})
        primitives.append({**primitives[0], "material": material})
    one_line(pathtracer, "--scene", g.save(pathtracer.folder / "a.glb"), words="texels, too many for a file of this size")


def test_material_files_are_read_once(pathtracer):
    """By whatever names they go."""
    names = [f"{'./' * (i % 20)}{'.//' * (i // 20)}a.mtl" for i in range(400)]
    path, _ = obj(pathtracer, "\nmtllib ".join(names))
    (pathtracer.folder / "a.mtl").write_text("".join(f"newmtl m{i}\nKd 1 1 1\n" for i in range(5000)))
    assert peak_memory(pathtracer, "--scene", path, code=0)[0] < MEMORY


# ---- EXR


def attribute(name, kind, value):
    return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value


def exr(width=8, height=8, compression=3, extra=b"", data=b"", flags=0):
    channels = b"".join(c + b"\0" + struct.pack("<iIii", 1, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = attribute("channels", "chlist", channels) + attribute("compression", "compression", bytes([compression]))
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0") + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", bytes(8))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + extra
    return struct.pack("<II", 20000630, 2 | flags) + header + b"\0" + data


START = struct.pack("<II", 20000630, 2)
HOSTILE_EXR = {
    "an attribute of 1.5 GiB": (START + b"a\0string\0" + struct.pack("<i", 0x60000000) + bytes(40), "cut short"),
    "a negative size": (START + b"a\0string\0" + struct.pack("<i", -1) + bytes(40), "cut short"),
    "a name without an end": (START + b"a" * 400, "unterminated name"),
    "a header cut short": (exr()[:200], "cut short"),
    "nothing after its header": (exr(16384, 8192), "16384x8192 pixels, more than its"),
    "a wide row": (exr(2**24, 1), "16777216x1 pixels, more than its"),
    "wide blocks": (exr(2**20, 1, 9), "1048576x1 pixels, more than its"),
    "many rows": (exr(1, 2**24, 0), "1x16777216 pixels, more than its"),
    "a large tile": (
        exr(extra=attribute("tiles", "tiledesc", struct.pack("<IIB", 2**16, 2**16, 0)), flags=0x200),
        "8x8 pixels, more than its",
    ),
    # The library reads these by what is in them, and then goes on where that ends.
    "a channel list of another size": (exr()[:24] + b"\x36" + exr()[25:], "damaged"),
    "a window of another size": (exr(extra=attribute("w", "box2i", bytes(15))), "damaged"),
    "a preview of 4 GiB": (exr(extra=attribute("p", "preview", struct.pack("<II", 2**15, 2**15))), "damaged"),
    "a text of 1 GiB in a list": (exr(extra=attribute("t", "stringvector", struct.pack("<I", 2**30))), "damaged"),
}


@pytest.mark.parametrize("what", HOSTILE_EXR)
def test_exr_headers_that_ask_for_memory(pathtracer, what):
    content, words = HOSTILE_EXR[what]
    (pathtracer.folder / "a.exr").write_bytes(content)
    for option in ("--env", "--merge"):
        memory, line = peak_memory(pathtracer, option, "a.exr")
        assert line.startswith("pathtracer: cannot read the EXR file a.exr: ") and words in line, line
        assert memory < MEMORY


@pytest.mark.parametrize("compression", ["NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"])
def test_even_environments_are_read_still(pathtracer, compression):
    """Where a method makes the most of a byte."""
    write_exr(pathtracer.folder / "a.exr", compression, RGB=np.ones((512, 1024, 3), np.float16))
    image = pathtracer.image(*SMALL, "--scene", "lens", "--spp", 1, "--env", "a.exr", "--max-depth", 0)
    assert image.max() == pytest.approx(1, abs=0.01)


# ---- How far a scene reaches


def test_a_scene_reaches_so_far(pathtracer):
    """Up to 1e10 from its middle a picture is right; beyond, the ray tracer would end the program."""
    plain = pathtracer.image("--scene", cornell().save(pathtracer.folder / "a.glb"), *SMALL, "--spp", 4)
    # Its largest extent is 559.2, from the middle half of that.
    for reach, size in ((0.99e10, 0.99e10 / 279.6), (1.01e10, 1.01e10 / 279.6), (4e12, 4e12 / 279.6)):
        path = cornell(size).save(pathtracer.folder / "b.glb")
        if reach < 1e10:
            np.testing.assert_allclose(pathtracer.image("--scene", path, *SMALL, "--spp", 4), plain, rtol=1e-3)
        else:
            one_line(pathtracer, "--scene", path, words="more than 1e10 from its centre")
    g = Gltf()
    ball(g, g.material())
    g.json["nodes"][0].update(scale=[0.99e10] * 3, translation=[9e14, 0, 0])
    pathtracer.render("--scene", g.save(pathtracer.folder / "b.glb"), *SMALL, "--spp", 4)


def test_lights_beyond_all_bounds_are_left_out(pathtracer):
    for distance in (0.9e15, 1.1e15, 1e19, 1e30):
        g = floor()
        g.light("point", 1, translation=[0, distance, 0])
        path = g.save(pathtracer.folder / "a.glb")
        done = pathtracer.success("--scene", path, *SMALL, "--spp", 1, "--env", "sky", "-o", "out.exr")
        assert ("a light beyond 1e15" in done.stderr) == (distance > 1e15)


# ---- Values and names


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_reference_that_is_not_finite_is_refused(pathtracer, value):
    """Its error would be no number, or seem perfect."""
    picture = np.ones((24, 24, 3), np.float32)
    picture[7, 9, 1] = value
    write_exr(pathtracer.folder / "reference.exr", RGB=picture)
    one_line(pathtracer, "--reference", "reference.exr", "--convergence", "out.csv", words=["reference.exr", "not finite"])
    # Elsewhere than in the crop it does no harm.
    done = pathtracer.success("--reference", "reference.exr", *SMALL, "--crop", "0,8,24,24", "--spp", 1, "-o", "out.exr")
    assert "nan" not in done.stdout


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
    said(*size, "--scene", evil, "-o", "out.exr", code=1)
    said(*size, "--scene", evil.replace("exr", "obj"), "-o", "out.exr", code=1)
    said(*size, "--env", "no" + evil, "-o", "out.exr", code=1)
    said(*size, "--resume", "no" + evil, "-o", "out.exr", code=1)
    said(*size, "-" + evil, "-o", "out.exr", code=1)
    said("--merge", evil, "-o", "b" + evil, code=0)
    # Attributes of the same length: those of a picture of a file of ten letters.
    (pathtracer.folder / "scene1.obj").write_text("v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n")
    begun = pathtracer.render(*size, "--scene", "scene1.obj")
    begun.write_bytes(begun.read_bytes().replace(b"scene1.obj", b"\x1b]0;1m.obj"))
    assert "]0;1m.obj" in said("--resume", begun, "--spp", 2, "-o", "out.exr", code=1)
    other = pathtracer.render(*size)
    assert "]0;1m.obj" in said("--merge", begun, other, "-o", "out.exr", code=1)


# ---- A bound for memory


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux keeps the bound")
def test_a_scene_that_takes_more_than_max_memory(pathtracer):
    """Two million triangles, which take a third of a GiB: with less it ends in one line, with enough it is rendered."""
    rows = np.arange(1000)
    points = "\n".join(f"v {x} {z} {(x * z) % 7}" for x in rows for z in rows)
    faces = "\n".join(f"f {i} {i + 1} {i + 1001} {i + 1000}" for x in range(999) for i in range(1000 * x + 1, 1000 * x + 1000))
    (pathtracer.folder / "large.obj").write_text(f"{points}\n{faces}\n")
    assert "--max-memory" in peak_memory(pathtracer, "--scene", "large.obj", "--max-memory", 0.25)[1]
    taken, _ = peak_memory(pathtracer, "--scene", "large.obj", "--max-memory", 4, code=0)
    assert 0.25 * 2**30 < taken < 4 * 2**30
    assert "--max-memory takes GiB" in one_line(pathtracer, "--max-memory", "much")
